#include "server/import/gltf/gltf_pose.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "server/import/gltf/gltf_accessor.h"
#include "server/import/gltf/gltf_skin.h"

#define WEIGHT_MAX 1e6

/* What poses a primitive. */
struct pose {
    const json_t *mesh, *primitive, *node; /* node: NULL where there is no poser */
    gltf_place mesh_place, primitive_place, node_place;
    const json_t *targets; /* NULL: none */
    const json_t *weights; /* the node's own, else the mesh's; NULL: none */
    const char *weights_place;
    uint32_t skin; /* SCENE_NONE: none */
};

static int read_weights(struct pose *p, struct fault *fault)
{
    int rc = gltf_array(p->node, p->node_place, "weights", &p->weights, fault);
    p->weights_place = p->node_place;
    if (rc != 0 || p->weights != NULL) return rc;
    p->weights_place = p->mesh_place;
    return gltf_array(p->mesh, p->mesh_place, "weights", &p->weights, fault);
}

static int read_pose(struct gltf *g, uint32_t mesh, uint32_t primitive, uint32_t poser,
                     struct pose *out, struct fault *fault)
{
    const json_t *primitives;
    *out = (struct pose){.skin = SCENE_NONE};
    int rc = gltf_item(g->root, "meshes", mesh, &out->mesh, out->mesh_place, fault);
    if (rc == 0) rc = gltf_array(out->mesh, out->mesh_place, "primitives", &primitives, fault);
    if (rc != 0) return rc;
    out->primitive = json_array_get(primitives, primitive);
    gltf_place_set(out->primitive_place, "%s.primitives[%" PRIu32 "]", out->mesh_place, primitive);
    rc = gltf_array(out->primitive, out->primitive_place, "targets", &out->targets, fault);
    if (rc == 0 && poser != SCENE_NONE)
        rc = gltf_item(g->root, "nodes", poser, &out->node, out->node_place, fault);
    if (rc == 0 && out->node != NULL)
        rc = gltf_index(out->node, out->node_place, "skin", gltf_count(g->root, "skins"),
                        &out->skin, fault);
    return rc == 0 ? read_weights(out, fault) : rc;
}

/* The weight of target t; targets without one rest. */
static int weight_of(const struct pose *p, size_t t, double *out, struct fault *fault)
{
    const json_t *weight = json_array_get(p->weights, t);
    *out = 0;
    if (weight == NULL) return 0;
    gltf_place at;
    gltf_place_set(at, "%s.weights[%zu]", p->weights_place, t);
    if (!json_is_number(weight)) return fault_set(fault, ERR_TYPE, at, "it is not a number");
    *out = json_number_value(weight);
    if (fabs(*out) <= WEIGHT_MAX) return 0;
    return fault_set(fault, ERR_RANGE, at, "%g is beyond %g", *out, WEIGHT_MAX);
}

int gltf_pose_moves(struct gltf *g, uint32_t mesh, uint32_t primitive, uint32_t poser, bool *moves,
                    struct fault *fault)
{
    struct pose p;
    int rc = read_pose(g, mesh, primitive, poser, &p, fault);
    *moves = p.skin != SCENE_NONE;
    for (size_t t = 0; rc == 0 && t < json_array_size(p.targets); t++) {
        double weight;
        rc = weight_of(&p, t, &weight, fault);
        if (weight != 0) *moves = true;
    }
    if (rc == 0 && p.targets != NULL && json_array_size(p.weights) > json_array_size(p.targets))
        warnings_add(&g->builder->warnings, p.weights_place,
                     "it has more weights than morph targets; those beyond them are ignored");
    return rc;
}

/* An attribute of a vertex that targets may move. */
struct moved {
    const char *key;
    float *values;               /* NULL: the mesh lacks it */
    uint32_t stride, components; /* floats a vertex, and how many of them move */
};

/* Adds weight times a target's attribute, which must have an element for each vertex. */
static int add_deltas(struct gltf *g, const json_t *target, const char *place,
                      const struct moved *moved, double weight, uint32_t vertices,
                      struct fault *fault)
{
    uint32_t accessor, count;
    float *deltas = NULL;
    gltf_place at;
    size_t accessors = gltf_count(g->root, "accessors");
    int rc = gltf_index(target, place, moved->key, accessors, &accessor, fault);
    if (rc != 0 || accessor == SCENE_NONE || moved->values == NULL) return rc;
    rc = gltf_read_floats(g, accessor, moved->components, &count, &deltas, fault);
    if (rc != 0) return rc;
    gltf_place_set(at, "%s.%s", place, moved->key);
    if (count != vertices)
        rc = fault_set(fault, ERR_MISMATCH, at,
                       "it has %" PRIu32 " elements for %" PRIu32 " vertices", count, vertices);
    for (size_t v = 0; rc == 0 && v < count; v++)
        for (size_t c = 0; c < moved->components; c++) {
            float *value = moved->values + v * moved->stride + c;
            *value = (float)((double)*value + weight * (double)deltas[v * moved->components + c]);
        }
    free(deltas);
    return rc;
}

/* Colours move by three components or four, as the target has them. */
static uint32_t color_components(struct gltf *g, const json_t *target)
{
    uint32_t accessor, components = 4;
    struct fault fault; /* of the accessor: add_deltas names it */
    if (gltf_index(target, "", "COLOR_0", gltf_count(g->root, "accessors"), &accessor, &fault) ==
            0 &&
        accessor != SCENE_NONE)
        gltf_accessor_components(g, accessor, &components, &fault);
    return components == 3 ? 3 : 4;
}

static int apply_target(struct gltf *g, const struct gltf_geometry *geometry, const json_t *target,
                        const char *place, double weight, struct mesh *mesh, struct fault *fault)
{
    char uv_keys[2][24];
    for (int i = 0; i < 2; i++)
        snprintf(uv_keys[i], sizeof uv_keys[i], "TEXCOORD_%" PRIu32, geometry->uv_number[i]);
    const struct moved rows[] = {{"POSITION", mesh->positions, 3, 3},
                                 {"NORMAL", mesh->normals, 3, 3},
                                 {"TANGENT", mesh->tangents, 4, 3},
                                 {uv_keys[0], mesh->uvs[0], 2, 2},
                                 {uv_keys[1], mesh->uvs[1], 2, 2},
                                 {"COLOR_0", mesh->colors, 4, color_components(g, target)}};
    int rc = 0;
    if (!json_is_object(target)) return fault_set(fault, ERR_TYPE, place, "it is not an object");
    for (size_t i = 0; rc == 0 && i < sizeof rows / sizeof *rows; i++)
        rc = add_deltas(g, target, place, &rows[i], weight, mesh->vertex_count, fault);
    return rc;
}

int gltf_pose_apply(struct gltf *g, const struct gltf_geometry *geometry, const char *place,
                    struct mesh *mesh, struct fault *fault)
{
    struct pose p;
    int rc = read_pose(g, geometry->posed_mesh, geometry->posed_primitive, geometry->posed_node, &p,
                       fault);
    for (size_t t = 0; rc == 0 && t < json_array_size(p.targets); t++) {
        double weight;
        gltf_place at;
        gltf_place_set(at, "%s.targets[%zu]", place, t);
        rc = weight_of(&p, t, &weight, fault);
        if (rc == 0 && weight != 0)
            rc = apply_target(g, geometry, json_array_get(p.targets, t), at, weight, mesh, fault);
    }
    if (rc != 0 || p.skin == SCENE_NONE) return rc;
    return gltf_skin_apply(g, p.skin, p.primitive, p.primitive_place, mesh, fault);
}
