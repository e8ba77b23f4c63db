#pragma once
/* Groups of emitting triangles that lie and face alike. A surface bounds what each group may send
 * to it before it samples one. The bounds are those of Estevez and Kulla 2018, "Importance Sampling
 * of Many Lights with Adaptive Tree Splitting", but in a flat list instead of a tree, which all
 * lanes walk together. */
#include <stdint.h>

#include "proto/error.h"

#define EMITTER_GROUPS 32u

/* The bounds of each group: a sphere around its triangles and a cone around their normals. */
struct emitter_groups {
    uint32_t count;
    double sum[EMITTER_GROUPS];  /* of its triangles' power: area times luminance */
    float power[EMITTER_GROUPS]; /* the same */
    float x[EMITTER_GROUPS], y[EMITTER_GROUPS], z[EMITTER_GROUPS];
    float radius[EMITTER_GROUPS];
    float axis_x[EMITTER_GROUPS], axis_y[EMITTER_GROUPS], axis_z[EMITTER_GROUPS];
    float cosine[EMITTER_GROUPS], sine[EMITTER_GROUPS]; /* of the cone; -1 and 0: any direction */
    uint32_t first[EMITTER_GROUPS + 1];                 /* triangles in their new order */
};

struct emitter_shape {
    float corner[3][3];
    float normal[3]; /* unit, of the side that shines */
    double power;
    uint32_t both_sides; /* 1: shines on both */
};

/* Puts `count` > 0 shapes into groups. Group g has the shapes order[first[g]] .. order[first[g + 1]
 * - 1]. ERR_MEMORY. */
int emitter_groups_find(const struct emitter_shape *shapes, uint32_t count, uint32_t *order,
                        struct emitter_groups *out);
