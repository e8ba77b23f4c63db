#pragma once
/* Chooses the light of a light sample: one of the plan's lights or a group of mesh emitters, in
 * proportion to what it may send to the surface. Within a group a tree is walked down. The
 * environment keeps a share of its own. */
#include "worker/trace/path/path.h"

struct path_kernels;

/* Choices of sixteen lanes: numbers as light_table.h has them, but no environment; UINT32_MAX where
 * nothing lights the surface. */
struct light_choice {
    _Alignas(LANES_ALIGN) uint32_t chosen[LANES];
    _Alignas(LANES_ALIGN) float weight[LANES]; /* of the chosen one */
    _Alignas(LANES_ALIGN) float before[LANES]; /* of all before it */
};

/* Weighs the lights for the surfaces of *v. Sets its weights and sky_share. */
void light_choice_weigh(const struct path_context *c, struct path_vertex *v);

/* Returns the probability of a light of some weight, beside the environment's share. */
static inline float light_choice_probability(float weight, float total, float sky_share)
{
    return total > 0.0f ? (1.0f - sky_share) * (weight / total) : 0.0f;
}

/* A leaf of the emitters' tree, and its probability within its group of the root. */
struct light_leaf {
    uint32_t leaf;
    float chance; /* 0: none of the group lights the surface */
};

/* Walks down from a group of the root for lane i's surface by x in [0, 1). */
struct light_leaf light_choice_descend(const struct path_context *c, const struct lanes3 *origin,
                                       const struct lanes3 *normal, int i, uint32_t group,
                                       double x);

/* Returns the probability with which light_choice_descend finds a leaf, and sets the weight of its
 * group of the root. */
float light_choice_chance(const struct path_context *c, const struct lanes3 *origin,
                          const struct lanes3 *normal, int i, uint32_t leaf, float *weight);
