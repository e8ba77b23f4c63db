/* Lists the primitives that are drawn and where they stand; places one geometry after the other. */
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf_places.h"

static int out_of_memory(struct fault *fault)
{
    return fault_set(fault, ERR_MEMORY, "meshes", "no memory for the list of meshes");
}

static enum gltf_side side_of(const struct affine *to_world)
{
    if (affine_is_singular(to_world)) return SIDE_FLAT;
    return affine_determinant(to_world) < 0 ? SIDE_MIRRORED : SIDE_PLAIN;
}

/* Lists the stands. The copies of an instanced node share one. */
static int list_stands(struct gltf_places *m, struct fault *fault)
{
    const struct gltf_nodes *nodes = &m->g->nodes;
    const uint32_t meshes = (uint32_t)gltf_count(m->g->root, "meshes");
    m->stands = malloc(((size_t)meshes + nodes->count + 1) * sizeof *m->stands);
    m->stand_of = calloc((size_t)nodes->count + 1, sizeof *m->stand_of);
    if (m->stands == NULL || m->stand_of == NULL) return out_of_memory(fault);
    for (uint32_t i = 0; i < meshes; i++) m->stands[i] = (struct gltf_stand){i, SCENE_NONE};
    uint32_t count = meshes;
    for (uint32_t i = 0; i < nodes->count; i++) {
        const struct gltf_node *node = &nodes->list[i];
        m->stand_of[i] = node->mesh;
        if (node->mesh == SCENE_NONE || (node->skin == SCENE_NONE && !node->weighted)) continue;
        if (count == meshes || m->stands[count - 1].poser != node->index)
            m->stands[count++] = (struct gltf_stand){node->mesh, node->index};
        m->stand_of[i] = count - 1;
    }
    m->stand_count = count;
    return 0;
}

/* Sorts the nodes by stand, keeping their order. */
static int list_placements(struct gltf_places *m, struct fault *fault)
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

static int append_use(struct gltf_places *m, const struct gltf_use *use, struct fault *fault)
{
    if (m->use_count == m->use_capacity) {
        uint32_t capacity = m->use_capacity * 2 + 64;
        struct gltf_use *uses = realloc(m->uses, capacity * sizeof *uses);
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
static int list_primitives(struct gltf_places *m, uint32_t stand, struct fault *fault)
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
        struct gltf_use use = {.geometry = primitive.geometry,
                               .stand = stand,
                               .mesh = mesh,
                               .primitive = p,
                               .material = primitive.material,
                               .own_material = primitive.own_material,
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
static int chain_uses(struct gltf_places *m, struct fault *fault)
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

int gltf_meshes_read(struct gltf *g, struct fault *fault)
{
    struct gltf_places m = {.g = g};
    int rc = list_stands(&m, fault);
    if (rc == 0) rc = list_placements(&m, fault);
    for (uint32_t i = 0; rc == 0 && i < m.stand_count; i++)
        if (m.first_node[i] < m.first_node[i + 1]) rc = list_primitives(&m, i, fault);
    if (rc == 0) rc = chain_uses(&m, fault);
    for (uint32_t u = 0; rc == 0 && u < m.use_count; u++)
        if (m.uses[u].leads)
            rc = g->phase == GLTF_FRAME ? gltf_place_moving(&m, u, fault)
                                        : gltf_place_resting(&m, u, fault);
    free(m.uses);
    free(m.stands);
    free(m.stand_of);
    free(m.first_node);
    free(m.nodes);
    free(m.sides);
    return rc;
}
