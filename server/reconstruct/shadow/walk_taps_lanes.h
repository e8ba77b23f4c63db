#pragma once
/* Finds the taps of sixteen pixels' walks: where each lies, whether the pixel accepts it, and what
 * it weighs. A pixel's taps do not depend on the pixels beside it. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/shadow/compatible_lanes.h"
#include "server/reconstruct/shadow/walk_group_lanes.h"
#include "server/reconstruct/simd/gaussian_lanes.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/vector.h"

#define WALK_LINEAR 0.8f /* share of a local linear fit's correction that is applied */

/* What a walk reads of a tap, in this order. */
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

/* What a walk reads of the receiving pixel: the same up to eta, then these. */
enum walk_asked {
    WALK_PLANE_MIN = WALK_SPREAD,
    WALK_DISTANCE_MOST2,
    WALK_DISTANCE,
    WALK_FALLOFF,
    WALK_ASKED,
};

/* Taps of sixteen pixels, from the walks' negative ends on, the nearer pixel in rows or columns
 * first. All taps are placed before any is met and weighed, so that the CPU has several of these
 * short steps in work at once. Steps of which no pixel keeps a tap are skipped. */
struct walk_taps {
    struct walk_group group;
    uint32_t steps;                  /* steps of which some pixel keeps a tap */
    uint32_t first[SHADOW_TAPS / 2]; /* nearer tap of each step */
    _Alignas(64) struct walk_tap tap[SHADOW_TAPS];
    float weight[SHADOW_TAPS][2 * SIMD_LANES]; /* of two neighbouring nodes: all lanes' lower ones
                                                    first; once balanced, lane by lane */
    uint32_t at[SHADOW_TAPS][SIMD_LANES];      /* index of the lower node among all sums */
    uint32_t phase[SHADOW_TAPS][SIMD_LANES];   /* index of the neighbour among all pixels' sums */
};

/* The receiving pixels of one vector. */
struct walk_receivers {
    struct compatible_receivers receivers;
    simd_vector u, eta, distance, falloff;
    simd_mask sums; /* index at which each pixel's sums begin */
};

/* Constants of a walk's taps. */
struct walk_rule {
    float per_length, refusal, centre;
    int32_t stride, slot_sums, phase_sums; /* sums of a node, of a slot, of a phase */
};

/* Returns how many sums are kept of a phase. With three rows and a denominator both nodes' sums are
 * kept: adding to eight sums takes fewer instructions than reducing to four first. */
static inline uint32_t walk_phase_sums(const struct shadow_field *f)
{
    return f->strata == 3 ? 8 : f->lanes;
}

static inline struct walk_rule walk_rule_of(const struct shadow_field *f, uint32_t axis,
                                            uint32_t stride)
{
    return (struct walk_rule){.per_length = f->nodes_per_length[axis],
                              .refusal = f->refusal[axis],
                              .centre = (float)f->scale,
                              .stride = (int32_t)stride,
                              .slot_sums = (int32_t)(shadow_nodes(f) * stride),
                              .phase_sums = (int32_t)walk_phase_sums(f)};
}

static inline struct walk_receivers walk_receivers_of(float own[WALK_ASKED][SIMD_LANES],
                                                      uint32_t first, uint32_t sums)
{
    struct walk_receivers a;
    for (int k = 0; k < 3; k++) {
        a.receivers.point[k] = simd_load_vector(own[WALK_POINT + k] + first);
        a.receivers.normal[k] = simd_load_vector(own[WALK_NORMAL + k] + first);
    }
    a.receivers.plane_min = simd_load_vector(own[WALK_PLANE_MIN] + first);
    a.receivers.distance_most2 = simd_load_vector(own[WALK_DISTANCE_MOST2] + first);
    a.u = simd_load_vector(own[WALK_U] + first);
    a.eta = simd_load_vector(own[WALK_ETA] + first);
    a.distance = simd_load_vector(own[WALK_DISTANCE] + first);
    a.falloff = simd_load_vector(own[WALK_FALLOFF] + first);
    for (uint32_t k = 0; k < SIMD_PER_VECTOR; k++) a.sums[k] = (int32_t)((first + k) * sums);
    return a;
}

static inline simd_mask walk_whole(const simd_number *plane, uint32_t first)
{
    return *(const simd_stored_mask *)(const void *)(plane + first);
}

/* Returns the mask of lanes that accept a tap that shows `number`, `delta` away on the light, read
 * at `node`. A spread below 0 marks a tap that every receiver accepts. */
