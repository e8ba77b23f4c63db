#pragma once
/* shadow_kernels' walks: passes 1b and 2b. Sixteen pixels go side by side to where their taps are
 * weighed; then each sums what its own give, one after the other. What a pixel gets does not depend
 * on those beside it. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/gaussian.h"
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

/* What sixteen pixels ask with. */
struct walk_askers {
    float own[WALK_SPREAD][SHADOW_LANES]; /* their numbers, up to eta */
    float plane_least[SHADOW_LANES], distance_most2[SHADOW_LANES];
    float distance[SHADOW_LANES], falloff[SHADOW_LANES];
};

/* A number of sixteen pixels. */
typedef float walk_sixteen __attribute__((vector_size(4 * SHADOW_LANES), may_alias));
typedef int32_t walk_whole_sixteen __attribute__((vector_size(4 * SHADOW_LANES)));

/* Taps of sixteen pixels from the walks' negative ends on; the nearer pixel in rows or columns
 * first. They are placed, met and weighed one kind of step after the other, each of which is short:
 * then the CPU has several taps in work at once. */
struct walk_taps {
    struct walk_group group;
    struct walk_askers askers;
    _Alignas(64) struct walk_tap tap[SHADOW_TAPS];
    float weight[SHADOW_TAPS][2][SHADOW_LANES]; /* of two neighbouring nodes */
    int32_t at[SHADOW_TAPS][SHADOW_LANES];      /* the lower one: its place among all sums */
    int32_t phase[SHADOW_TAPS][SHADOW_LANES];   /* of the neighbour */
};

static inline void walk_ask(const struct shadow_field *f, uint32_t axis, const float *const *planes,
                            struct walk_taps *taps)
{
    struct walk_askers *a = &taps->askers;
    walk_fetch(planes, WALK_SPREAD, taps->group.pixel, a->own);
    for (uint32_t i = 0; i < SHADOW_LANES; i++) {
        const struct shadow_target *t = &f->targets[taps->group.pixel[i]];
        a->plane_least[i] = t->plane_least;
        a->distance_most2[i] = t->distance_most2;
        a->distance[i] = t->distance;
        a->falloff[i] = t->walk[axis].falloff;
    }
}

static inline int32_t walk_whole(float number)
{
    int32_t whole;
    memcpy(&whole, &number, sizeof whole);
    return whole;
}

/* Finds who counts of what lies at tap n, q: how far along the walk as an exponent of the weight
 * (weight[n][0]), the node that is read (weight[n][1]; below 0: it does not count) and the place of
 * the neighbour's sums, of which there are `slot_sums`. */
static inline void walk_meet(const struct shadow_field *f, uint32_t axis, int32_t slot_sums,
                             float q[][SHADOW_LANES], int32_t n, struct walk_taps *taps)
{
    const struct walk_askers *a = &taps->askers;
    const float(*p)[SHADOW_LANES] = (const float(*)[SHADOW_LANES])a->own;
    const float per_length = f->nodes_per_length[axis], refusal = f->refusal[axis];
    const float centre = (float)f->scale;
    float exponent[SHADOW_LANES], nodes[SHADOW_LANES];
    int32_t place[SHADOW_LANES], phase[SHADOW_LANES];
    for (uint32_t i = 0; i < SHADOW_LANES; i++) {
        const struct asker asker = {{p[0][i], p[1][i], p[2][i]},
                                    {p[3][i], p[4][i], p[5][i]},
                                    a->plane_least[i],
                                    a->distance_most2[i]};
        float squared;
        const int32_t same = compatible_point(&asker, q[0][i], q[1][i], q[2][i], q[3][i], q[4][i],
                                              q[5][i], &squared);
        const float delta = a->distance[i] * (q[WALK_U][i] - p[WALK_U][i]);
        const float shear = fabsf(q[WALK_ETA][i] - p[WALK_ETA][i]) + q[WALK_SPREAD][i];
        const float node = centre - p[WALK_ETA][i] * delta * per_length;
        const int32_t kept = same & (fabsf(delta) * shear <= refusal) & (node <= 2.0f * centre);
        exponent[i] = delta * delta * a->falloff[i];
        nodes[i] = kept ? node : -1.0f;
        place[i] = walk_whole(q[WALK_SLOT][i]) * slot_sums;
        phase[i] = walk_whole(q[WALK_PHASE][i]);
    }
    memcpy(taps->weight[n][0], exponent, sizeof exponent);
    memcpy(taps->weight[n][1], nodes, sizeof nodes);
    memcpy(taps->at[n], place, sizeof place);
    memcpy(taps->phase[n], phase, sizeof phase);
}

