/* Places what rests: baked where it stands once, instanced where more often. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf_places.h"
#include "server/import/scene/origin.h"

static int name_of(struct gltf *g, const char *array, uint32_t index, uint32_t *out,
                   struct fault *fault)
{
    const json_t *json;
    gltf_place place;
    const char *name;
    int rc = gltf_item(g->root, array, index, &json, place, fault);
    if (rc == 0) rc = gltf_text(json, place, "name", &name, fault);
    return rc == 0 ? builder_name(g->builder, name, out, fault) : rc;
}

/* Appends a mesh record: the ranges of `geometry` with the material of a use. */
int gltf_use_append(struct gltf *g, const struct scene_mesh *geometry, const struct gltf_use *use,
                    struct fault *fault)
{
    struct scene_mesh record = *geometry;
    void *at;
    record.material = use->material;
    int rc = name_of(g, "meshes", use->mesh, &record.name, fault);
    if (rc == 0) rc = builder_append(g->builder, SCENE_MESHES, 1, &at, fault);
    if (rc == 0) memcpy(at, &record, sizeof record);
    return rc;
}

/* Reads a member of a node's role. 1 and 0 are what Blender before 3.5 makes of True and False. */
static int read_role(const char *place, const char *key, const json_t *value, uint32_t *roles,
                     struct fault *fault)
{
    gltf_place at;
    const bool is_catcher = strcmp(key, "catcher") == 0;
    gltf_place_set(at, "%s.%.60s", place, key);
    text_make_printable(at);
    if (!is_catcher && strcmp(key, "holdout") != 0)
        return fault_set(fault, ERR_UNKNOWN_MEMBER, at, "a node is a catcher or a holdout");
    const json_int_t number = json_is_integer(value) ? json_integer_value(value) : -1;
    if (!json_is_boolean(value) && number != 0 && number != 1)
        return fault_set(fault, ERR_TYPE, at, "it is neither true nor false");
    if (json_is_true(value) || number == 1)
        *roles |= is_catcher ? INSTANCE_CATCHER : INSTANCE_HOLDOUT;
    return 0;
}

/* extras.shearwater of a node: {"catcher": true} or {"holdout": true}. */
static int find_role(const struct gltf *g, uint32_t node, uint32_t *flags, struct fault *fault)
{
    const json_t *json, *ours;
    gltf_place place, at;
    const char *key;
    json_t *value;
    uint32_t roles = 0;
    int rc = gltf_item(g->root, "nodes", node, &json, place, fault);
    const json_t *extras = rc == 0 ? json_object_get(json, "extras") : NULL;
    if (!json_is_object(extras)) return rc;
    gltf_place_set(at, "%s.extras", place);
    rc = gltf_object(extras, at, "shearwater", &ours, fault);
    if (rc != 0 || ours == NULL) return rc;
    gltf_place_set(at, "%s.extras.shearwater", place);
    json_object_foreach ((json_t *)ours, key, value)
        if (rc == 0) rc = read_role(at, key, value, &roles, fault);
    if (rc == 0 && roles == (INSTANCE_CATCHER | INSTANCE_HOLDOUT))
        return fault_set(fault, ERR_EXISTS, at, "it is a catcher and a holdout");
    *flags |= roles;
    return rc;
}

int gltf_instance_append(struct gltf *g, uint32_t mesh, const struct gltf_node *node,
                         const struct affine *to_world, struct fault *fault)
{
    struct scene_instance record = {.mesh = mesh};
    void *at;
    if (affine_is_identity(to_world)) record.flags = INSTANCE_IDENTITY;
    for (int i = 0; i < 12; i++) record.to_world[i] = (float)to_world->m[i];
    int rc = find_role(g, node->index, &record.flags, fault);
    if (rc == 0) rc = name_of(g, "nodes", node->index, &record.name, fault);
    if (rc == 0) rc = builder_append(g->builder, SCENE_INSTANCES, 1, &at, fault);
    if (rc == 0) memcpy(at, &record, sizeof record);
    return rc;
}

/* Bakes one placement: a mesh of its own, in world coordinates. */
int gltf_use_bake(struct gltf_places *m, const struct mesh *local, const struct gltf_use *use,
                  const struct gltf_node *node, struct fault *fault)
{
    struct gltf *g = m->g;
    struct mesh baked;
    struct scene_mesh record;
    gltf_place place;
    const struct affine identity = affine_identity();
    const struct affine to_world = affine_multiply(&node->to_world, &m->back);
    gltf_place_set(place, "meshes[%" PRIu32 "].primitives[%" PRIu32 "]", use->mesh, use->primitive);
    int rc = mesh_copy(local, &baked, fault);
    if (rc != 0) return rc;
    rc = mesh_transform(&baked, &to_world, place, fault);
    if (rc == 0) rc = mesh_append(&baked, g->builder, &record, fault);
    if (rc == 0) rc = gltf_use_append(g, &record, use, fault);
    if (rc == 0) rc = gltf_instance_append(g, gltf_last_mesh(g), node, &identity, fault);
    mesh_fini(&baked);
    return rc;
}

/* Returns whether node i of the list is one where a use stands at rest on one side. */
static bool rests_on(const struct gltf_places *m, const struct gltf_use *use, uint32_t i,
                     enum gltf_side side)
{
    return m->sides[i] == side && gltf_motion_of(m, use, &m->g->nodes.list[i]) == MOTION_NONE;
}

