#pragma once
/* The taps of sixteen pixels' walks: where they lie, who counts of what lies there, what it weighs.
 * What a pixel gets does not depend on those beside it. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/lanes_inline.h"
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

/* A number of sixteen pixels. */
typedef float walk_sixteen __attribute__((vector_size(4 * SHADOW_LANES), may_alias));
typedef int32_t walk_whole_sixteen __attribute__((vector_size(4 * SHADOW_LANES)));

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

/* Who counts of what lies at tap n, q, what it weighs, and where its sums are read and added to. */
LANES_INLINE void walk_meet(const struct walk_rule *rule, uint32_t axis,
                            const lanes_number *const q[WALK_NUMBERS], int32_t n,
                            struct walk_taps *taps)
{
    const float(*p)[SHADOW_LANES] = (const float(*)[SHADOW_LANES])taps->own;
    const float per_length = rule->per_length, refusal = rule->refusal, centre = rule->centre;
    const uint32_t stride = rule->stride, slot_sums = rule->slot_sums, phases = rule->phases;
    _Alignas(64) float weight[2][SHADOW_LANES];
    _Alignas(64) uint32_t place[SHADOW_LANES], phase[SHADOW_LANES];
    memcpy(place, q[WALK_SLOT], sizeof place);
    if (axis == 0) memcpy(phase, q[WALK_PHASE], sizeof phase);
    for (uint32_t i = 0; i < SHADOW_LANES; i++) {
        const struct asker asker = {{p[0][i], p[1][i], p[2][i]},
                                    {p[3][i], p[4][i], p[5][i]},
                                    p[WALK_PLANE_LEAST][i],
                                    p[WALK_DISTANCE_MOST2][i]};
        float squared;
        const int32_t same = compatible_point(&asker, q[0][i], q[1][i], q[2][i], q[3][i], q[4][i],
                                              q[5][i], &squared);
        const float delta = p[WALK_DISTANCE][i] * (q[WALK_U][i] - p[WALK_U][i]);
        const float shear = fabsf(q[WALK_ETA][i] - p[WALK_ETA][i]) + q[WALK_SPREAD][i];
        const float node = centre - p[WALK_ETA][i] * delta * per_length;
        const float all =
            taps->tap[n].share[i] * gaussian_exp_minus(delta * delta * p[WALK_FALLOFF][i]);
        const int32_t kept = same & (fabsf(delta) * shear <= refusal) & (node <= 2.0f * centre) &
                             (node >= 0.0f) & (all > 0.0f);
        const float counted = kept ? all : 0.0f, at = kept ? node : 0.0f;
        const float whole = floorf(at), rest = at - whole;
        const uint32_t to = place[i] * slot_sums + (uint32_t)(int32_t)whole * stride;
        weight[0][i] = counted * (1.0f - rest);
        weight[1][i] = counted * rest;
        place[i] = kept ? to : 0;
        if (axis == 0) phase[i] = ((kept ? phase[i] : 0) + i * phases) * stride;
    }
    memcpy(taps->weight[n], weight, sizeof weight);
    memcpy(taps->at[n], place, sizeof place);
    if (axis == 0) memcpy(taps->phase[n], phase, sizeof phase);
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
static inline void walk_balance(struct walk_taps *taps)
{
    const int32_t reach = taps->group.reach_most, count = walk_group_taps(&taps->group);
    walk_sixteen first = {0}, second = {0};
    for (int32_t n = 0; n < count; n++) {
        const float k = (float)((n >> 1) - reach);
        const walk_sixteen *w = (const walk_sixteen *)taps->weight[n];
        const walk_sixteen moment = k * (w[0] + w[1]);
        first += moment;
        second += moment * k;
    }
    /* S2 is a sum of squares, and 0 only where S1 is. */
    const walk_sixteen one = (walk_sixteen){0} + 1.0f;
    const walk_sixteen none = (walk_sixteen)((second <= 0.0f) & (walk_whole_sixteen)one);
    const walk_sixteen slope = WALK_LINEAR * first / (second + none);
    _Alignas(64) float slopes[SHADOW_LANES];
    *(walk_sixteen *)slopes = slope;
    for (int32_t n = 0; n < count; n++) {
        const float k = (float)((n >> 1) - reach);
        float pairs[2 * SHADOW_LANES];
        for (uint32_t i = 0; i < SHADOW_LANES; i++) {
            const float factor = 1.0f - slopes[i] * k;
            pairs[2 * i] = factor * taps->weight[n][i];
            pairs[2 * i + 1] = factor * taps->weight[n][SHADOW_LANES + i];
        }
        memcpy(taps->weight[n], pairs, sizeof pairs);
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
