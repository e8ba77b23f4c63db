#pragma once
/* Groups of emitting triangles that lie and face alike. A surface bounds what each group may send
 * to it before it samples one. The bounds are those of Estevez and Kulla 2018, "Importance Sampling
 * of Many Lights with Adaptive Tree Splitting". All lanes walk a list of groups together; what is
 * in a group may be grouped again (emitter_tree.h). */
#include <stdint.h>

#include "worker/shade/lanes.h"

#define EMITTER_GROUPS 16u

/* The largest number of groups that shapes are put into. */
#define EMITTER_GROUPS_MAX 64u

/* The bounds of each group: a sphere around its triangles and a cone around their normals. Those
 * beyond `count` have no power. */
struct emitter_groups {
    _Alignas(LANES_ALIGN) float power[EMITTER_GROUPS]; /* of its triangles: area times luminance */
    float x[EMITTER_GROUPS], y[EMITTER_GROUPS], z[EMITTER_GROUPS];
    float radius[EMITTER_GROUPS];
    float axis_x[EMITTER_GROUPS], axis_y[EMITTER_GROUPS], axis_z[EMITTER_GROUPS];
    float cosine[EMITTER_GROUPS], sine[EMITTER_GROUPS]; /* of the cone; -1 and 0: any direction */
    uint32_t count;
    uint32_t below[EMITTER_GROUPS]; /* emitter_tree.h */
};

struct emitter_shape {
    float corner[3][3];
    float normal[3]; /* unit, of the side that shines */
    double power;
    uint32_t both_sides; /* 1: shines on both */
    float magnitude;     /* of the coordinates that went into it: offset.h */
};

/* Puts the shapes first .. end - 1, end > first, and `order` into the order of groups, of which
 * there are `most` at most. Returns their number; group g has the shapes from starts[g] to before
 * starts[g + 1]. */
uint32_t emitter_groups_find(struct emitter_shape *shapes, uint32_t *order, uint32_t first,
                             uint32_t end, uint32_t most, uint32_t starts[EMITTER_GROUPS_MAX + 1]);

/* Sets the bounds of group g, which has the shapes first .. end - 1. */
void emitter_groups_bound(const struct emitter_shape *shapes, uint32_t first, uint32_t end,
                          struct emitter_groups *o, uint32_t g);

/* Returns the power of shapes. */
double emitter_groups_power(const struct emitter_shape *shapes, uint32_t first, uint32_t end);
