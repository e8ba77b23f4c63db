#include "worker/scene/emitter_tree.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct builder {
    struct emitter_tree *tree;
    struct emitter_shape *shapes;
    uint32_t *order;
    uint32_t node_room, leaf_room;
    uint32_t leaf_max; /* triangles */
};

/* Makes room for one more item of `size` bytes, a multiple of 8. Returns the items, or
 * NULL without memory: the old ones stay. */
static void *grow(void *items, uint32_t count, uint32_t *room, size_t size)
{
    if (count < *room) return items;
    const uint32_t more = *room > 0 ? 2 * *room : 8;
    void *grown = aligned_alloc(LANES_ALIGN, more * size);
    if (!grown) return NULL;
    if (count > 0) memcpy(grown, items, count * size);
    free(items);
    *room = more;
    return grown;
}

static int add_leaf(struct builder *b, uint32_t first, uint32_t end, struct emitter_place place)
{
    struct emitter_tree *t = b->tree;
    struct emitter_leaf *leaves = grow(t->leaves, t->leaf_count, &b->leaf_room, sizeof *leaves);
    if (!leaves) return ERR_MEMORY;
    t->leaves = leaves;
    t->nodes[place.node].groups.below[place.group] = t->leaf_count | EMITTER_LEAF;
    leaves[t->leaf_count++] = (struct emitter_leaf){emitter_groups_power(b->shapes, first, end),
                                                    first, end - first, place};
    return 0;
}

/* Adds a node of groups that start at starts[0 .. count]. */
static int add_node(struct builder *b, const uint32_t *starts, uint32_t count,
                    struct emitter_place place)
{
    struct emitter_tree *t = b->tree;
    struct emitter_node *nodes = grow(t->nodes, t->node_count, &b->node_room, sizeof *nodes);
    if (!nodes) return ERR_MEMORY;
    struct emitter_node *node = &nodes[t->node_count++];
    t->nodes = nodes;
    memset(node, 0, sizeof *node);
    node->place = place;
    node->groups.count = count;
    for (uint32_t g = 0; g <= count; g++) node->first[g] = starts[g];
    for (uint32_t g = 0; g < count; g++)
        emitter_groups_bound(b->shapes, starts[g], starts[g + 1], &node->groups, g);
    return 0;
}

static int add_root(struct builder *b, uint32_t count)
{
    struct emitter_tree *t = b->tree;
    uint32_t starts[EMITTER_GROUPS_MAX + 1];
    int rc = 0;
    t->root_groups = emitter_groups_find(b->shapes, b->order, 0, count, EMITTER_GROUPS_MAX, starts);
    for (uint32_t g = 0; rc == 0 && g < t->root_groups; g += EMITTER_GROUPS) {
        const uint32_t left = t->root_groups - g;
        rc = add_node(b, starts + g, left < EMITTER_GROUPS ? left : EMITTER_GROUPS,
                      (struct emitter_place){0, 0});
    }
    t->root_nodes = t->node_count;
    return rc;
}

/* Hangs a leaf or a node below a group. What cannot be told apart is a leaf. */
static int hang(struct builder *b, struct emitter_place place)
{
    const struct emitter_node *node = &b->tree->nodes[place.node];
    const uint32_t first = node->first[place.group], end = node->first[place.group + 1];
    uint32_t starts[EMITTER_GROUPS_MAX + 1], count = 1;
    if (end - first > b->leaf_max)
        count = emitter_groups_find(b->shapes, b->order, first, end, EMITTER_GROUPS, starts);
    if (count == 1) return add_leaf(b, first, end, place);
    const uint32_t number = b->tree->node_count;
    const int rc = add_node(b, starts, count, place);
    if (rc == 0) b->tree->nodes[place.node].groups.below[place.group] = number;
    return rc;
}

/* Nodes wait behind each other until all their groups have something below them. */
static int build(struct builder *b, uint32_t count)
{
    int rc = add_root(b, count);
    for (uint32_t i = 0; rc == 0 && i < b->tree->node_count; i++)
        for (uint32_t g = 0; rc == 0 && g < b->tree->nodes[i].groups.count; g++)
            rc = hang(b, (struct emitter_place){i, g});
    return rc;
}

int emitter_tree_init(struct emitter_tree *t, struct emitter_shape *shapes, uint32_t count,
                      uint32_t *order)
{
    const uint32_t part = count / EMITTER_LEAVES_MAX;
    struct builder b = {.tree = t, .shapes = shapes, .order = order};
    memset(t, 0, sizeof *t);
    b.leaf_max = part > EMITTER_LEAF_TRIANGLES ? part : EMITTER_LEAF_TRIANGLES;
    for (uint32_t i = 0; i < count; i++) order[i] = i;
    const int rc = build(&b, count);
    if (rc != 0) emitter_tree_fini(t);
    return rc;
}

void emitter_tree_fini(struct emitter_tree *t)
{
    free(t->nodes);
    free(t->leaves);
    memset(t, 0, sizeof *t);
}