SIMD_INLINE simd_chosen walk_counts(const struct walk_rule *rule, const struct walk_receivers *own,
                                    const simd_vector number[WALK_SLOT], simd_vector delta,
                                    simd_vector node)
{
    const simd_vector shear = simd_positive(number[WALK_ETA] - own->eta) + number[WALK_SPREAD];
    return compatible_chosen(&own->receivers, number + WALK_POINT, number + WALK_NORMAL) &
           simd_up_to(simd_positive(delta) * shear, simd_same(rule->refusal)) &
           simd_up_to(node, simd_same(2.0f * rule->centre)) & simd_up_to(simd_same(0.0f), node);
}

/* Meets tap n at the pixels q, for the lanes of one vector from `first` on: finds its weight and
 * where its sums are read and added to. Returns the mask of lanes that accept it. */
SIMD_INLINE simd_chosen walk_meet_vector(const struct walk_rule *rule, uint32_t axis,
                                         const struct walk_receivers *own,
                                         const simd_number *const q[WALK_NUMBERS], int32_t n,
                                         uint32_t first, struct walk_taps *taps)
{
    simd_vector number[WALK_SLOT];
    for (int k = 0; k < WALK_SLOT; k++) number[k] = *(const simd_stored *)(q[k] + first);
    const simd_vector delta = own->distance * (number[WALK_U] - own->u);
    const simd_vector node =
        simd_fused(-own->eta * delta, simd_same(rule->per_length), simd_same(rule->centre));
    const simd_vector share = simd_load_vector(taps->tap[n].share + first);
    const simd_vector all = share * gaussian_exp_minus_lanes(delta * delta * own->falloff);
    /* A tap of weight 0 goes with the refused ones: its node is known before its weight is. */
    const simd_chosen kept =
        walk_counts(rule, own, number, delta, node) & simd_below(simd_same(0.0f), share);
    const simd_vector counted = simd_only(kept, all), at = simd_only(kept, node);
    const simd_vector whole = gaussian_floor(at), rest = at - whole;
    const simd_mask to = walk_whole(q[WALK_SLOT], first) * rule->slot_sums +
                         __builtin_convertvector(whole, simd_mask) * rule->stride;
    *(simd_stored *)(taps->weight[n] + first) = simd_fused(-counted, rest, counted);
    *(simd_stored *)(taps->weight[n] + SIMD_LANES + first) = counted * rest;
    *(simd_stored_mask *)(taps->at[n] + first) = simd_only_whole(kept, to);
    if (axis == 0) {
        const simd_mask phase = walk_whole(q[WALK_PHASE], first) * rule->phase_sums;
        *(simd_stored_mask *)(taps->phase[n] + first) = simd_only_whole(kept, phase) + own->sums;
    }
    return kept;
}

/* Meets tap n of all lanes. Returns whether any pixel keeps it. */
SIMD_INLINE bool walk_meet(const struct walk_rule *rule, uint32_t axis,
                           const struct walk_receivers own[SIMD_VECTORS],
                           const simd_number *const q[WALK_NUMBERS], int32_t n,
                           struct walk_taps *taps)
{
    simd_chosen kept = walk_meet_vector(rule, axis, own, q, n, 0, taps);
#pragma GCC unroll 4
    for (uint32_t v = 1; v < SIMD_VECTORS; v++)
        kept |= walk_meet_vector(rule, axis, &own[v], q, n, v * SIMD_PER_VECTOR, taps);
    return simd_some(kept);
}

/* Does the same with the tap's numbers read from the pixels' planes. */
SIMD_INLINE bool walk_look(const struct walk_rule *rule, uint32_t axis,
                           const struct walk_receivers own[SIMD_VECTORS],
                           const void *const shown[WALK_NUMBERS], int32_t n, struct walk_taps *taps)
{
    const simd_number *q[WALK_NUMBERS];
    ptrdiff_t start;
    if (simd_follow(taps->tap[n].to,
                    &start)) { /* the common case: the pixels are adjacent in the planes */
        for (int k = 0; k < WALK_NUMBERS; k++) q[k] = (const simd_number *)shown[k] + start;
        return walk_meet(rule, axis, own, q, n, taps);
    }
    _Alignas(64) float taken[WALK_NUMBERS][SIMD_LANES];
    simd_take(shown, axis == 0 ? WALK_NUMBERS : WALK_PHASE, taps->tap[n].to, taken);
    for (int k = 0; k < WALK_NUMBERS; k++) q[k] = taken[k];
    return walk_meet(rule, axis, own, q, n, taps);
}

static inline float walk_step(const struct walk_group *g, uint32_t n)
{
    return (float)((int32_t)(n >> 1) - g->reach_max);
}

