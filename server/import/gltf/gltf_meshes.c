/* Which geometry stands where.
 *
 * Primitives that name the same accessors share one geometry, whatever their materials. Placed
 * once, it is baked into the world; placed more often, it is stored once and instanced. Mirrored
 * placements get a mirrored copy of the geometry, so that no transform of the blob turns a
 * triangle's winding over. Placements that flatten have no inverse and are always baked. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf.h"
#include "server/import/gltf/gltf_primitive.h"
#include "server/import/scene/origin.h"

enum side { SIDE_PLAIN, SIDE_MIRRORED, SIDE_FLAT, SIDES };

/* A mesh in one pose, at all nodes where it stands so. The first stands are the document's meshes,
 * each in its own pose. */
struct stand {
    uint32_t mesh;
    uint32_t poser; /* the node whose skin or weights pose it; SCENE_NONE: its own weights do */
};

/* A primitive that is drawn. */
struct use {
    struct gltf_geometry geometry;
    uint32_t stand;
    uint32_t mesh, primitive, material;
    uint32_t next; /* the next use of the same geometry; SCENE_NONE: the last */
    bool leads;    /* the first of its geometry */
};

struct meshes {
    struct gltf *g;
    struct use *uses; /* owned */
    uint32_t use_count, use_capacity;
    struct stand *stands; /* owned */
    uint32_t stand_count;
    uint32_t *stand_of;   /* owned; parallel to g->nodes.list; SCENE_NONE: it bears no mesh */
    uint32_t *first_node; /* owned; by stand: where its nodes begin in `nodes` */
    uint32_t *nodes;      /* owned; indexes into g->nodes.list, ordered by stand */
    uint8_t *sides;       /* owned; enum side, parallel to g->nodes.list */
    struct affine back;   /* undoes what was taken from the present geometry's positions */
};

static int out_of_memory(struct fault *fault)
{
    return fault_set(fault, ERR_MEMORY, "meshes", "no memory for the list of meshes");
}

static enum side side_of(const struct affine *to_world)
{
    if (affine_is_singular(to_world)) return SIDE_FLAT;
    return affine_determinant(to_world) < 0 ? SIDE_MIRRORED : SIDE_PLAIN;
}

/* Lists the stands. The copies of an instanced node share one. */
static int list_stands(struct meshes *m, struct fault *fault)
{
    const struct gltf_nodes *nodes = &m->g->nodes;
    const uint32_t meshes = (uint32_t)gltf_count(m->g->root, "meshes");
    m->stands = malloc(((size_t)meshes + nodes->count + 1) * sizeof *m->stands);
    m->stand_of = calloc((size_t)nodes->count + 1, sizeof *m->stand_of);
    if (m->stands == NULL || m->stand_of == NULL) return out_of_memory(fault);
    for (uint32_t i = 0; i < meshes; i++) m->stands[i] = (struct stand){i, SCENE_NONE};
    uint32_t count = meshes;
    for (uint32_t i = 0; i < nodes->count; i++) {
        const struct gltf_node *node = &nodes->list[i];
        m->stand_of[i] = node->mesh;
        if (node->mesh == SCENE_NONE || (node->skin == SCENE_NONE && !node->weighted)) continue;
        if (count == meshes || m->stands[count - 1].poser != node->index)
            m->stands[count++] = (struct stand){node->mesh, node->index};
        m->stand_of[i] = count - 1;
    }
    m->stand_count = count;
    return 0;
}

/* Sorts the nodes by stand, keeping their order. */
static int list_placements(struct meshes *m, struct fault *fault)
{
    const struct gltf_nodes *nodes = &m->g->nodes;
    m->first_node = calloc((size_t)m->stand_count + 2, sizeof *m->first_node);
    m->nodes = malloc(((size_t)nodes->count + 1) * sizeof *m->nodes);
    m->sides = malloc((size_t)nodes->count + 1);
    if (m->first_node == NULL || m->nodes == NULL || m->sides == NULL) return out_of_memory(fault);
    for (uint32_t i = 0; i < nodes->count; i++) {
        m->sides[i] = (uint8_t)side_of(&nodes->list[i].to_world);
        if (m->stand_of[i] != SCENE_NONE) m->first_node[m->stand_of[i] + 2]++;
    }
    for (size_t i = 2; i < (size_t)m->stand_count + 2; i++)
        m->first_node[i] += m->first_node[i - 1];
    for (uint32_t i = 0; i < nodes->count; i++)
        if (m->stand_of[i] != SCENE_NONE) m->nodes[m->first_node[m->stand_of[i] + 1]++] = i;
    return 0;
}

