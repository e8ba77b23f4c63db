#pragma once
/* Finds which geometry stands where.
 *
 * Primitives that name the same accessors share one geometry, whatever their materials. Placed
 * once, it is baked into the world; placed more often, it is stored once and instanced. Mirrored
 * placements get a mirrored copy of the geometry, so that no transform of the blob turns a
 * triangle's winding over. Placements that flatten have no inverse and are always baked.
 *
 * A base has what rests, and a mesh for each primitive that is only placed elsewhere by frames.
 * Frames place those, and have of their own what bends: skins, morph targets that are animated, and
 * surfaces whose material is. */
#include "server/import/gltf/gltf.h"
#include "server/import/gltf/gltf_primitive.h"

enum gltf_side { SIDE_PLAIN, SIDE_MIRRORED, SIDE_FLAT, SIDES };

/* A mesh in one pose, at all nodes where it stands so. The first stands are the document's meshes,
 * each in its own pose. */
struct gltf_stand {
    uint32_t mesh;
    uint32_t poser; /* the node whose skin or weights pose it; SCENE_NONE: its own weights do */
};

/* A primitive that is drawn. */
struct gltf_use {
    struct gltf_geometry geometry;
    uint32_t stand;
    uint32_t mesh, primitive, material;
    uint32_t own_material; /* of the document; SCENE_NONE: none */
    uint32_t next;         /* the next use of the same geometry; SCENE_NONE: the last */
    bool leads;            /* the first of its geometry */
};

struct gltf_places {
    struct gltf *g;
    struct gltf_use *uses; /* owned */
    uint32_t use_count, use_capacity;
    struct gltf_stand *stands; /* owned */
    uint32_t stand_count;
    uint32_t *stand_of;   /* owned; parallel to g->nodes.list; SCENE_NONE: it bears no mesh */
    uint32_t *first_node; /* owned; by stand: where its nodes begin in `nodes` */
    uint32_t *nodes;      /* owned; indexes into g->nodes.list, ordered by stand */
    uint8_t *sides;       /* owned; enum gltf_side, parallel to g->nodes.list */
    struct affine back;   /* undoes what was taken from the present geometry's positions */
};

/* How a placement takes part in an animation. */
enum gltf_motion { MOTION_NONE, MOTION_RIGID, MOTION_BENT };

enum gltf_motion gltf_motion_of(const struct gltf_places *m, const struct gltf_use *use,
                                const struct gltf_node *node);

/* Loads a use's geometry, and sets m->back. */
int gltf_use_load(struct gltf_places *m, const struct gltf_use *use, struct mesh *out,
                  struct fault *fault);

/* Append a mesh record, the ranges of `geometry` with the material of a use, and an instance. */
int gltf_use_append(struct gltf *g, const struct scene_mesh *geometry, const struct gltf_use *use,
                    struct fault *fault);
int gltf_instance_append(struct gltf *g, uint32_t mesh, const struct gltf_node *node,
                         const struct affine *to_world, struct fault *fault);

static inline uint32_t gltf_last_mesh(const struct gltf *g)
{
    return (uint32_t)builder_count(g->builder, SCENE_MESHES) - 1;
}

/* Returns how often a use is placed with a motion. */
uint64_t gltf_count_motion(const struct gltf_places *m, const struct gltf_use *use,
                           enum gltf_motion motion);

/* Bakes one placement: a mesh of its own, in world coordinates. */
int gltf_use_bake(struct gltf_places *m, const struct mesh *local, const struct gltf_use *use,
                  const struct gltf_node *node, struct fault *fault);

/* Place the uses of a geometry that rest, and store what frames will place; place those that move.
 */
int gltf_place_resting(struct gltf_places *m, uint32_t leader, struct fault *fault);
int gltf_place_moving(struct gltf_places *m, uint32_t leader, struct fault *fault);

/* Stores a mesh for each use of a geometry that frames will place. */
int gltf_movables_store(struct gltf_places *m, const struct mesh *local, uint32_t leader,
                        struct fault *fault);