/* What tap n weighs, and where its sums are read; a node has `stride` of them. */
static inline void walk_weigh(int32_t stride, int32_t n, struct walk_taps *taps)
{
    float weight[2][SHADOW_LANES];
    int32_t place[SHADOW_LANES], phase[SHADOW_LANES];
    for (uint32_t i = 0; i < SHADOW_LANES; i++) {
        const float node = taps->weight[n][1][i];
        const float all = taps->tap[n].share[i] * gaussian_exp_minus(taps->weight[n][0][i]);
        const int32_t kept = (node >= 0.0f) & (all > 0.0f);
        const float counted = kept ? all : 0.0f, at = kept ? node : 0.0f;
        const float whole = floorf(at), rest = at - whole;
        const int32_t lower = taps->at[n][i] + (int32_t)whole * stride, its = taps->phase[n][i];
        weight[0][i] = counted * (1.0f - rest);
        weight[1][i] = counted * rest;
        place[i] = kept ? lower : 0;
        phase[i] = kept ? its : 0;
    }
    memcpy(taps->weight[n], weight, sizeof weight);
    memcpy(taps->at[n], place, sizeof place);
    memcpy(taps->phase[n], phase, sizeof phase);
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
    for (int32_t n = 0; n < count; n++) {
        const walk_sixteen factor = 1.0f - slope * (float)((n >> 1) - reach);
        walk_sixteen *w = (walk_sixteen *)taps->weight[n];
        w[0] *= factor;
        w[1] *= factor;
    }
}

/* Weighs the walks of up to sixteen of the `left` pixels. */
static inline void walk_take(const struct shadow_field *f, uint32_t axis, uint32_t stride,
                             const uint32_t *pixels, uint32_t left, struct walk_taps *taps)
{
    const float *const *all = f->planes;
    const float *const planes[WALK_NUMBERS] = {
        all[SHADOW_POINT],      all[SHADOW_POINT + 1],  all[SHADOW_POINT + 2], all[SHADOW_NORMAL],
        all[SHADOW_NORMAL + 1], all[SHADOW_NORMAL + 2], all[SHADOW_U + axis],  all[SHADOW_ETA],
        all[SHADOW_SPREAD],     all[SHADOW_SLOT],       all[SHADOW_PHASE]};
    const int32_t slot_sums = (int32_t)(shadow_nodes(f) * stride);
    walk_group_load(f, axis, pixels, left, &taps->group);
    walk_ask(f, axis, planes, taps);
    const int32_t reach = taps->group.reach_most, count = walk_group_taps(&taps->group);
    for (int32_t k = -reach; k <= reach; k++)
        walk_place(&taps->group, k, &taps->tap[2 * (k + reach)]);
    for (int32_t n = 0; n < count; n++) {
        float q[WALK_NUMBERS][SHADOW_LANES];
        walk_fetch(planes, WALK_NUMBERS, taps->tap[n].to, q);
        walk_meet(f, axis, slot_sums, q, n, taps);
    }
    for (int32_t n = 0; n < count; n++) walk_weigh((int32_t)stride, n, taps);
    walk_balance(taps);
}

/* The taps that lane i has: from *first to before *end. */
static inline void walk_span(const struct walk_taps *taps, uint32_t i, int32_t *first, int32_t *end)
{
    const int32_t centre = 2 * taps->group.reach_most, most = 2 * taps->group.reach[i];
    *first = centre - most;
    *end = centre + most + 2;
}

/* To the sums of each phase what two neighbouring nodes of lane i's taps give. */
static inline void walk_add(const struct shadow_field *f, uint32_t lanes,
                            const struct walk_taps *taps, uint32_t i, float *sums)
{
    const uint32_t next = (i + 1) % SHADOW_LANES; /* whose sums the CPU may fetch meanwhile */
    int32_t first, end;
    walk_span(taps, i, &first, &end);
    for (int32_t n = first; n < end; n++) {
        const float *c = f->columns + taps->at[n][i];
        const float w0 = taps->weight[n][0][i], w1 = taps->weight[n][1][i];
        float *to = sums + taps->phase[n][i] * (int32_t)lanes;
        __builtin_prefetch(f->columns + taps->at[n][next]);
        for (uint32_t b = 0; b < lanes; b += 4)
            *(shadow_four *)(to + b) +=
                w0 * *(const shadow_four *)(c + b) + w1 * *(const shadow_four *)(c + lanes + b);
    }
}

