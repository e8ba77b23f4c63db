#pragma once
/* The taps of sixteen pixels' walks: where they lie, who counts of what lies there, what it weighs.
 * What a pixel gets does not depend on those beside it. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/fused.h"
#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/lanes_inline.h"
#include "server/reconstruct/lanes_vector.h"
#include "server/reconstruct/walk_group_lanes.h"

#define WALK_LINEAR 0.8f /* share of a local linear fit's correction */

/* What a tap reads of its neighbours, in the order of these. */
enum walk_number {
    WALK_POINT = 0,
    WALK_NORMAL = 3,
    WALK_U = 6,
    WALK_ETA,
    WALK_SPREAD,
    WALK_SLOT,
    WALK_PHASE,
    WALK_NUMBERS,
};

/* What a pixel asks with: the same up to eta, then these. */
enum walk_asked {
    WALK_PLANE_LEAST = WALK_SPREAD,
    WALK_DISTANCE_MOST2,
    WALK_DISTANCE,
    WALK_FALLOFF,
    WALK_ASKED,
};

/* Taps of sixteen pixels from the walks' negative ends on; the nearer pixel in rows or columns
 * first. All are placed, then all met and weighed: steps so short that the CPU has several taps in
 * work at once. */
struct walk_taps {
    struct walk_group group;
    _Alignas(64) float own[WALK_ASKED][SHADOW_LANES];
    _Alignas(64) struct walk_tap tap[SHADOW_TAPS];
    float weight[SHADOW_TAPS][2 * SHADOW_LANES]; /* of two neighbouring nodes: all lanes' lower ones
                                                    first; when they are balanced, lane by lane */
    uint32_t at[SHADOW_TAPS][SHADOW_LANES];      /* the lower one: its place among all sums */
    uint32_t phase[SHADOW_TAPS]
                  [SHADOW_LANES]; /* of the neighbour: its place among all pixels' sums */
};

/* Constants of a walk's taps. */
struct walk_rule {
    float per_length, refusal, centre;
    uint32_t stride, slot_sums, phases; /* sums of a node and of a phase, of a slot; phases */
};

static inline struct walk_rule walk_rule_of(const struct shadow_field *f, uint32_t axis,
                                            uint32_t stride)
{
    return (struct walk_rule){.per_length = f->nodes_per_length[axis],
                              .refusal = f->refusal[axis],
                              .centre = (float)f->scale,
                              .stride = stride,
                              .slot_sums = shadow_nodes(f) * stride,
                              .phases = f->phases};
}

/* Who counts of what lies at tap n, q, what it weighs, and where its sums are read and added to: of
 * the lanes of one vector, from `first` on. */
LANES_INLINE void walk_meet_vector(const struct walk_rule *rule, uint32_t axis,
                                   const lanes_number *const q[WALK_NUMBERS], int32_t n,
                                   uint32_t first, struct walk_taps *taps)
{
    const float(*p)[SHADOW_LANES] = (const float(*)[SHADOW_LANES])taps->own;
    const float per_length = rule->per_length, refusal = rule->refusal, centre = rule->centre;
    const uint32_t stride = rule->stride, slot_sums = rule->slot_sums, phases = rule->phases;
    uint32_t place[LANES_PER_VECTOR], phase[LANES_PER_VECTOR];
    memcpy(place, q[WALK_SLOT] + first, sizeof place);
    if (axis == 0) memcpy(phase, q[WALK_PHASE] + first, sizeof phase);
#pragma GCC ivdep
    for (uint32_t k = 0; k < LANES_PER_VECTOR; k++) {
        const uint32_t i = first + k;
        const struct asker asker = {{p[0][i], p[1][i], p[2][i]},
                                    {p[3][i], p[4][i], p[5][i]},
                                    p[WALK_PLANE_LEAST][i],
                                    p[WALK_DISTANCE_MOST2][i]};
        float squared;
        const int32_t same = compatible_point(&asker, q[0][i], q[1][i], q[2][i], q[3][i], q[4][i],
                                              q[5][i], &squared);
        const float delta = p[WALK_DISTANCE][i] * (q[WALK_U][i] - p[WALK_U][i]);
        const float shear = fabsf(q[WALK_ETA][i] - p[WALK_ETA][i]) + q[WALK_SPREAD][i];
        const float node = fused(-p[WALK_ETA][i] * delta, per_length, centre);
        const float all =
            taps->tap[n].share[i] * gaussian_exp_minus(delta * delta * p[WALK_FALLOFF][i]);
        /* weights of 0 go with the others: where a node lies is found before what it weighs is */
        const int32_t kept =
            same & (fabsf(delta) * shear <= refusal) & (node <= 2.0f * centre) & (node >= 0.0f);
        const float counted = lanes_keep(kept, all), at = kept ? node : 0.0f;
        const float whole = floorf(at), rest = at - whole;
        const uint32_t to = place[k] * slot_sums + (uint32_t)(int32_t)whole * stride;
        taps->weight[n][i] = fused(-counted, rest, counted);
        taps->weight[n][SHADOW_LANES + i] = counted * rest;
        taps->at[n][i] = kept ? to : 0;
        if (axis == 0) taps->phase[n][i] = ((kept ? phase[k] : 0) + i * phases) * stride;
    }
}

