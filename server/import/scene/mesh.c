#include "server/import/scene/mesh.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int out_of_memory(struct fault *fault)
{
    return fault_set(fault, ERR_MEMORY, "meshes", "no memory for a mesh");
}

void mesh_fini(struct mesh *mesh)
{
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->tangents);
    free(mesh->uvs[0]);
    free(mesh->uvs[1]);
    free(mesh->colors);
    free(mesh->triangles);
    memset(mesh, 0, sizeof *mesh);
}

/* The vertex arrays and how many floats of each belong to a vertex. */
enum { VERTEX_ARRAYS = 6 };
static const size_t array_width[VERTEX_ARRAYS] = {3, 3, 4, 2, 2, 4};

static void list_arrays(struct mesh *mesh, float **arrays[VERTEX_ARRAYS])
{
    arrays[0] = &mesh->positions;
    arrays[1] = &mesh->normals;
    arrays[2] = &mesh->tangents;
    arrays[3] = &mesh->uvs[0];
    arrays[4] = &mesh->uvs[1];
    arrays[5] = &mesh->colors;
}

int mesh_gather(struct mesh *mesh, const uint32_t *source, uint32_t count, struct fault *fault)
{
    float **arrays[VERTEX_ARRAYS];
    list_arrays(mesh, arrays);
    for (int a = 0; a < VERTEX_ARRAYS; a++) {
        size_t width = array_width[a];
        float *old = *arrays[a];
        if (old == NULL) continue;
        float *gathered = malloc(((size_t)count * width + 1) * sizeof(float));
        if (gathered == NULL) return out_of_memory(fault);
        for (size_t v = 0; v < count; v++)
            memcpy(gathered + v * width, old + (size_t)source[v] * width, width * sizeof(float));
        free(old);
        *arrays[a] = gathered;
    }
    mesh->vertex_count = count;
    return 0;
}

int mesh_copy(const struct mesh *mesh, struct mesh *out, struct fault *fault)
{
    *out = *mesh;
    float **arrays[VERTEX_ARRAYS];
    list_arrays(out, arrays);
    size_t triangle_bytes = (size_t)mesh->triangle_count * 3 * sizeof(uint32_t);
    bool ok = (out->triangles = malloc(triangle_bytes + 1)) != NULL;
    if (ok) memcpy(out->triangles, mesh->triangles, triangle_bytes);
    for (int a = 0; a < VERTEX_ARRAYS; a++) {
        float *from = *arrays[a];
        if (from == NULL) continue;
        size_t size_bytes = (size_t)mesh->vertex_count * array_width[a] * sizeof(float);
        *arrays[a] = ok ? malloc(size_bytes + 1) : NULL;
        ok = *arrays[a] != NULL;
        if (ok) memcpy(*arrays[a], from, size_bytes);
    }
    if (ok) return 0;
    mesh_fini(out);
    return out_of_memory(fault);
}

/* *at names the first float of `count` whose magnitude is not at most `limit`. */
static bool all_within(const float *values, size_t count, float limit, size_t *at)
{
    for (size_t i = 0; i < count; i++) {
        if (fabsf(values[i]) <= limit) continue;
        *at = i;
        return false;
    }
    return true;
}

static int check_array(const float *values, uint32_t vertices, size_t width, float limit,
                       const char *place, const char *name, struct fault *fault)
{
    size_t at;
    if (values == NULL || all_within(values, vertices * width, limit, &at)) return 0;
    char pointer[LIMIT_POINTER_BYTES];
    snprintf(pointer, sizeof pointer, "%.180s.%s[%zu]", place, name, at / width);
    double value = (double)values[at];
    if (!isfinite(value))
        return fault_set(fault, ERR_NOT_FINITE, pointer, "component %zu is %g", at % width, value);
    return fault_set(fault, ERR_LIMIT, pointer, "component %zu is %g, beyond %g", at % width, value,
                     (double)limit);
}

