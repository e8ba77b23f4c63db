#pragma once
/* shadow_kernels' walks: passes 1b and 2b. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/gaussian.h"

#define WALK_LINEAR 0.8f /* share of a local linear fit's correction */

/* A walk's taps, from its negative end; the nearer pixel in rows or columns first. */
struct walk_taps {
    struct shadow_lanes lanes;
    _Alignas(64) float share[SHADOW_PADDED];    /* of the step's two pixels; 0 past the end */
    _Alignas(64) float below[2][SHADOW_PADDED]; /* weights of two neighbouring nodes */
    _Alignas(64) int32_t at[SHADOW_PADDED];     /* the lower one: its place among all sums */
    _Alignas(64) int32_t kept[SHADOW_PADDED];   /* not 0: counts */
    _Alignas(64) int32_t counts[SHADOW_PADDED]; /* taps that are not refused */
    size_t count;                               /* how many those are */
};

/* Where taps lie. Returns their number, filled up to whole lanes. */
static inline size_t walk_place(const struct shadow_walk *w, int32_t row, struct walk_taps *out)
{
    const int along_x = fabsf(w->step[0]) >= fabsf(w->step[1]);
    const int32_t major = along_x ? 1 : row, minor = along_x ? row : 1;
    const int32_t forward = w->step[along_x ? 0 : 1] < 0.0f ? -major : major;
    const float slant = w->step[along_x ? 1 : 0];
    const int32_t count = 2 * (2 * w->reach + 1);
    const int32_t padded = (count + SHADOW_LANES - 1) / SHADOW_LANES * SHADOW_LANES;
    for (int32_t i = 0; i < padded; i++) {
        const int32_t k = (i >> 1) - w->reach, second = i & 1;
        const float aside = (float)k * slant, below = floorf(aside), rest = aside - below;
        const float share = second ? rest : 1.0f - rest;
        const int32_t to = k * forward + ((int32_t)below + second) * minor;
        out->share[i] = i < count ? share : 0.0f;
        out->lanes.to[i] = share > 0.0f && i < count ? to : 0;
    }
    return (size_t)padded;
}

static void kernel_mark_walks(const struct shadow_field *f, uint32_t axis, const uint32_t *pixels,
                              uint32_t count, uint8_t *marks)
{
    struct walk_taps taps;
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_walk *walk = &f->targets[pixels[k]].walk[axis];
        const size_t n = 2 * (2 * (size_t)walk->reach + 1);
        uint8_t *here = marks + pixels[k];
        walk_place(walk, f->width, &taps);
        for (size_t i = 0; i < n; i++) here[taps.lanes.to[i]] = 1;
    }
}

static inline int32_t walk_whole(float number)
{
    int32_t whole;
    memcpy(&whole, &number, sizeof whole);
    return whole;
}

/* What each tap weighs, and where its sums are read; a node has `stride` of them. */
static inline void walk_weigh(const struct shadow_field *f, uint32_t axis, uint32_t stride,
                              size_t pixel, size_t count, struct walk_taps *taps)
{
    const struct shadow_source *p = &f->sources[pixel];
    const struct shadow_target *t = &f->targets[pixel];
    const struct asker asker = asker_of(p, t);
    const float distance = t->distance, u = p->u[axis], eta = p->eta;
    const float per_length = f->nodes_per_length[axis], refusal = f->refusal[axis];
    const float falloff = t->walk[axis].falloff, centre = (float)f->scale;
    const struct shadow_lanes *q = &taps->lanes;
    const int32_t node_sums = (int32_t)stride, slot_sums = (int32_t)(shadow_nodes(f) * stride);
    for (size_t i = 0; i < count; i++) {
        float squared;
        const int32_t same = compatible(&asker, q, i, &squared);
        const float delta = distance * (q->number[SHADOW_U + axis][i] - u);
        const float shear = fabsf(q->number[SHADOW_ETA][i] - eta) + q->number[SHADOW_SPREAD][i];
        const float node = centre - eta * delta * per_length;
        const int32_t kept =
            same & (fabsf(delta) * shear <= refusal) & (node >= 0.0f) & (node <= 2.0f * centre);
        const float weight = taps->share[i] * gaussian_exp_minus(delta * delta * falloff);
        const float counted = kept ? weight : 0.0f, at = kept ? node : 0.0f;
        const float whole = floorf(at), rest = at - whole;
        taps->kept[i] = counted > 0.0f;
        taps->at[i] =
            walk_whole(q->number[SHADOW_SLOT][i]) * slot_sums + (int32_t)whole * node_sums;
        taps->below[0][i] = counted * (1.0f - rest);
        taps->below[1][i] = counted * rest;
    }
}

/* Where a silhouette or a refusal cuts a walk, its taps lie to one side, and what changes linearly
 * along it is read there, not at the pixel. A local linear fit undoes that: weights w (1 - k S1/S2)
 * of tap k, S1 and S2 the sums of w k and w k^2. Weights go through all of their noise with it:
 * most of the correction has the least error. The sum of weights stays above a fifth of itself. */