static int append_use(struct meshes *m, const struct use *use, struct fault *fault)
{
    if (m->use_count == m->use_capacity) {
        uint32_t capacity = m->use_capacity * 2 + 64;
        struct use *uses = realloc(m->uses, capacity * sizeof *uses);
        if (uses == NULL) return out_of_memory(fault);
        m->uses = uses;
        m->use_capacity = capacity;
    }
    if (m->use_count == LIMIT_MESHES)
        return fault_set(fault, ERR_LIMIT, "meshes", "the scene has more than %u primitives",
                         LIMIT_MESHES);
    m->uses[m->use_count++] = *use;
    return 0;
}

/* Lists the primitives of a mesh that stands somewhere. */
static int list_primitives(struct meshes *m, uint32_t stand, struct fault *fault)
{
    const uint32_t mesh = m->stands[stand].mesh;
    const json_t *json, *primitives;
    gltf_place place;
    int rc = gltf_item(m->g->root, "meshes", mesh, &json, place, fault);
    if (rc == 0) rc = gltf_array(json, place, "primitives", &primitives, fault);
    for (uint32_t p = 0; rc == 0 && p < json_array_size(primitives); p++) {
        struct gltf_primitive primitive;
        rc = gltf_primitive_read(m->g, mesh, p, m->stands[stand].poser, &primitive, fault);
        if (rc != 0 || !primitive.drawn) continue;
        struct use use = {.geometry = primitive.geometry,
                          .stand = stand,
                          .mesh = mesh,
                          .primitive = p,
                          .material = primitive.material,
                          .next = SCENE_NONE};
        rc = append_use(m, &use, fault);
    }
    return rc;
}

struct sorted_use {
    struct gltf_geometry geometry;
    uint32_t index;
};

static int compare_uses(const void *a, const void *b)
{
    const struct sorted_use *x = a, *y = b;
    int order = memcmp(&x->geometry, &y->geometry, sizeof x->geometry);
    return order != 0 ? order : (x->index > y->index) - (x->index < y->index);
}