static int check_indices(const struct mesh *mesh, const char *place, struct fault *fault)
{
    size_t count = 3 * (size_t)mesh->triangle_count;
    for (size_t i = 0; i < count; i++) {
        if (mesh->triangles[i] < mesh->vertex_count) continue;
        char pointer[LIMIT_POINTER_BYTES];
        snprintf(pointer, sizeof pointer, "%.180s.indices[%zu]", place, i);
        return fault_set(fault, ERR_RANGE, pointer,
                         "%" PRIu32 " is not below the %" PRIu32 " vertices", mesh->triangles[i],
                         mesh->vertex_count);
    }
    return 0;
}

void mesh_triangle_normal(const float *positions, const uint32_t triangle[3], double out[3])
{
    double e[2][3];
    const float *p = positions + 3 * (size_t)triangle[0];
    for (int k = 0; k < 2; k++)
        for (int c = 0; c < 3; c++)
            e[k][c] = (double)positions[3 * (size_t)triangle[k + 1] + (size_t)c] - (double)p[c];
    cross3(e[0], e[1], out);
}

static bool normalize_floats(float v[3])
{
    double d[3] = {v[0], v[1], v[2]};
    if (!normalize3(d)) return false;
    for (int c = 0; c < 3; c++) v[c] = (float)d[c];
    return true;
}

/* Adds every triangle's normal, weighted by its area, to its three vertices. */
static void sum_triangle_normals(const struct mesh *mesh, double *sums)
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *triangle = mesh->triangles + 3 * t;
        double n[3];
        mesh_triangle_normal(mesh->positions, triangle, n);
        for (size_t i = 0; i < 9; i++) sums[3 * (size_t)triangle[i / 3] + i % 3] += n[i % 3];
    }
}

static int repair_normals(struct mesh *mesh, struct fault *fault)
{
    double *sums = calloc(3 * (size_t)mesh->vertex_count + 1, sizeof *sums);
    if (sums == NULL) return out_of_memory(fault);
    sum_triangle_normals(mesh, sums);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        float *normal = mesh->normals + 3 * v;
        double *n = sums + 3 * v;
        if (normalize_floats(normal)) continue;
        if (!normalize3(n)) n[2] = 1; /* only degenerate triangles meet here: any will do */
        for (int c = 0; c < 3; c++) normal[c] = (float)n[c];
    }
    free(sums);
    return 0;
}

static int normalize_normals(struct mesh *mesh, const char *place, struct warnings *warnings,
                             struct fault *fault)
{
    bool whole = true;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        if (!normalize_floats(mesh->normals + 3 * v)) whole = false;
    if (whole) return 0;
    warnings_add(warnings, place, "normals of length zero are replaced by those of the triangles");
    return repair_normals(mesh, fault);
}

void mesh_any_tangent(const float normal[3], double out[3])
{
    int least = fabsf(normal[0]) <= fabsf(normal[1]) ? 0 : 1;
    if (fabsf(normal[2]) < fabsf(normal[least])) least = 2;
    double axis[3] = {0, 0, 0};
    axis[least] = 1; /* n is a unit vector, so that its cross product with this axis is not zero */
    cross3((double[3]){normal[0], normal[1], normal[2]}, axis, out);
    normalize3(out);
}

/* The tangent at vertex v becomes t, or any when t has no direction. */
static void set_tangent(struct mesh *mesh, size_t v, double t[3])
{
    if (!normalize3(t)) mesh_any_tangent(mesh->normals + 3 * v, t);
    for (size_t c = 0; c < 3; c++) mesh->tangents[4 * v + c] = (float)t[c];
}

static void normalize_tangents(struct mesh *mesh)
{
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        float *tangent = mesh->tangents + 4 * v;
        set_tangent(mesh, v, (double[3]){tangent[0], tangent[1], tangent[2]});
        tangent[3] = tangent[3] < 0 ? -1.0f : 1.0f;
    }
}

static void clamp_colors(struct mesh *mesh)
{
    for (size_t i = 0; i < 4 * (size_t)mesh->vertex_count; i++)
        mesh->colors[i] = fminf(fmaxf(mesh->colors[i], 0), 1);
}