LANES_INLINE void walk_meet(const struct walk_rule *rule, uint32_t axis,
                            const lanes_number *const q[WALK_NUMBERS], int32_t n,
                            struct walk_taps *taps)
{
#pragma GCC unroll 4
    for (uint32_t v = 0; v < LANES_VECTORS; v++)
        walk_meet_vector(rule, axis, q, n, v * LANES_PER_VECTOR, taps);
}

/* The same of planes of what pixels show. */
LANES_INLINE void walk_look(const struct walk_rule *rule, uint32_t axis,
                            const void *const shown[WALK_NUMBERS], int32_t n,
                            struct walk_taps *taps)
{
    const lanes_number *q[WALK_NUMBERS];
    ptrdiff_t start;
    if (lanes_follow(taps->tap[n].to, &start)) { /* the common case: as they lie there */
        for (int k = 0; k < WALK_NUMBERS; k++) q[k] = (const lanes_number *)shown[k] + start;
        walk_meet(rule, axis, q, n, taps);
    } else {
        _Alignas(64) float taken[WALK_NUMBERS][SHADOW_LANES];
        lanes_take(shown, axis == 0 ? WALK_NUMBERS : WALK_PHASE, taps->tap[n].to, taken);
        for (int k = 0; k < WALK_NUMBERS; k++) q[k] = taken[k];
        walk_meet(rule, axis, q, n, taps);
    }
}

/* Where a silhouette or a refusal cuts a walk, its taps lie to one side, and what changes linearly
 * along it is read there, not at the pixel. A local linear fit undoes that: weights w (1 - k S1/S2)
 * of tap k, S1 and S2 the sums of w k and w k^2. Weights go through all of their noise with it:
 * most of the correction has the least error. The sum of weights stays above a fifth of itself. */
static inline struct lanes walk_balance_slopes(const struct walk_taps *taps)
{
    const int32_t reach = taps->group.reach_most, count = walk_group_taps(&taps->group);
    struct lanes first = lanes_all(0.0f), second = first, slope;
    for (int32_t n = 0; n < count; n++) {
        const float k = (float)((n >> 1) - reach);
        const struct lanes lower = lanes_load(taps->weight[n]);
        const struct lanes upper = lanes_load(taps->weight[n] + SHADOW_LANES);
        for (int v = 0; v < LANES_VECTORS; v++) {
            const lanes_vector both = lower.v[v] + upper.v[v];
            first.v[v] = lanes_fused(both, lanes_same(k), first.v[v]);
            second.v[v] = lanes_fused(both, lanes_same(k * k), second.v[v]);
        }
    }
    /* S2 is a sum of squares, and 0 only where S1 is. */
    const struct lanes one = lanes_all(1.0f);
    for (int v = 0; v < LANES_VECTORS; v++)
        slope.v[v] =
            WALK_LINEAR * first.v[v] / (second.v[v] + lanes_where(second.v[v] <= 0.0f, one.v[v]));
    return slope;
}

/* Weights become pairs, lane by lane. */
static inline void walk_balance(struct walk_taps *taps)
{
    const int32_t reach = taps->group.reach_most, count = walk_group_taps(&taps->group);
    struct lanes slope = walk_balance_slopes(taps);
    for (int32_t n = 0; n < count; n++) {
        const float k = (float)((n >> 1) - reach);
        const struct lanes lower = lanes_load(taps->weight[n]);
        const struct lanes upper = lanes_load(taps->weight[n] + SHADOW_LANES);
        for (int v = 0; v < LANES_VECTORS; v++) {
            const lanes_vector factor = lanes_fused(slope.v[v], lanes_same(-k), lanes_same(1.0f));
            lanes_store_pairs(factor * lower.v[v], factor * upper.v[v],
                              taps->weight[n] + 2 * v * LANES_PER_VECTOR);
        }
    }
}

/* Weighs the walks of up to sixteen of the `left` pixels. */
LANES_INLINE void walk_take(const struct shadow_field *f, uint32_t axis, uint32_t stride,
                            const uint32_t *pixels, uint32_t left, struct walk_taps *taps)
{
    const struct shadow_pixels *p = f->pixels;
    const void *const shown[WALK_NUMBERS] = {p->point[0],  p->point[1],  p->point[2], p->normal[0],
                                             p->normal[1], p->normal[2], p->u[axis],  p->eta,
                                             p->spread,    p->slot,      p->phase};
    const void *const asked[WALK_ASKED] = {p->point[0],       p->point[1],  p->point[2],
                                           p->normal[0],      p->normal[1], p->normal[2],
                                           p->u[axis],        p->eta,       p->plane_least,
                                           p->distance_most2, p->distance,  p->walk[axis].falloff};
    const struct walk_rule rule = walk_rule_of(f, axis, stride);
    walk_group_load(f, axis, pixels, left, &taps->group);
    lanes_take(asked, WALK_ASKED, taps->group.pixel, taps->own);
    const int32_t reach = taps->group.reach_most, count = walk_group_taps(&taps->group);
    for (int32_t k = -reach; k <= reach; k++)
        walk_place(&taps->group, k, &taps->tap[2 * (k + reach)]);
    for (int32_t n = 0; n < count; n++) walk_look(&rule, axis, shown, n, taps);
    walk_balance(taps);
}
