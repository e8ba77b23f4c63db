#include "server/import/gltf/gltf_nodes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf.h"

/* Numbers of a transform that a float can hold after a few products. */
#define TRANSFORM_MAX 1e30

void gltf_nodes_fini(struct gltf_nodes *nodes)
{
    free(nodes->list);
    free(nodes->visited);
    free(nodes->world);
    memset(nodes, 0, sizeof *nodes);
}

static bool normalize_quaternion(double q[4])
{
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 0) || !isfinite(length)) return false;
    for (int i = 0; i < 4; i++) q[i] /= length;
    return true;
}

static int read_trs(const json_t *json, const char *place, struct affine *out, struct fault *fault)
{
    const double far = TRANSFORM_MAX;
    double t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    int rc = gltf_vector(json, place, "translation", 3, -far, far, t, NULL, fault);
    if (rc == 0) rc = gltf_vector(json, place, "rotation", 4, -far, far, q, NULL, fault);
    if (rc == 0) rc = gltf_vector(json, place, "scale", 3, -far, far, s, NULL, fault);
    if (rc != 0) return rc;
    if (!normalize_quaternion(q)) {
        gltf_place at;
        gltf_place_set(at, "%s.rotation", place);
        return fault_set(fault, ERR_RANGE, at, "the quaternion has length zero");
    }
    *out = affine_from_trs(t, q, s);
    return 0;
}

static int read_transform(const json_t *json, const char *place, struct affine *out,
                          struct fault *fault)
{
    double columns[16];
    bool has_matrix;
    int rc = gltf_vector(json, place, "matrix", 16, -TRANSFORM_MAX, TRANSFORM_MAX, columns,
                         &has_matrix, fault);
    if (rc != 0) return rc;
    if (!has_matrix) return read_trs(json, place, out, fault);
    if (affine_from_columns(columns, out)) return 0;
    gltf_place at;
    gltf_place_set(at, "%s.matrix", place);
    return fault_set(fault, ERR_RANGE, at, "its last row is not 0 0 0 1");
}

static int read_light(struct gltf *g, const json_t *json, const char *place, uint32_t *out,
                      struct fault *fault)
{
    const json_t *extension, *lights_extension;
    gltf_place at, lights_at;
    *out = SCENE_NONE;
    int rc = gltf_extension(json, place, "KHR_lights_punctual", &extension, at, fault);
    if (rc != 0 || extension == NULL) return rc;
    rc = gltf_extension(g->root, "", "KHR_lights_punctual", &lights_extension, lights_at, fault);
    if (rc != 0) return rc;
    size_t count = json_array_size(json_object_get(lights_extension, "lights"));
    return gltf_index(extension, at, "light", count, out, fault);
}

int gltf_node_keep(struct gltf_nodes *nodes, const struct gltf_node *node, struct fault *fault)
{
    if (node->mesh == SCENE_NONE && node->camera == SCENE_NONE && node->light == SCENE_NONE)
        return 0;
    if (nodes->count >= 2 * LIMIT_INSTANCES) /* a skinned node is two */
        return fault_set(fault, ERR_LIMIT, "nodes", "the scene has more than %u instances",
                         LIMIT_INSTANCES);
    if (nodes->count == nodes->capacity) {
        uint32_t capacity = nodes->capacity * 2 + 64;
        struct gltf_node *list = realloc(nodes->list, capacity * sizeof *list);
        if (list == NULL) return fault_set(fault, ERR_MEMORY, "nodes", "no memory for the nodes");
        nodes->list = list;
        nodes->capacity = capacity;
    }
    nodes->list[nodes->count++] = *node;
    return 0;
}

/* What a node bears, besides its transform. */
static int read_bearings(struct gltf *g, const json_t *json, const char *place,
                         struct gltf_node *node, struct fault *fault)
{
    int rc = gltf_index(json, place, "mesh", gltf_count(g->root, "meshes"), &node->mesh, fault);
    if (rc == 0)
        rc =
            gltf_index(json, place, "camera", gltf_count(g->root, "cameras"), &node->camera, fault);
    if (rc == 0) rc = read_light(g, json, place, &node->light, fault);
    if (rc == 0)
        rc = gltf_index(json, place, "skin", gltf_count(g->root, "skins"), &node->skin, fault);
    if (node->mesh == SCENE_NONE) node->skin = SCENE_NONE;
    node->weighted = json_object_get(json, "weights") != NULL;
    return rc;
}

/* Keeps a node; with a skin as two, since a skin's mesh does not stand where its node does (glTF
 * 2.0, section 3.7.3.3). */
static int keep_bearings(struct gltf *g, const json_t *json, const char *place,
                         const struct gltf_node *node, struct fault *fault)
{
    struct gltf_nodes *nodes = &g->nodes;
    struct gltf_node rest = *node, skinned = *node;
    bool instanced = false;
    if (node->skin == SCENE_NONE) {
        int rc = gltf_instancing_keep(g, json, place, node, &instanced, fault);
        if (instanced) rest.mesh = SCENE_NONE;
        return rc == 0 ? gltf_node_keep(nodes, &rest, fault) : rc;
    }
    rest.mesh = rest.skin = SCENE_NONE;
    skinned.camera = skinned.light = SCENE_NONE;
    skinned.to_world = affine_identity();
    int rc = gltf_node_keep(nodes, &rest, fault);
    return rc == 0 ? gltf_node_keep(nodes, &skinned, fault) : rc;
}