/* Returns the weight of tap n before it is balanced. */
static inline simd_vector walk_weight(const struct walk_taps *taps, uint32_t n, int v)
{
    const float *lower = taps->weight[n] + v * SIMD_PER_VECTOR;
    return simd_load_vector(lower) + simd_load_vector(lower + SIMD_LANES);
}

/* Balances weights by a local linear fit. Where a silhouette or a refusal cuts a walk, its taps lie
 * to one side, and what changes linearly along it would be read there instead of at the pixel. The
 * fit undoes that:
 *
 *   w_k (1 - K S1/S2 k),  S1 = sum of w k,  S2 = sum of w k^2,  K = WALK_LINEAR
 *
 * The full correction would add noise; most of it has the least error. The sum of weights stays
 * above a fifth of itself. */
static inline struct simd walk_balance_slopes(const struct walk_taps *taps)
{
    struct simd first = simd_all(0.0f), second = first, slope;
    for (uint32_t s = 0; s < taps->steps; s++) {
        const uint32_t n = taps->first[s];
        const float k = walk_step(&taps->group, n);
        for (int v = 0; v < SIMD_VECTORS; v++) {
            const simd_vector both = walk_weight(taps, n, v) + walk_weight(taps, n + 1, v);
            first.v[v] = simd_fused(both, simd_same(k), first.v[v]);
            second.v[v] = simd_fused(both, simd_same(k * k), second.v[v]);
        }
    }
    /* S2 is a sum of squares and is 0 only where S1 is. */
    const struct simd one = simd_all(1.0f);
    for (int v = 0; v < SIMD_VECTORS; v++)
        slope.v[v] =
            WALK_LINEAR * first.v[v] / (second.v[v] + simd_where(second.v[v] <= 0.0f, one.v[v]));
    return slope;
}

/* Balances the weights and stores them as pairs, lane by lane. */
static inline void walk_balance(struct walk_taps *taps)
{
    const struct simd slope = walk_balance_slopes(taps);
    for (uint32_t s = 0; s < taps->steps; s++) {
        const uint32_t first = taps->first[s];
        struct simd factor;
        for (int v = 0; v < SIMD_VECTORS; v++)
            factor.v[v] =
                simd_fused(slope.v[v], simd_same(-walk_step(&taps->group, first)), simd_same(1.0f));
        for (uint32_t n = first; n < first + 2; n++) {
            const struct simd lower = simd_load(taps->weight[n]);
            const struct simd upper = simd_load(taps->weight[n] + SIMD_LANES);
            for (int v = 0; v < SIMD_VECTORS; v++)
                simd_store_pairs(factor.v[v] * lower.v[v], factor.v[v] * upper.v[v],
                                 taps->weight[n] + 2 * v * SIMD_PER_VECTOR);
        }
    }
}

/* Weighs the walks of up to sixteen of the `left` pixels. */
SIMD_INLINE void walk_take(const struct shadow_field *f, uint32_t axis, uint32_t stride,
                           const uint32_t *pixels, uint32_t left, struct walk_taps *taps)
{
    const struct shadow_pixels *p = f->pixels;
    const void *const shown[WALK_NUMBERS] = {p->point[0],  p->point[1],  p->point[2], p->normal[0],
                                             p->normal[1], p->normal[2], p->u[axis],  p->eta,
                                             p->spread,    p->slot,      p->phase};
    const void *const asked[WALK_ASKED] = {p->point[0],       p->point[1],  p->point[2],
                                           p->normal[0],      p->normal[1], p->normal[2],
                                           p->u[axis],        p->eta,       p->plane_min,
                                           p->distance_most2, p->distance,  p->walk[axis].falloff};
    const struct walk_rule rule = walk_rule_of(f, axis, stride);
    _Alignas(64) float numbers[WALK_ASKED][SIMD_LANES];
    struct walk_receivers own[SIMD_VECTORS];
    walk_group_load(f, axis, pixels, left, &taps->group);
    simd_take(asked, WALK_ASKED, taps->group.pixel, numbers);
    for (uint32_t v = 0; v < SIMD_VECTORS; v++)
        own[v] = walk_receivers_of(numbers, v * SIMD_PER_VECTOR, f->phases * walk_phase_sums(f));
    const int32_t reach = taps->group.reach_max;
    for (int32_t k = -reach; k <= reach; k++)
        walk_place(&taps->group, k, &taps->tap[2 * (k + reach)]);
    taps->steps = 0;
    for (int32_t n = 0; n < walk_group_taps(&taps->group); n += 2) {
        const bool nearer = walk_look(&rule, axis, own, shown, n, taps);
        const bool farther = walk_look(&rule, axis, own, shown, n + 1, taps);
        taps->first[taps->steps] = (uint32_t)n;
        taps->steps += nearer | farther;
    }
    walk_balance(taps);
}
