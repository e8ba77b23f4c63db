#pragma once
/* The nodes of the displayed scene, in the order of the file, with their world transforms. */
#include <stdint.h>

#include "proto/error.h"
#include "server/import/scene/transform.h"

struct gltf;

struct gltf_node {
    uint32_t index;                     /* in the document */
    uint32_t mesh, skin, camera, light; /* SCENE_NONE: none */
    bool weighted;                      /* morph weights of its own, in place of the mesh's */
    bool moves;                         /* by an animation or the job, alone or with an ancestor */
    uint32_t moved;                     /* by which of the job's moves; bits */
    struct affine to_world; /* with a skin, whose joints place its vertices, what the job moves it
                               by */
};

struct gltf_nodes {
    struct gltf_node *list; /* owned; depth first; only nodes with a mesh, camera or light */
    uint32_t count, capacity;
    uint8_t *visited;     /* owned; by document index */
    struct affine *world; /* owned; by document index, where visited; NULL: no skin needs it */
};

/* Reads the nodes. ERR_LIMIT for deep nesting, ERR_CORRUPT for loops and nodes with two parents. */
int gltf_nodes_read(struct gltf *g, struct fault *fault);
void gltf_nodes_fini(struct gltf_nodes *nodes);

/* Adds a node to the list, if it bears anything. ERR_MEMORY, ERR_LIMIT. */
int gltf_node_keep(struct gltf_nodes *nodes, const struct gltf_node *node, struct fault *fault);