/* From sums a phase to (numerator, denominator) a cell. */
static inline void walk_cells(uint32_t l, uint32_t lanes, uint32_t phases, uint32_t cells,
                              const float *sums, float *out)
{
    const uint32_t each = l * phases / cells;
    uint32_t phase = 0, row = 0;
    for (uint32_t c = 0; c < cells; c++) {
        float numerator = 0.0f, denominator = 0.0f;
        for (uint32_t k = 0; k < each; k++) {
            numerator += sums[phase * lanes + row];
            denominator += sums[phase * lanes + l];
            if (++phase == phases) {
                phase = 0;
                row++;
            }
        }
        out[2 * c] = numerator;
        out[2 * c + 1] = denominator;
    }
}

static inline void walk_sum_columns(const struct shadow_field *f, const struct walk_taps *taps,
                                    uint32_t i, float *out)
{
    const uint32_t l = f->strata, lanes = f->lanes;
    _Alignas(64) float sums[SHADOW_SUMS_MAX];
    memset(sums, 0, f->phases * lanes * sizeof *sums);
    if (l == 3) { /* the loops in there come apart */
        walk_add(f, 4, taps, i, sums);
        walk_cells(3, 4, 16, 16, sums, out);
    } else {
        walk_add(f, lanes, taps, i, sums);
        walk_cells(l, lanes, f->phases, 2 * f->scale, sums, out);
    }
}

static void kernel_walk_columns(const struct shadow_field *f, const uint32_t *pixels,
                                uint32_t count, float *out)
{
    struct walk_taps taps;
    for (uint32_t k = 0; k < count; k += SHADOW_LANES) {
        walk_take(f, 0, f->lanes, pixels + k, count - k, &taps);
        for (uint32_t i = 0; i < taps.group.count; i++)
            walk_sum_columns(f, &taps, i, out + (size_t)(k + i) * 4 * f->scale);
    }
}

/* What tap n gives: two nodes' (numerator, denominator), weighted. */
static inline shadow_four walk_nodes(const struct shadow_field *f, const struct walk_taps *taps,
                                     int32_t n, uint32_t i)
{
    const float w0 = taps->weight[n][0][i], w1 = taps->weight[n][1][i];
    shadow_four nodes; /* they start on 8 bytes */
    memcpy(&nodes, f->rows + taps->at[n][i], sizeof nodes);
    return nodes * (shadow_four){w0, w0, w1, w1};
}

static inline void walk_sum_rows(const struct shadow_field *f, const struct walk_taps *taps,
                                 uint32_t i, float out[2])
{
    const uint32_t next = (i + 1) % SHADOW_LANES; /* whose sums the CPU may fetch meanwhile */
    int32_t first, end;
    shadow_four even = {0}, odd = {0}; /* two sums: their additions overlap */
    walk_span(taps, i, &first, &end);
    for (int32_t n = first; n < end; n += 2) {
        __builtin_prefetch(f->rows + taps->at[n][next]);
        __builtin_prefetch(f->rows + taps->at[n + 1][next]);
        even += walk_nodes(f, taps, n, i);
        odd += walk_nodes(f, taps, n + 1, i);
    }
    const shadow_four all = even + odd;
    out[0] = all[0] + all[2];
    out[1] = all[1] + all[3];
}

static void kernel_walk_rows(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                             float *out)
{
    struct walk_taps taps;
    for (uint32_t k = 0; k < count; k += SHADOW_LANES) {
        walk_take(f, 1, 2, pixels + k, count - k, &taps);
        for (uint32_t i = 0; i < taps.group.count; i++)
            walk_sum_rows(f, &taps, i, out + 2 * (size_t)(k + i));
    }
}

static void kernel_mark_walks(const struct shadow_field *f, uint32_t axis, const uint32_t *pixels,
                              uint32_t count, uint8_t *marks)
{
    struct walk_group group;
    struct walk_tap tap[2];
    for (uint32_t first = 0; first < count; first += SHADOW_LANES) {
        walk_group_load(f, axis, pixels + first, count - first, &group);
        for (int32_t k = -group.reach_most; k <= group.reach_most; k++) {
            walk_place(&group, k, tap);
            walk_mark(&tap[0], marks);
            walk_mark(&tap[1], marks);
        }
    }
}
