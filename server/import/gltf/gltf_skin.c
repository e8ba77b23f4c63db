#include "server/import/gltf/gltf_skin.h"

#include <inttypes.h>
#include <stdlib.h>

#include "server/import/gltf/gltf_accessor.h"
#include "server/import/gltf/gltf_draco.h"

/* A vertex follows at most eight joints: two sets of four. */
enum { SETS = 2, SET_JOINTS = 4 };

struct skin {
    struct affine *joints; /* owned; inverse bind matrix, then the joint's place in the world */
    uint32_t count;
    float *indices[SETS], *weights[SETS]; /* owned; four a vertex; NULL: no such set */
};

static void skin_fini(struct skin *s)
{
    for (int set = 0; set < SETS; set++) {
        free(s->indices[set]);
        free(s->weights[set]);
    }
    free(s->joints);
}

static int read_joint(struct gltf *g, const json_t *joints, const char *place, size_t i,
                      struct affine *out, struct fault *fault)
{
    const json_t *joint = json_array_get(joints, i);
    json_int_t node = json_is_integer(joint) ? json_integer_value(joint) : -1;
    gltf_place at;
    gltf_place_set(at, "%s.joints[%zu]", place, i);
    if (node < 0 || (size_t)node >= gltf_count(g->root, "nodes"))
        return fault_set(fault, ERR_RANGE, at, "it names no node");
    if (!g->nodes.visited[node])
        return fault_set(fault, ERR_MISSING, at, "nodes[%lld] stands nowhere in the scene",
                         (long long)node);
    *out = g->nodes.world[node];
    return 0;
}

/* Multiplies joint i by its inverse bind matrix, column by column in `columns`. */
static int bind_joint(const float *columns, const char *place, size_t i, struct affine *joint,
                      struct fault *fault)
{
    double wide[16];
    struct affine inverse;
    gltf_place at;
    for (int k = 0; k < 16; k++) wide[k] = (double)columns[16 * i + (size_t)k];
    gltf_place_set(at, "%s.inverseBindMatrices[%zu]", place, i);
    if (!affine_from_columns(wide, &inverse) || !affine_is_finite(&inverse))
        return fault_set(fault, ERR_RANGE, at, "its last row is not 0 0 0 1");
    *joint = affine_multiply(joint, &inverse);
    return 0;
}

static int read_bindings(struct gltf *g, const json_t *json, const char *place, struct skin *s,
                         struct fault *fault)
{
    uint32_t accessor, count;
    float *columns = NULL;
    int rc = gltf_index(json, place, "inverseBindMatrices", gltf_count(g->root, "accessors"),
                        &accessor, fault);
    if (rc != 0 || accessor == SCENE_NONE) return rc; /* identities */
    rc = gltf_read_floats(g, accessor, 16, &count, &columns, fault);
    if (rc == 0 && count < s->count)
        rc = fault_set(fault, ERR_MISMATCH, place,
                       "there are %" PRIu32 " inverseBindMatrices for %" PRIu32 " joints", count,
                       s->count);
    for (uint32_t i = 0; rc == 0 && i < s->count; i++)
        rc = bind_joint(columns, place, i, &s->joints[i], fault);
    free(columns);
    return rc;
}

static int read_joints(struct gltf *g, uint32_t index, struct skin *s, struct fault *fault)
{
    const json_t *json, *joints;
    gltf_place place;
    int rc = gltf_item(g->root, "skins", index, &json, place, fault);
    if (rc == 0) rc = gltf_array(json, place, "joints", &joints, fault);
    if (rc != 0) return rc;
    if (json_array_size(joints) == 0)
        return fault_set(fault, ERR_MISSING, place, "a skin has joints");
    if (json_array_size(joints) > gltf_count(g->root, "nodes"))
        return fault_set(fault, ERR_LIMIT, place, "it has %zu joints, more than there are nodes",
                         json_array_size(joints));
    s->count = (uint32_t)json_array_size(joints);
    s->joints = malloc(s->count * sizeof *s->joints);
    if (s->joints == NULL) return fault_set(fault, ERR_MEMORY, place, "no memory for its joints");
    for (size_t i = 0; rc == 0 && i < s->count; i++)
        rc = read_joint(g, joints, place, i, &s->joints[i], fault);
    return rc == 0 ? read_bindings(g, json, place, s, fault) : rc;
}

/* Reads an attribute of four numbers a vertex; NULL when it is absent. */
static int read_four(struct gltf *g, const json_t *attributes, const char *place, const char *key,
                     uint32_t vertices, float **out, struct fault *fault)
{
    uint32_t accessor, count;
    gltf_place at;
    int rc = gltf_index(attributes, place, key, gltf_count(g->root, "accessors"), &accessor, fault);
    if (rc != 0 || accessor == SCENE_NONE) return rc;
    uint32_t components = SET_JOINTS;
    rc = gltf_vertex_floats(g, key, accessor, &components, &count, out, fault);
    if (rc != 0 || count == vertices) return rc;
    gltf_place_set(at, "%s.%s", place, key);
    return fault_set(fault, ERR_MISMATCH, at,
                     "it has %" PRIu32 " elements for %" PRIu32 " vertices", count, vertices);
}