/* KHR_node_visibility: a node that is hidden hides all beneath it; cameras see as they do. */
static int read_visibility(const struct gltf *g, const json_t *json, const char *place,
                           const struct gltf_node *node, bool *inout, struct fault *fault)
{
    const json_t *extension;
    gltf_place at;
    bool own = true;
    int rc = gltf_extension(json, place, "KHR_node_visibility", &extension, at, fault);
    if (rc == 0) rc = gltf_flag(extension, at, "visible", &own, fault);
    /* What comes and goes is a part of the base, whatever it does while the scene rests. */
    if (g->phase == GLTF_BASE && node->moves) own = true;
    *inout = *inout && own;
    return rc;
}

/* What a node has of its ancestors. */
struct ancestry {
    struct affine to_world;
    bool visible, moves;
    uint32_t moved;
    uint32_t depth;
};

static int visit(struct gltf *g, size_t index, const struct ancestry *parent, struct fault *fault);

static int visit_children(struct gltf *g, const json_t *json, const char *key, const char *place,
                          const struct ancestry *own, struct fault *fault)
{
    const json_t *children;
    int rc = gltf_array(json, place, key, &children, fault);
    for (size_t i = 0; rc == 0 && i < json_array_size(children); i++) {
        const json_t *child = json_array_get(children, i);
        gltf_place at;
        gltf_place_set(at, "%s.%s[%zu]", place, key, i);
        if (!json_is_integer(child) || json_integer_value(child) < 0 ||
            (size_t)json_integer_value(child) >= gltf_count(g->root, "nodes"))
            return fault_set(fault, ERR_RANGE, at, "it names no node");
        rc = visit(g, (size_t)json_integer_value(child), own, fault);
    }
    return rc;
}

/* Recursion is bounded by LIMIT_NODE_DEPTH. */
static int visit(struct gltf *g, size_t index, const struct ancestry *parent, struct fault *fault)
{
    const json_t *json;
    gltf_place place;
    struct affine local;
    struct ancestry own = *parent;
    struct gltf_node node = {.index = (uint32_t)index};
    int rc = gltf_item(g->root, "nodes", index, &json, place, fault);
    if (rc != 0) return rc;
    if (++own.depth > LIMIT_NODE_DEPTH)
        return fault_set(fault, ERR_LIMIT, place, "nodes are nested deeper than %d",
                         LIMIT_NODE_DEPTH);
    if (g->nodes.visited[index])
        return fault_set(fault, ERR_CORRUPT, place, "it has two parents or is its own ancestor");
    g->nodes.visited[index] = 1;
    rc = read_transform(json, place, &local, fault);
    if (rc != 0) return rc;
    node.to_world = own.to_world = affine_multiply(&parent->to_world, &local);
    node.moves = own.moves = parent->moves || (g->moving.nodes && g->moving.nodes[index]);
    if (g->moves.of != NULL) node.moved = own.moved = g->moves.of[index] |= parent->moved;
    if (!affine_is_finite(&node.to_world))
        return fault_set(fault, ERR_NOT_FINITE, place, "its place in the world is not finite");
    if (g->nodes.world != NULL) g->nodes.world[index] = node.to_world;
    rc = read_bearings(g, json, place, &node, fault);
    if (rc == 0) rc = read_visibility(g, json, place, &node, &own.visible, fault);
    if (!own.visible) node.mesh = node.skin = node.light = SCENE_NONE;
    if (rc == 0) rc = keep_bearings(g, json, place, &node, fault);
    return rc == 0 ? visit_children(g, json, "children", place, &own, fault) : rc;
}

/* Lists all nodes that are no node's child, for a document without scenes. */
static int visit_roots(struct gltf *g, struct fault *fault)
{
    size_t count = gltf_count(g->root, "nodes");
    uint8_t *is_child = calloc(count + 1, 1);
    if (is_child == NULL) return fault_set(fault, ERR_MEMORY, "nodes", "no memory for the nodes");
    for (size_t i = 0; i < count; i++) {
        const json_t *node = json_array_get(json_object_get(g->root, "nodes"), i);
        const json_t *children = json_object_get(node, "children");
        for (size_t c = 0; c < json_array_size(children); c++) {
            json_int_t child = json_integer_value(json_array_get(children, c));
            if (child >= 0 && (size_t)child < count) is_child[child] = 1;
        }
    }
    const struct ancestry none = {.to_world = affine_identity(), .visible = true};
    int rc = 0;
    for (size_t i = 0; rc == 0 && i < count; i++)
        if (!is_child[i]) rc = visit(g, i, &none, fault);
    free(is_child);
    return rc;
}

int gltf_nodes_read(struct gltf *g, struct fault *fault)
{
    gltf_nodes_fini(&g->nodes);
    size_t scenes = gltf_count(g->root, "scenes");
    uint32_t chosen;
    g->nodes.visited = calloc(gltf_count(g->root, "nodes") + 1, 1);
    if (gltf_count(g->root, "skins") > 0)
        g->nodes.world = calloc(gltf_count(g->root, "nodes") + 1, sizeof *g->nodes.world);
    if (g->nodes.visited == NULL || (g->nodes.world == NULL && gltf_count(g->root, "skins") > 0))
        return fault_set(fault, ERR_MEMORY, "nodes", "no memory for the nodes");
    int rc = gltf_index(g->root, "", "scene", scenes, &chosen, fault);
    if (rc != 0) return rc;
    if (scenes == 0) return visit_roots(g, fault);
    if (chosen == SCENE_NONE) chosen = 0;
    if (scenes > 1)
        warnings_add(&g->builder->warnings, "scenes", "only scene %u is imported", chosen);
    const json_t *scene;
    gltf_place place;
    const struct ancestry none = {.to_world = affine_identity(), .visible = true};
    rc = gltf_item(g->root, "scenes", chosen, &scene, place, fault);
    if (rc == 0) rc = visit_children(g, scene, "nodes", place, &none, fault);
    return rc;
}
