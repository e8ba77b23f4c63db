#include "server/import/scene/tangents.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Twice the signed area of a triangle in texture space; its sign tells mirrored halves apart. */
static double uv_area(const float *uvs, const uint32_t *triangle)
{
    const float *a = uvs + 2 * (size_t)triangle[0], *b = uvs + 2 * (size_t)triangle[1],
                *c = uvs + 2 * (size_t)triangle[2];
    return ((double)b[0] - (double)a[0]) * ((double)c[1] - (double)a[1]) -
           ((double)c[0] - (double)a[0]) * ((double)b[1] - (double)a[1]);
}

/* copy[v]: the vertex that triangles of negative area use instead of v. Returns the new vertex
 * count. */
static uint64_t plan_copies(const struct mesh *mesh, const float *uvs, uint8_t *seen,
                            uint32_t *copy)
{
    enum { DOWN = 1, UP = 2 };
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *triangle = mesh->triangles + 3 * t;
        uint8_t side = uv_area(uvs, triangle) < 0 ? UP : DOWN;
        for (int k = 0; k < 3; k++) seen[triangle[k]] |= side;
    }
    uint64_t total = mesh->vertex_count;
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
        copy[v] = seen[v] == (DOWN | UP) ? (uint32_t)total++ : v;
    return total;
}

/* Gives the triangles of negative area their copies. */
static int apply_copies(struct mesh *mesh, int set, const uint32_t *copy, uint32_t total,
                        struct fault *fault)
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *triangle = mesh->triangles + 3 * t;
        if (uv_area(mesh->uvs[set], triangle) >= 0) continue;
        for (int k = 0; k < 3; k++) triangle[k] = copy[triangle[k]];
    }
    uint32_t *source = malloc(((size_t)total + 1) * sizeof *source);
    if (source == NULL) return fault_set(fault, ERR_MEMORY, "meshes", "no memory for tangents");
    for (uint32_t v = 0; v < mesh->vertex_count; v++) source[copy[v]] = source[v] = v;
    int rc = mesh_gather(mesh, source, total, fault);
    free(source);
    return rc;
}

/* Doubles the vertices that triangles of both orientations use. */
static int split_mirrored(struct mesh *mesh, int set, const char *place, struct fault *fault)
{
    uint8_t *seen = calloc((size_t)mesh->vertex_count + 1, 1);
    uint32_t *copy = malloc(((size_t)mesh->vertex_count + 1) * sizeof *copy);
    int rc = 0;
    if (seen == NULL || copy == NULL) {
        rc = fault_set(fault, ERR_MEMORY, place, "no memory for tangents");
        goto done;
    }
    uint64_t total = plan_copies(mesh, mesh->uvs[set], seen, copy);
    if (total > LIMIT_VERTICES)
        rc = fault_set(fault, ERR_LIMIT, place, "its tangents need %" PRIu64 " vertices", total);
    else if (total > mesh->vertex_count)
        rc = apply_copies(mesh, set, copy, (uint32_t)total, fault);
done:
    free(copy);
    free(seen);
    return rc;
}

/* The direction of growing u in a triangle, unit. False where the texture is degenerate. Solves
 * e1 = du1 T + dv1 B, e2 = du2 T + dv2 B for T. */
static bool triangle_tangent(const struct mesh *mesh, int set, const uint32_t *triangle,
                             double out[3])
{
    double area = uv_area(mesh->uvs[set], triangle);
    const float *uv[3], *p[3];
    for (int k = 0; k < 3; k++) {
        uv[k] = mesh->uvs[set] + 2 * (size_t)triangle[k];
        p[k] = mesh->positions + 3 * (size_t)triangle[k];
    }
    double dv1 = (double)uv[1][1] - (double)uv[0][1], dv2 = (double)uv[2][1] - (double)uv[0][1];
    double sign = area < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++)
        out[c] = sign * (dv2 * ((double)p[1][c] - (double)p[0][c]) -
                         dv1 * ((double)p[2][c] - (double)p[0][c]));
    return area != 0 && normalize3(out);
}

/* The angle of a triangle at corner k, radians. */
static double corner_angle(const struct mesh *mesh, const uint32_t *triangle, int k)
{
    double e[2][3];
    const float *p = mesh->positions + 3 * (size_t)triangle[k];
    for (int j = 0; j < 2; j++) {
        const float *q = mesh->positions + 3 * (size_t)triangle[(k + 1 + j) % 3];
        for (int c = 0; c < 3; c++) e[j][c] = (double)q[c] - (double)p[c];
        if (!normalize3(e[j])) return 0;
    }
    return acos(fmax(-1, fmin(1, dot3(e[0], e[1]))));
}

/* v less its part along the unit vector n. */
static void project_out(const float n[3], double v[3])
{
    const double axis[3] = {n[0], n[1], n[2]};
    double along = dot3(axis, v);
    for (int c = 0; c < 3; c++) v[c] -= along * axis[c];
}

static void sum_tangents(const struct mesh *mesh, int set, double *sums, float *tangents)
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *triangle = mesh->triangles + 3 * t;
        double flat[3];
        bool known = triangle_tangent(mesh, set, triangle, flat);
        /* cross(n, t) * w is "up" in the normal map, where v of glTF grows downwards: a texture
         * that is not mirrored has a negative area here and w = 1. */
        float w = uv_area(mesh->uvs[set], triangle) < 0 ? 1.0f : -1.0f;
        for (int k = 0; k < 3; k++) {
            size_t v = triangle[k];
            tangents[4 * v + 3] = w;
            double tangent[3] = {flat[0], flat[1], flat[2]};
            project_out(mesh->normals + 3 * v, tangent);
            if (!known || !normalize3(tangent)) continue;
            double weight = corner_angle(mesh, triangle, k);
            for (size_t c = 0; c < 3; c++) sums[3 * v + c] += weight * tangent[c];
        }
    }
}

int mesh_make_tangents(struct mesh *mesh, int set, const char *place, struct fault *fault)
{
    int rc = split_mirrored(mesh, set, place, fault);
    if (rc != 0) return rc;
    double *sums = calloc(3 * (size_t)mesh->vertex_count + 1, sizeof *sums);
    float *tangents = calloc(4 * (size_t)mesh->vertex_count + 1, sizeof *tangents);
    if (sums == NULL || tangents == NULL) {
        free(sums);
        free(tangents);
        return fault_set(fault, ERR_MEMORY, place, "no memory for tangents");
    }
    sum_tangents(mesh, set, sums, tangents);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *t = sums + 3 * v;
        project_out(mesh->normals + 3 * v, t);
        if (!normalize3(t)) mesh_any_tangent(mesh->normals + 3 * v, t);
        for (size_t c = 0; c < 3; c++) tangents[4 * v + c] = (float)t[c];
        if (tangents[4 * v + 3] == 0) tangents[4 * v + 3] = 1;
    }
    free(sums);
    free(mesh->tangents);
    mesh->tangents = tangents;
    return 0;
}