/* Chains the uses of equal geometry, each chain in the file's order. */
static int chain_uses(struct meshes *m, struct fault *fault)
{
    struct sorted_use *sorted = malloc(((size_t)m->use_count + 1) * sizeof *sorted);
    if (sorted == NULL) return out_of_memory(fault);
    for (uint32_t i = 0; i < m->use_count; i++)
        sorted[i] = (struct sorted_use){m->uses[i].geometry, i};
    qsort(sorted, m->use_count, sizeof *sorted, compare_uses);
    for (uint32_t i = 0; i < m->use_count; i++) {
        bool same = i > 0 && memcmp(&sorted[i].geometry, &sorted[i - 1].geometry,
                                    sizeof sorted->geometry) == 0;
        m->uses[sorted[i].index].leads = !same;
        if (same) m->uses[sorted[i - 1].index].next = sorted[i].index;
    }
    free(sorted);
    return 0;
}

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
static int append_mesh(struct gltf *g, const struct scene_mesh *geometry, const struct use *use,
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

/* Appends an instance of the last mesh. */
static int append_instance(struct gltf *g, const struct gltf_node *node,
                           const struct affine *to_world, struct fault *fault)
{
    struct scene_instance record = {.mesh = (uint32_t)builder_count(g->builder, SCENE_MESHES) - 1};
    void *at;
    if (affine_is_identity(to_world)) record.flags = INSTANCE_IDENTITY;
    for (int i = 0; i < 12; i++) record.to_world[i] = (float)to_world->m[i];
    int rc = name_of(g, "nodes", node->index, &record.name, fault);
    if (rc == 0) rc = builder_append(g->builder, SCENE_INSTANCES, 1, &at, fault);
    if (rc == 0) memcpy(at, &record, sizeof record);
    return rc;
}

/* Bakes one placement: a mesh of its own, in world coordinates. */
static int bake(struct meshes *m, const struct mesh *local, const struct use *use,
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
    if (rc == 0) rc = append_mesh(g, &record, use, fault);
    if (rc == 0) rc = append_instance(g, node, &identity, fault);
    mesh_fini(&baked);
    return rc;
}

/* Returns how often a use is placed on one side. */
static uint64_t count_side(const struct meshes *m, const struct use *use, enum side side)
{
    uint64_t count = 0;
    for (uint32_t i = m->first_node[use->stand]; i < m->first_node[use->stand + 1]; i++)
        count += m->sides[m->nodes[i]] == side;
    return count;
}

static int bake_side(struct meshes *m, const struct mesh *local, uint32_t leader, enum side side,
                     struct fault *fault)
{
    int rc = 0;
    for (uint32_t u = leader; rc == 0 && u != SCENE_NONE; u = m->uses[u].next) {
        const struct use *use = &m->uses[u];
        for (uint32_t i = m->first_node[use->stand]; rc == 0 && i < m->first_node[use->stand + 1];
             i++)
            if (m->sides[m->nodes[i]] == side)
                rc = bake(m, local, use, &m->g->nodes.list[m->nodes[i]], fault);
    }
    return rc;
}

/* Stores the geometry once, then a mesh for each use and an instance for each placement. */
static int instance_side(struct meshes *m, const struct mesh *geometry, uint32_t leader,
                         enum side side, struct fault *fault)
{
    struct scene_mesh record;
    int rc = mesh_append(geometry, m->g->builder, &record, fault);
    for (uint32_t u = leader; rc == 0 && u != SCENE_NONE; u = m->uses[u].next) {
        const struct use *use = &m->uses[u];
        if (count_side(m, use, side) == 0) continue;
        rc = append_mesh(m->g, &record, use, fault);
        for (uint32_t i = m->first_node[use->stand]; rc == 0 && i < m->first_node[use->stand + 1];
             i++) {
            if (m->sides[m->nodes[i]] != side) continue;
            const struct gltf_node *node = &m->g->nodes.list[m->nodes[i]];
            struct affine to_world = affine_multiply(&node->to_world, &m->back);
            if (side == SIDE_MIRRORED) to_world = affine_mirrored(&to_world);
            rc = append_instance(m->g, node, &to_world, fault);
        }
    }
    return rc;
}

static int place_side(struct meshes *m, const struct mesh *local, uint32_t leader, enum side side,
                      const char *place, struct fault *fault)
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

static int place_geometry(struct meshes *m, uint32_t leader, struct fault *fault)
{
    const struct use *use = &m->uses[leader];
    struct mesh local;
    gltf_place place;
    gltf_place_set(place, "meshes[%" PRIu32 "].primitives[%" PRIu32 "]", use->mesh, use->primitive);
    double origin[3];
    int rc = gltf_geometry_load(m->g, &use->geometry, place, &local, fault);
    if (rc != 0) return rc;
    origin_move_mesh(&local, place, &m->g->builder->warnings, origin);
    m->back = affine_translation(origin);
    for (int side = 0; rc == 0 && local.triangle_count > 0 && side < SIDES; side++)
        rc = place_side(m, &local, leader, (enum side)side, place, fault);
    mesh_fini(&local);
    return rc;
}

int gltf_meshes_read(struct gltf *g, struct fault *fault)
{
    struct meshes m = {.g = g};
    int rc = list_stands(&m, fault);
    if (rc == 0) rc = list_placements(&m, fault);
    for (uint32_t i = 0; rc == 0 && i < m.stand_count; i++)
        if (m.first_node[i] < m.first_node[i + 1]) rc = list_primitives(&m, i, fault);
    if (rc == 0) rc = chain_uses(&m, fault);
    for (uint32_t u = 0; rc == 0 && u < m.use_count; u++)
        if (m.uses[u].leads) rc = place_geometry(&m, u, fault);
    free(m.uses);
    free(m.stands);
    free(m.stand_of);
    free(m.first_node);
    free(m.nodes);
    free(m.sides);
    return rc;
}