static int read_sets(struct gltf *g, const json_t *primitive, const char *place, uint32_t vertices,
                     struct skin *s, struct fault *fault)
{
    const char *const keys[SETS][2] = {{"JOINTS_0", "WEIGHTS_0"}, {"JOINTS_1", "WEIGHTS_1"}};
    const json_t *attributes = json_object_get(primitive, "attributes");
    gltf_place at;
    int rc = 0;
    gltf_place_set(at, "%s.attributes", place);
    for (int set = 0; rc == 0 && set < SETS; set++) {
        rc = read_four(g, attributes, at, keys[set][0], vertices, &s->indices[set], fault);
        if (rc == 0)
            rc = read_four(g, attributes, at, keys[set][1], vertices, &s->weights[set], fault);
        if (rc == 0 && (s->indices[set] == NULL) != (s->weights[set] == NULL))
            rc = fault_set(fault, ERR_MISSING, at, "it has only one of %s and %s", keys[set][0],
                           keys[set][1]);
    }
    if (json_object_get(attributes, "JOINTS_2") != NULL)
        warnings_add(&g->builder->warnings, place, "joints beyond eight a vertex are ignored");
    if (rc == 0 && s->indices[0] == NULL)
        warnings_add(&g->builder->warnings, place,
                     "its node has a skin, but its vertices name no joints: they follow the first");
    return rc;
}

/* The weighted mean of a vertex's joints; the first joint where no weight is above 0. */
static int blend(const struct skin *s, size_t v, const char *place, struct affine *out,
                 struct fault *fault)
{
    struct affine sum = {{0}};
    double total = 0;
    for (int k = 0; k < SETS * SET_JOINTS; k++) {
        const int set = k / SET_JOINTS;
        if (s->indices[set] == NULL) continue;
        const size_t at = v * SET_JOINTS + (size_t)(k % SET_JOINTS);
        const double weight = (double)s->weights[set][at];
        const double joint = (double)s->indices[set][at];
        if (!(weight > 0)) continue;
        if (!(joint >= 0 && joint < s->count)) {
            gltf_place where;
            gltf_place_set(where, "%s.attributes.JOINTS_%d[%zu]", place, set, v);
            return fault_set(fault, ERR_RANGE, where, "%g is not below the %" PRIu32 " joints",
                             joint, s->count);
        }
        for (int i = 0; i < 12; i++) sum.m[i] += weight * s->joints[(uint32_t)joint].m[i];
        total += weight;
    }
    *out = s->joints[0];
    for (int i = 0; total > 0 && i < 12; i++) out->m[i] = sum.m[i] / total;
    return 0;
}

static void store3(const double from[3], float *to)
{
    double unit[3] = {from[0], from[1], from[2]};
    normalize3(unit); /* as floats its numbers might be none */
    for (int c = 0; c < 3; c++) to[c] = (float)unit[c];
}

/* Moves one vertex; returns whether it is mirrored. */
static bool move_vertex(const struct affine *to_world, struct mesh *mesh, size_t v)
{
    const double turn = affine_determinant(to_world) < 0 ? -1 : 1;
    float p[3];
    double n[3];
    affine_point(to_world, mesh->positions + 3 * v, p);
    for (size_t c = 0; c < 3; c++) mesh->positions[3 * v + c] = p[c];
    if (mesh->normals != NULL) {
        const float *from = mesh->normals + 3 * v;
        affine_normal(to_world, (double[3]){turn * from[0], turn * from[1], turn * from[2]}, n);
        store3(n, mesh->normals + 3 * v);
    }
    if (mesh->tangents != NULL) {
        const float *from = mesh->tangents + 4 * v;
        affine_direction(to_world, (double[3]){from[0], from[1], from[2]}, n);
        store3(n, mesh->tangents + 4 * v);
        if (turn < 0) mesh->tangents[4 * v + 3] = -mesh->tangents[4 * v + 3];
    }
    return turn < 0;
}

static int move_vertices(const struct skin *s, const char *place, struct mesh *mesh,
                         struct fault *fault)
{
    uint32_t mirrored = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        struct affine to_world;
        int rc = blend(s, v, place, &to_world, fault);
        if (rc != 0) return rc;
        mirrored += move_vertex(&to_world, mesh, v);
    }
    if (mirrored > mesh->vertex_count / 2) mesh_turn_over(mesh);
    return 0;
}

int gltf_skin_apply(struct gltf *g, uint32_t skin, const json_t *primitive, const char *place,
                    struct mesh *mesh, struct fault *fault)
{
    struct skin s = {0};
    int rc = read_joints(g, skin, &s, fault);
    if (rc == 0) rc = read_sets(g, primitive, place, mesh->vertex_count, &s, fault);
    if (rc == 0) rc = move_vertices(&s, place, mesh, fault);
    skin_fini(&s);
    return rc;
}
