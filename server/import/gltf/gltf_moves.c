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

/* Applies one move to all that it moves, about the middle of what shows. Skins stand where their
 * joints do. */
static void apply(struct gltf *g, uint32_t move)
{
    const uint32_t bit = 1u << move;
    double lowest[3], highest[3], middle[3] = {0};
    if (gltf_nodes_bounds(g, bit, lowest, highest))
        for (int i = 0; i < 3; i++) middle[i] = 0.5 * (lowest[i] + highest[i]);
    const struct affine by = moves_transform(&g->moves.asked->list[move], middle);
    for (uint32_t i = 0; i < g->nodes.count; i++) {
        struct gltf_node *node = &g->nodes.list[i];
        if (!(node->moved & bit) || node->skin != SCENE_NONE) continue;
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
