#pragma once
/* All that frames measured, in one volume: a voxel has the mean distance to the surfaces that
 * frames saw near it, positive before them, cut at a band around them (Curless and Levoy 1996, "A
 * volumetric method for building complex models from range images"). Voxels are there in blocks,
 * and blocks only near surfaces (as Niessner et al. 2013, "Real-time 3D reconstruction at scale
 * using voxel hashing"). The same frames in the same order give the same bytes. */
#include "server/import/rgbd/depth_map.h"

#define FUSION_SIDE   8 /* voxels of a block's side */
#define FUSION_VOXELS (FUSION_SIDE * FUSION_SIDE * FUSION_SIDE)

struct fusion_voxel {
    float distance;     /* metres */
    float weight;       /* measurements at a metre that it is worth; 0: nothing is known */
    uint16_t albedo[3]; /* of 65535 */
    uint16_t shining;   /* share of the measurements that shine, of 65535 */
};

struct fusion_block {
    int32_t at[3]; /* in blocks; voxel (0, 0, 0) is at FUSION_SIDE times that */
    struct fusion_voxel voxels[FUSION_VOXELS]; /* x first */
};

struct fusion {
    double voxel_m;
    double origin[3]; /* of voxel (0, 0, 0), in the sequence's world */
    uint32_t count;
    struct fusion_block **blocks; /* owned, in the order of their making; LIMIT_FUSION_BLOCKS */
    uint32_t *table;              /* owned: 1 + a block's number, by a hash of its place */
};

/* Creates an empty volume. ERR_MEMORY. */
int fusion_create(double voxel_m, const double origin[3], struct fusion *out);
void fusion_destroy(struct fusion *f);

/* Adds a frame with colours, whose camera `pose` puts into the world. ERR_LIMIT: it would take more
 * than LIMIT_FUSION_BLOCKS blocks, or some are too far away; a larger voxel may do. ERR_MEMORY. */
int fusion_add(struct fusion *f, const struct depth_map *map, const struct rgbd_document *d,
               const struct affine *pose, const float white[3]);

/* Returns the number of the block at a place, in blocks; LIMIT_FUSION_BLOCKS: there is none. */
uint32_t fusion_find(const struct fusion *f, const int32_t at[3]);