int mesh_check(struct mesh *mesh, const char *place, struct warnings *warnings, struct fault *fault)
{
    const struct {
        const float *values;
        size_t width;
        float limit;
        const char *name;
    } rows[] = {
        {mesh->positions, 3, LIMIT_COORDINATE, "positions"},
        {mesh->normals, 3, LIMIT_COORDINATE, "normals"},
        {mesh->tangents, 4, LIMIT_COORDINATE, "tangents"},
        {mesh->uvs[0], 2, LIMIT_COORDINATE, "uvs"},
        {mesh->uvs[1], 2, LIMIT_COORDINATE, "uvs"},
        {mesh->colors, 4, LIMIT_COORDINATE, "colours"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        int rc = check_array(rows[i].values, mesh->vertex_count, rows[i].width, rows[i].limit,
                             place, rows[i].name, fault);
        if (rc != 0) return rc;
    }
    int rc = check_indices(mesh, place, fault);
    if (rc != 0) return rc;
    if (mesh->normals != NULL) rc = normalize_normals(mesh, place, warnings, fault);
    if (mesh->normals == NULL) { /* tangents mean nothing without them */
        free(mesh->tangents);
        mesh->tangents = NULL;
    }
    if (rc == 0 && mesh->tangents != NULL) normalize_tangents(mesh);
    if (mesh->colors != NULL) clamp_colors(mesh);
    return rc;
}

int mesh_compact(struct mesh *mesh, struct fault *fault)
{
    size_t corners = 3 * (size_t)mesh->triangle_count;
    uint32_t *renamed = calloc((size_t)mesh->vertex_count + 1, sizeof *renamed);
    if (renamed == NULL) return out_of_memory(fault);
    for (size_t i = 0; i < corners; i++) renamed[mesh->triangles[i]] = 1;
    uint32_t used = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; v++) used += renamed[v];
    int rc = 0;
    uint32_t *source = NULL;
    if (used == mesh->vertex_count) goto done;
    source = malloc(((size_t)used + 1) * sizeof *source);
    if (source == NULL) {
        rc = out_of_memory(fault);
        goto done;
    }
    uint32_t next = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        if (renamed[v] == 0) continue;
        source[next] = v;
        renamed[v] = next++;
    }
    for (size_t i = 0; i < corners; i++) mesh->triangles[i] = renamed[mesh->triangles[i]];
    rc = mesh_gather(mesh, source, used, fault);
done:
    free(source);
    free(renamed);
    return rc;
}

static int unweld(struct mesh *mesh, const char *place, struct fault *fault)
{
    if (mesh->triangle_count > LIMIT_VERTICES / 3)
        return fault_set(fault, ERR_LIMIT, place, "it would need more than %u vertices",
                         LIMIT_VERTICES);
    uint32_t corners = 3 * mesh->triangle_count;
    int rc = mesh_gather(mesh, mesh->triangles, corners, fault);
    for (uint32_t i = 0; rc == 0 && i < corners; i++) mesh->triangles[i] = i;
    return rc;
}

int mesh_flatten(struct mesh *mesh, const char *place, struct fault *fault)
{
    int rc = unweld(mesh, place, fault);
    if (rc != 0) return rc;
    free(mesh->normals);
    mesh->normals = malloc(((size_t)mesh->vertex_count * 3 + 1) * sizeof(float));
    if (mesh->normals == NULL) return out_of_memory(fault);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double n[3];
        mesh_triangle_normal(mesh->positions, mesh->triangles + 3 * t, n);
        if (!normalize3(n)) memcpy(n, (double[3]){0, 0, 1}, sizeof n);
        for (size_t k = 0; k < 9; k++) mesh->normals[9 * t + k] = (float)n[k % 3];
    }
    return 0;
}

