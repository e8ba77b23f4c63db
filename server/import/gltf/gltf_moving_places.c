/* Places what moves: frames place meshes of their base, and have of their own what bends. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf_places.h"

enum gltf_motion gltf_motion_of(const struct gltf_places *m, const struct gltf_use *use,
                                const struct gltf_node *node)
{
    const struct gltf_moving *moving = &m->g->moving;
    if (m->g->phase == GLTF_WHOLE) return MOTION_NONE;
    if (node->skin != SCENE_NONE || moving->mesh_weights[use->mesh] ||
        moving->node_weights[node->index] ||
        (use->own_material != SCENE_NONE && moving->materials[use->own_material]))
        return MOTION_BENT;
    return node->moves ? MOTION_RIGID : MOTION_NONE;
}

static uint32_t poser_of(const struct gltf_places *m, const struct gltf_use *use)
{
    return m->stands[use->stand].poser;
}

int gltf_movables_store(struct gltf_places *m, const struct mesh *local, uint32_t leader,
                        struct fault *fault)
{
    struct scene_mesh record;
    bool stored = false;
    int rc = 0;
    for (uint32_t u = leader; rc == 0 && u != SCENE_NONE; u = m->uses[u].next) {
        const struct gltf_use *use = &m->uses[u];
        if (gltf_count_motion(m, use, MOTION_RIGID) == 0) continue;
        if (!stored) rc = mesh_append(local, m->g->builder, &record, fault);
        stored = true;
        if (rc == 0) rc = gltf_use_append(m->g, &record, use, fault);
        if (rc == 0)
            rc = gltf_movable_keep(m->g,
                                   &(struct gltf_movable){use->mesh, use->primitive,
                                                          poser_of(m, use), gltf_last_mesh(m->g),
                                                          m->back},
                                   fault);
    }
    return rc;
}

/* The mesh of the base that stands at node i; NULL where the frame needs one of its own. */
static const struct gltf_movable *movable_at(const struct gltf_places *m,
                                             const struct gltf_use *use, uint32_t i)
{
    if (gltf_motion_of(m, use, &m->g->nodes.list[i]) != MOTION_RIGID || m->sides[i] != SIDE_PLAIN)
        return NULL;
    return gltf_movable_find(m->g, use->mesh, use->primitive, poser_of(m, use));
}

/* Places the base's meshes; the instances of a mesh stand together. */
static int place_movables(struct gltf_places *m, const struct gltf_use *use, struct fault *fault)
{
    int rc = 0;
    for (uint32_t i = m->first_node[use->stand]; rc == 0 && i < m->first_node[use->stand + 1];
         i++) {
        const struct gltf_movable *movable = movable_at(m, use, m->nodes[i]);
        const struct gltf_node *node = &m->g->nodes.list[m->nodes[i]];
        if (movable == NULL) continue;
        const struct affine to_world = affine_multiply(&node->to_world, &movable->back);
        rc = gltf_instance_append(m->g, movable->record, node, &to_world, fault);
    }
    return rc;
}

/* Bakes the placements that bend, are mirrored or flat. `local` is loaded at the first. */
static int place_bent(struct gltf_places *m, const struct gltf_use *use, struct mesh *local,
                      bool *loaded, struct fault *fault)
{
    int rc = 0;
    for (uint32_t i = m->first_node[use->stand]; rc == 0 && i < m->first_node[use->stand + 1];
         i++) {
        const struct gltf_node *node = &m->g->nodes.list[m->nodes[i]];
        if (gltf_motion_of(m, use, node) == MOTION_NONE || movable_at(m, use, m->nodes[i]) != NULL)
            continue;
        if (!*loaded) rc = gltf_use_load(m, use, local, fault);
        *loaded = rc == 0;
        if (rc == 0 && local->triangle_count > 0) rc = gltf_use_bake(m, local, use, node, fault);
    }
    return rc;
}

/* Places what moves. */
int gltf_place_moving(struct gltf_places *m, uint32_t leader, struct fault *fault)
{
    struct mesh local = {0};
    bool loaded = false;
    int rc = 0;
    for (uint32_t u = leader; rc == 0 && u != SCENE_NONE; u = m->uses[u].next) {
        rc = place_movables(m, &m->uses[u], fault);
        if (rc == 0) rc = place_bent(m, &m->uses[u], &local, &loaded, fault);
    }
    mesh_fini(&local);
    return rc;
}