/* Returns how often a use is placed on one side. */
static uint64_t count_side(const struct gltf_places *m, const struct gltf_use *use,
                           enum gltf_side side)
{
    uint64_t count = 0;
    for (uint32_t i = m->first_node[use->stand]; i < m->first_node[use->stand + 1]; i++)
        count += rests_on(m, use, m->nodes[i], side);
    return count;
}

uint64_t gltf_count_motion(const struct gltf_places *m, const struct gltf_use *use,
                           enum gltf_motion motion)
{
    uint64_t count = 0;
    for (uint32_t i = m->first_node[use->stand]; i < m->first_node[use->stand + 1]; i++)
        count += gltf_motion_of(m, use, &m->g->nodes.list[m->nodes[i]]) == motion;
    return count;
}

static int bake_side(struct gltf_places *m, const struct mesh *local, uint32_t leader,
                     enum gltf_side side, struct fault *fault)
{
    int rc = 0;
    for (uint32_t u = leader; rc == 0 && u != SCENE_NONE; u = m->uses[u].next) {
        const struct gltf_use *use = &m->uses[u];
        for (uint32_t i = m->first_node[use->stand]; rc == 0 && i < m->first_node[use->stand + 1];
             i++)
            if (rests_on(m, use, m->nodes[i], side))
                rc = gltf_use_bake(m, local, use, &m->g->nodes.list[m->nodes[i]], fault);
    }
    return rc;
}

/* Stores the geometry once, then a mesh for each use and an instance for each placement. */
static int instance_side(struct gltf_places *m, const struct mesh *geometry, uint32_t leader,
                         enum gltf_side side, struct fault *fault)
{
    struct scene_mesh record;
    int rc = mesh_append(geometry, m->g->builder, &record, fault);
    for (uint32_t u = leader; rc == 0 && u != SCENE_NONE; u = m->uses[u].next) {
        const struct gltf_use *use = &m->uses[u];
        if (count_side(m, use, side) == 0) continue;
        rc = gltf_use_append(m->g, &record, use, fault);
        for (uint32_t i = m->first_node[use->stand]; rc == 0 && i < m->first_node[use->stand + 1];
             i++) {
            if (!rests_on(m, use, m->nodes[i], side)) continue;
            const struct gltf_node *node = &m->g->nodes.list[m->nodes[i]];
            struct affine to_world = affine_multiply(&node->to_world, &m->back);
            if (side == SIDE_MIRRORED) to_world = affine_mirrored(&to_world);
            rc = gltf_instance_append(m->g, gltf_last_mesh(m->g), node, &to_world, fault);
        }
    }
    return rc;
}

static int place_side(struct gltf_places *m, const struct mesh *local, uint32_t leader,
                      enum gltf_side side, const char *place, struct fault *fault)
{
    uint64_t count = 0;
    for (uint32_t u = leader; u != SCENE_NONE; u = m->uses[u].next)
        count += count_side(m, &m->uses[u], side);
    if (count == 0) return 0;
    if (count == 1 || side == SIDE_FLAT) return bake_side(m, local, leader, side, fault);
    if (side == SIDE_PLAIN) return instance_side(m, local, leader, side, fault);
    const struct affine identity = affine_identity(), mirror = affine_mirrored(&identity);
    struct mesh mirrored;
    int rc = mesh_copy(local, &mirrored, fault);
    if (rc != 0) return rc;
    rc = mesh_transform(&mirrored, &mirror, place, fault);
    if (rc == 0) rc = instance_side(m, &mirrored, leader, side, fault);
    mesh_fini(&mirrored);
    return rc;
}

static void place_of(const struct gltf_use *use, gltf_place out)
{
    gltf_place_set(out, "meshes[%" PRIu32 "].primitives[%" PRIu32 "]", use->mesh, use->primitive);
}

int gltf_use_load(struct gltf_places *m, const struct gltf_use *use, struct mesh *out,
                  struct fault *fault)
{
    gltf_place place;
    double origin[3];
    place_of(use, place);
    int rc = gltf_geometry_load(m->g, &use->geometry, place, out, fault);
    if (rc != 0) return rc;
    origin_move_mesh(out, place, &m->g->builder->warnings, origin);
    m->back = affine_translation(origin);
    return 0;
}

/* Places what rests, and stores what frames will move. */
int gltf_place_resting(struct gltf_places *m, uint32_t leader, struct fault *fault)
{
    uint64_t needed = 0;
    struct mesh local;
    gltf_place place;
    place_of(&m->uses[leader], place);
    for (uint32_t u = leader; u != SCENE_NONE; u = m->uses[u].next)
        needed += gltf_count_motion(m, &m->uses[u], MOTION_NONE) +
                  gltf_count_motion(m, &m->uses[u], MOTION_RIGID);
    if (needed == 0) return 0;
    int rc = gltf_use_load(m, &m->uses[leader], &local, fault);
    if (rc != 0) return rc;
    for (int side = 0; rc == 0 && local.triangle_count > 0 && side < SIDES; side++)
        rc = place_side(m, &local, leader, (enum gltf_side)side, place, fault);
    if (rc == 0 && local.triangle_count > 0) rc = gltf_movables_store(m, &local, leader, fault);
    mesh_fini(&local);
    return rc;
}
