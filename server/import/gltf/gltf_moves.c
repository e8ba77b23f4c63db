/* Moves nodes from where the file has them to where the job wants them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "server/import/gltf/gltf.h"
#include "server/import/scene/moves.h"

static bool is_called(const struct gltf *g, size_t node, const char *name)
{
    const json_t *json = json_array_get(json_object_get(g->root, "nodes"), node);
    return moves_name_matches(json_string_value(json_object_get(json, "name")), name);
}

static int find(struct gltf *g, uint32_t move, struct fault *fault)
{
    const size_t count = gltf_count(g->root, "nodes");
    const char *name = g->moves.asked->list[move].node;
    bool found = false;
    for (size_t i = 0; i < count; i++) {
        if (!is_called(g, i, name)) continue;
        g->moves.of[i] |= 1u << move;
        g->moving.nodes[i] = 1;
        found = true;
    }
    return found ? 0 : moves_refuse_name(move, name, fault);
}

int gltf_moves_find(struct gltf *g, const struct job_moves *moves, struct fault *fault)
{
    if (moves == NULL) return 0;
    g->moves.asked = moves;
    g->moves.of = calloc(gltf_count(g->root, "nodes") + 1, sizeof *g->moves.of);
    if (g->moves.of == NULL) return fault_set(fault, ERR_MEMORY, "nodes", "no memory for moves");
    g->moving.any = true;
    int rc = 0;
    for (uint32_t i = 0; i < moves->count && rc == 0; i++) rc = find(g, i, fault);
    return rc;
}

/* Widens bounds by where cameras and lights stand that the move takes along. */
static void add_places(const struct gltf *g, uint32_t bit, double lowest[3], double highest[3])
{
    for (uint32_t i = 0; i < g->nodes.count; i++) {
        const struct gltf_node *node = &g->nodes.list[i];
        if (!(node->moved & bit) || node->skin != SCENE_NONE) continue;
        for (int k = 0; k < 3; k++) {
            lowest[k] = fmin(lowest[k], node->to_world.m[4 * k + 3]);
            highest[k] = fmax(highest[k], node->to_world.m[4 * k + 3]);
        }
    }
}

/* Finds the middle of what shows; without that, of lights and cameras. */
static void find_middle(const struct gltf *g, uint32_t bit, double middle[3])
{
    double lowest[3], highest[3];
    if (!gltf_nodes_bounds(g, bit, lowest, highest)) add_places(g, bit, lowest, highest);
    for (int i = 0; i < 3; i++)
        middle[i] = lowest[i] <= highest[i] ? 0.5 * (lowest[i] + highest[i]) : 0;
}

/* Returns whether the move takes joints of a skin along: these pose the mesh, as far as they go. */
static bool moves_joints(const struct gltf *g, uint32_t skin, uint32_t bit)
{
    size_t i;
    json_t *joint;
    const json_t *json = json_array_get(json_object_get(g->root, "skins"), skin);
    json_array_foreach (json_object_get(json, "joints"), i, joint) {
        const json_int_t node = json_is_integer(joint) ? json_integer_value(joint) : -1;
        if (node >= 0 && (size_t)node < gltf_count(g->root, "nodes") && (g->moves.of[node] & bit))
            return true;
    }
    return false;
}

/* Applies one move to all that it moves, about its middle. */
static void apply(struct gltf *g, uint32_t move)
{
    const uint32_t bit = 1u << move;
    double middle[3];
    find_middle(g, bit, middle);
    const struct affine by = moves_transform(&g->moves.asked->list[move], middle);
    for (uint32_t i = 0; i < g->nodes.count; i++) {
        struct gltf_node *node = &g->nodes.list[i];
        if (!(node->moved & bit)) continue;
        if (node->skin != SCENE_NONE && moves_joints(g, node->skin, bit)) continue;
        node->to_world = affine_multiply(&by, &node->to_world);
    }
    for (size_t i = 0; g->nodes.world != NULL && i < gltf_count(g->root, "nodes"); i++)
        if (g->nodes.visited[i] && (g->moves.of[i] & bit))
            g->nodes.world[i] = affine_multiply(&by, &g->nodes.world[i]);
}

void gltf_moves_apply(struct gltf *g)
{
    if (g->moves.asked == NULL) return;
    for (uint32_t i = 0; i < g->moves.asked->count; i++) apply(g, i);
}

void gltf_moves_fini(struct gltf_moves *moves)
{
    free(moves->of);
    *moves = (struct gltf_moves){0};
}