static inline void walk_balance(int32_t reach, size_t count, struct walk_taps *taps)
{
    float s1[SHADOW_LANES] = {0}, s2[SHADOW_LANES] = {0};
    for (size_t first = 0; first < count; first += SHADOW_LANES) {
        for (size_t lane = 0; lane < SHADOW_LANES; lane++) {
            const size_t i = first + lane;
            const float k = (float)((int32_t)(i >> 1) - reach);
            const float moment = k * (taps->below[0][i] + taps->below[1][i]);
            s1[lane] += moment;
            s2[lane] += moment * k;
        }
    }
    const float first = lanes_total(s1), second = lanes_total(s2);
    const float slope = second > 0.0f ? WALK_LINEAR * first / second : 0.0f;
    for (size_t i = 0; i < count; i++) {
        const float factor = 1.0f - slope * (float)((int32_t)(i >> 1) - reach);
        taps->below[0][i] *= factor;
        taps->below[1][i] *= factor;
    }
}

/* Finds the taps that count, and lets the CPU fetch their sums from `sums`: they are used a pixel
 * later, since a walk's neighbours lie far apart in memory. */
static inline void walk_take(const struct shadow_field *f, uint32_t axis, uint32_t stride,
                             const float *sums, size_t pixel, struct walk_taps *taps)
{
    const size_t count = walk_place(&f->targets[pixel].walk[axis], f->width, taps);
    lanes_fetch(&f->sources[pixel], count, SHADOW_PHASE + 1, &taps->lanes);
    walk_weigh(f, axis, stride, pixel, count, taps);
    walk_balance(f->targets[pixel].walk[axis].reach, count, taps);
    taps->count = lanes_kept(taps->kept, count, taps->counts);
    for (size_t j = 0; j < taps->count; j++) __builtin_prefetch(sums + taps->at[taps->counts[j]]);
}

/* To the sums of each phase what the taps' two neighbouring nodes give. */
static inline void walk_add(const struct shadow_field *f, uint32_t lanes,
                            const struct walk_taps *taps, float *sums)
{
    for (size_t j = 0; j < taps->count; j++) {
        const size_t i = (size_t)taps->counts[j];
        const float *c = f->columns + taps->at[i], w0 = taps->below[0][i], w1 = taps->below[1][i];
        float *to = sums + walk_whole(taps->lanes.number[SHADOW_PHASE][i]) * (int32_t)lanes;
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
                                    float *out)
{
    const uint32_t l = f->strata, lanes = f->lanes;
    _Alignas(64) float sums[SHADOW_SUMS_MAX];
    memset(sums, 0, f->phases * lanes * sizeof *sums);
    if (l == 3) { /* the loops in there come apart */
        walk_add(f, 4, taps, sums);
        walk_cells(3, 4, 16, 16, sums, out);
    } else {
        walk_add(f, lanes, taps, sums);
        walk_cells(l, lanes, f->phases, 2 * f->scale, sums, out);
    }
}

static void kernel_walk_columns(const struct shadow_field *f, const uint32_t *pixels,
                                uint32_t count, float *out)
{
    struct walk_taps taps[2];
    for (uint32_t k = 0; k <= count; k++) {
        if (k < count) walk_take(f, 0, f->lanes, f->columns, pixels[k], &taps[k & 1]);
        if (k > 0) walk_sum_columns(f, &taps[~k & 1], out + (size_t)(k - 1) * 4 * f->scale);
    }
}

/* What tap i gives: two nodes' (numerator, denominator), weighted. */
static inline shadow_four walk_nodes(const struct shadow_field *f, const struct walk_taps *taps,
                                     int32_t i)
{
    const float w0 = taps->below[0][i], w1 = taps->below[1][i];
    shadow_four nodes; /* they start on 8 bytes */
    memcpy(&nodes, f->rows + taps->at[i], sizeof nodes);
    return nodes * (shadow_four){w0, w0, w1, w1};
}

static inline void walk_sum_rows(const struct shadow_field *f, const struct walk_taps *taps,
                                 float out[2])
{
    const int32_t *tap = taps->counts;
    const size_t n = taps->count;
    shadow_four even = {0}, odd = {0}; /* two sums: their additions overlap */
    for (size_t j = 0; j + 1 < n; j += 2) {
        even += walk_nodes(f, taps, tap[j]);
        odd += walk_nodes(f, taps, tap[j + 1]);
    }
    if (n & 1) even += walk_nodes(f, taps, tap[n - 1]);
    const shadow_four all = even + odd;
    out[0] = all[0] + all[2];
    out[1] = all[1] + all[3];
}

static void kernel_walk_rows(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                             float *out)
{
    struct walk_taps taps[2];
    for (uint32_t k = 0; k <= count; k++) {
        if (k < count) walk_take(f, 1, 2, f->rows, pixels[k], &taps[k & 1]);
        if (k > 0) walk_sum_rows(f, &taps[~k & 1], out + 2 * (size_t)(k - 1));
    }
}