/* `turn` is the sign of the determinant: the cofactor matrix points to the back of a mirror. */
static void transform_normals(struct mesh *mesh, const struct affine *to_world, double turn)
{
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        float *normal = mesh->normals + 3 * v;
        double n[3];
        affine_normal(to_world, (double[3]){turn * normal[0], turn * normal[1], turn * normal[2]},
                      n);
        if (!normalize3(n)) memcpy(n, (double[3]){0, 0, 1}, sizeof n);
        for (int c = 0; c < 3; c++) normal[c] = (float)n[c];
    }
}

static void transform_tangents(struct mesh *mesh, const struct affine *to_world, double turn)
{
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        float *tangent = mesh->tangents + 4 * v;
        double t[3];
        affine_direction(to_world, (double[3]){tangent[0], tangent[1], tangent[2]}, t);
        set_tangent(mesh, v, t);
        if (turn < 0) tangent[3] = -tangent[3];
    }
}

void mesh_turn_over(struct mesh *mesh)
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *triangle = mesh->triangles + 3 * t, second = triangle[1];
        triangle[1] = triangle[2];
        triangle[2] = second;
    }
}

int mesh_transform(struct mesh *mesh, const struct affine *to_world, const char *place,
                   struct fault *fault)
{
    if (affine_is_identity(to_world)) return 0;
    double turn = affine_determinant(to_world) < 0 ? -1 : 1;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        float p[3];
        affine_point(to_world, mesh->positions + 3 * v, p);
        memcpy(mesh->positions + 3 * v, p, sizeof p);
    }
    if (mesh->normals != NULL) transform_normals(mesh, to_world, turn);
    if (mesh->normals != NULL && mesh->tangents != NULL) transform_tangents(mesh, to_world, turn);
    if (turn < 0) mesh_turn_over(mesh);
    return check_array(mesh->positions, mesh->vertex_count, 3, LIMIT_COORDINATE, place,
                       "positions in the world", fault);
}

/* Appends one array; *first is the index of its first record. */
static int append_array(struct builder *b, enum scene_section section, const void *data,
                        uint32_t count, uint32_t *first, struct fault *fault)
{
    void *at;
    *first = (uint32_t)builder_count(b, section); /* limits.h keeps counts below 2^32 */
    int rc = builder_append(b, section, count, &at, fault);
    if (rc == 0) memcpy(at, data, (size_t)count * scene_record_bytes(section));
    return rc;
}

int mesh_append(const struct mesh *mesh, struct builder *b, struct scene_mesh *out,
                struct fault *fault)
{
    memset(out, 0, sizeof *out);
    out->vertex_count = mesh->vertex_count;
    out->triangle_count = mesh->triangle_count;
    out->first_uv[0] = out->first_uv[1] = SCENE_NONE;
    int rc = append_array(b, SCENE_POSITIONS, mesh->positions, mesh->vertex_count,
                          &out->first_vertex, fault);
    if (rc == 0)
        rc = append_array(b, SCENE_TRIANGLES, mesh->triangles, mesh->triangle_count,
                          &out->first_triangle, fault);
    if (rc == 0 && mesh->normals != NULL) {
        out->flags |= MESH_HAS_NORMALS;
        rc = append_array(b, SCENE_NORMALS, mesh->normals, mesh->vertex_count, &out->first_normal,
                          fault);
    }
    if (rc == 0 && mesh->tangents != NULL) {
        out->flags |= MESH_HAS_TANGENTS;
        rc = append_array(b, SCENE_TANGENTS, mesh->tangents, mesh->vertex_count,
                          &out->first_tangent, fault);
    }
    if (rc == 0 && mesh->colors != NULL) {
        out->flags |= MESH_HAS_COLORS;
        rc = append_array(b, SCENE_COLORS, mesh->colors, mesh->vertex_count, &out->first_color,
                          fault);
    }
    for (int set = 0; rc == 0 && set < 2; set++) {
        if (mesh->uvs[set] != NULL)
            rc = append_array(b, SCENE_UVS, mesh->uvs[set], mesh->vertex_count, &out->first_uv[set],
                              fault);
    }
    return rc;
}
