/* EXT_mesh_gpu_instancing: a node whose mesh stands many times, each time moved by itself. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "server/import/gltf/gltf.h"
#include "server/import/gltf/gltf_accessor.h"

struct instancing {
    float *translation, *rotation, *scale; /* owned; NULL: none */
    uint32_t count;
};

static int read_attribute(struct gltf *g, const json_t *attributes, const char *place,
                          const char *key, uint32_t components, struct instancing *s, float **out,
                          struct fault *fault)
{
    uint32_t accessor, count;
    gltf_place at;
    int rc = gltf_index(attributes, place, key, gltf_count(g->root, "accessors"), &accessor, fault);
    if (rc != 0 || accessor == SCENE_NONE) return rc;
    rc = gltf_read_floats(g, accessor, components, &count, out, fault);
    if (rc != 0) return rc;
    gltf_place_set(at, "%s.%s", place, key);
    if (s->count != 0 && s->count != count)
        return fault_set(fault, ERR_MISMATCH, at,
                         "it has %" PRIu32 " instances, while another attribute has %" PRIu32,
                         count, s->count);
    s->count = count;
    return 0;
}

static int read_attributes(struct gltf *g, const json_t *attributes, const char *place,
                           struct instancing *s, struct fault *fault)
{
    int rc = read_attribute(g, attributes, place, "TRANSLATION", 3, s, &s->translation, fault);
    if (rc == 0) rc = read_attribute(g, attributes, place, "ROTATION", 4, s, &s->rotation, fault);
    if (rc == 0) rc = read_attribute(g, attributes, place, "SCALE", 3, s, &s->scale, fault);
    if (rc == 0 && s->count > LIMIT_INSTANCES)
        rc = fault_set(fault, ERR_LIMIT, place, "%" PRIu32 " instances are too many", s->count);
    return rc;
}

static void widen(const float *from, uint32_t i, size_t n, double *out)
{
    for (size_t c = 0; from != NULL && c < n; c++) out[c] = (double)from[n * i + c];
}

/* Instance i before its node's own transform. */
static int local_of(const struct instancing *s, uint32_t i, const char *place, struct affine *out,
                    struct fault *fault)
{
    double t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    gltf_place at;
    widen(s->translation, i, 3, t);
    widen(s->rotation, i, 4, q);
    widen(s->scale, i, 3, scale);
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; k++) q[k] /= length;
    *out = affine_from_trs(t, q, scale);
    if (affine_is_finite(out)) return 0;
    gltf_place_set(at, "%s[%" PRIu32 "]", place, i);
    return fault_set(fault, ERR_NOT_FINITE, at, "its place is not finite");
}

int gltf_instancing_keep(struct gltf *g, const json_t *json, const char *place,
                         const struct gltf_node *node, bool *instanced, struct fault *fault)
{
    const json_t *extension, *attributes;
    gltf_place at, attributes_at;
    struct instancing s = {0};
    int rc = gltf_extension(json, place, "EXT_mesh_gpu_instancing", &extension, at, fault);
    *instanced = rc == 0 && extension != NULL && node->mesh != SCENE_NONE;
    if (rc != 0 || !*instanced) return rc;
    gltf_place_set(attributes_at, "%s.attributes", at);
    rc = gltf_object(extension, at, "attributes", &attributes, fault);
    if (rc == 0) rc = read_attributes(g, attributes, attributes_at, &s, fault);
    for (uint32_t i = 0; rc == 0 && i < s.count; i++) {
        struct gltf_node copy = *node;
        struct affine local;
        copy.camera = copy.light = SCENE_NONE;
        rc = local_of(&s, i, at, &local, fault);
        copy.to_world = affine_multiply(&node->to_world, &local);
        if (rc == 0) rc = gltf_node_keep(&g->nodes, &copy, fault);
    }
    free(s.translation);
    free(s.rotation);
    free(s.scale);
    return rc;
}
