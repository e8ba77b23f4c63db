#pragma once
/* A wide tree of emitters: groups of triangles, in which groups of more than a few are grouped
 * again, down to leaves whose triangles are chosen by power alone. A surface weighs all groups of a
 * node together. The first nodes make up the root, whose groups are numbered through. */
#include "proto/error.h"
#include "worker/scene/emitter_groups.h"

/* emitter_groups' `below`: a node's number, or a leaf's with this bit. */
#define EMITTER_LEAF 0x80000000u

/* Leaves have at most this many triangles, or in large scenes count / EMITTER_LEAVES_MAX, which
 * bounds the tree's memory. */
#define EMITTER_LEAF_TRIANGLES 32u
#define EMITTER_LEAVES_MAX     (1u << 15)

/* Where a node or leaf hangs: below group `group` of node `node`. */
struct emitter_place {
    uint32_t node, group;
};

struct emitter_node {
    struct emitter_groups groups;
    uint32_t first[EMITTER_GROUPS + 1]; /* triangles of the groups, in the tree's order */
    struct emitter_place place;         /* not the root's */
};

struct emitter_leaf {
    double power;          /* of all its triangles */
    uint32_t first, count; /* in the tree's order */
    struct emitter_place place;
};

struct emitter_tree {
    uint32_t node_count, leaf_count;
    uint32_t root_nodes;         /* the first */
    uint32_t root_groups;        /* in all of them; all but the last are full */
    struct emitter_node *nodes;  /* owned */
    struct emitter_leaf *leaves; /* owned */
};

/* Builds the tree of `count` > 0 shapes and puts them into its order: shapes[i] was
 * shapes[order[i]] before. ERR_MEMORY: the tree is empty. */
int emitter_tree_init(struct emitter_tree *t, struct emitter_shape *shapes, uint32_t count,
                      uint32_t *order);
void emitter_tree_fini(struct emitter_tree *t);
