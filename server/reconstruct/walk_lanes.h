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
    _Alignas(64) float share[SHADOW_PADDED]; /* of the step's two pixels; 0 past the end */
    _Alignas(
        64) float below[2][SHADOW_PADDED];    /* weights of two neighbouring nodes; 0, 0: refused */
    _Alignas(64) int32_t node[SHADOW_PADDED]; /* the lower one */
    _Alignas(64) int32_t kept[SHADOW_PADDED]; /* not 0: counts */
    _Alignas(64) int32_t counts[SHADOW_PADDED]; /* taps that are not refused */
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

/* What each tap weighs, and what nodes its sums are read at. */
static inline void walk_weigh(const struct shadow_field *f, uint32_t axis, size_t pixel,
                              size_t count, struct walk_taps *taps)
{
    const struct shadow_source *p = &f->sources[pixel];
    const struct shadow_target *t = &f->targets[pixel];
    const struct asker asker = asker_of(p, t);
    const float distance = t->distance, u = p->u[axis], eta = p->eta;
    const float per_length = f->nodes_per_length[axis], refusal = f->refusal[axis];
    const float falloff = t->walk[axis].falloff, centre = (float)f->scale;
    const struct shadow_lanes *q = &taps->lanes;
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
        taps->node[i] = (int32_t)whole;
        taps->below[0][i] = counted * (1.0f - rest);
        taps->below[1][i] = counted * rest;
    }
}

/* The sum over lanes in a fixed order, in pairs. */
static inline float walk_total(float parts[SHADOW_LANES])
{
    for (uint32_t half = SHADOW_LANES / 2; half > 0; half /= 2) {
        for (uint32_t i = 0; i < half; i++) parts[i] += parts[i + half];
    }
    return parts[0];
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
    const float first = walk_total(s1), second = walk_total(s2);
    const float slope = second > 0.0f ? WALK_LINEAR * first / second : 0.0f;
    for (size_t i = 0; i < count; i++) {
        const float factor = 1.0f - slope * (float)((int32_t)(i >> 1) - reach);
        taps->below[0][i] *= factor;
        taps->below[1][i] *= factor;
    }
}

/* The taps that count, as indices. Returns how many. */
static inline size_t walk_take(const struct shadow_field *f, uint32_t axis, size_t pixel,
                               struct walk_taps *taps)
{
    const size_t count = walk_place(&f->targets[pixel].walk[axis], f->width, taps);
    lanes_fetch(&f->sources[pixel], count, SHADOW_REFUSAL + 1, &taps->lanes);
    walk_weigh(f, axis, pixel, count, taps);
    walk_balance(f->targets[pixel].walk[axis].reach, count, taps);
    return lanes_kept(taps->kept, count, taps->counts);
}

static inline size_t walk_slot(const struct walk_taps *taps, size_t i)
{
    int32_t slot;
    memcpy(&slot, &taps->lanes.number[SHADOW_SLOT][i], sizeof slot);
    return (size_t)slot;
}

/* Adds what l rows of two neighbouring nodes give to (numerator, denominator) of their cells. */
static inline void walk_add(uint32_t l, uint32_t lanes, const float *c, float w0, float w1,
                            const uint8_t *cell, float *cells)
{
    float row[SHADOW_STRATA_MAX + 4];
    uint8_t place[SHADOW_STRATA_MAX];
    memcpy(place, cell, sizeof place);
    for (uint32_t b = 0; b < lanes; b += 4) {
        for (uint32_t i = 0; i < 4; i++) row[b + i] = w0 * c[b + i] + w1 * c[lanes + b + i];
    }
    for (uint32_t b = 0; b < l; b++) {
        float *to = cells + 2 * (size_t)place[b];
        const float numerator = to[0] + row[b], denominator = to[1] + row[l];
        to[0] = numerator;
        to[1] = denominator;
    }
}

static void kernel_walk_columns(const struct shadow_field *f, const uint32_t *pixels,
                                uint32_t count, float *out)
{
    const uint32_t l = f->strata, lanes = f->lanes, size = shadow_nodes(f) * lanes;
    struct walk_taps taps;
    for (uint32_t k = 0; k < count; k++) {
        float *cells = out + (size_t)k * 4 * f->scale;
        const size_t n = walk_take(f, 0, pixels[k], &taps);
        memset(cells, 0, 4 * f->scale * sizeof *cells);
        for (size_t j = 0; j < n; j++) {
            const size_t i = (size_t)taps.counts[j], slot = walk_slot(&taps, i);
            const float *c = f->columns + slot * size + (size_t)taps.node[i] * lanes;
            const uint8_t *cell = f->cells + slot * SHADOW_STRATA_MAX;
            if (l == 3) /* the loops in there come apart */
                walk_add(3, 4, c, taps.below[0][i], taps.below[1][i], cell, cells);
            else
                walk_add(l, lanes, c, taps.below[0][i], taps.below[1][i], cell, cells);
        }
    }
}

static void kernel_walk_rows(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                             float *out)
{
    const uint32_t size = shadow_nodes(f) * 2;
    struct walk_taps taps;
    for (uint32_t k = 0; k < count; k++) {
        const size_t n = walk_take(f, 1, pixels[k], &taps);
        float numerator = 0.0f, denominator = 0.0f;
        for (size_t j = 0; j < n; j++) {
            const size_t i = (size_t)taps.counts[j];
            const float w0 = taps.below[0][i], w1 = taps.below[1][i];
            const float *r = f->rows + walk_slot(&taps, i) * size + (size_t)taps.node[i] * 2;
            numerator += w0 * r[0] + w1 * r[2];
            denominator += w0 * r[1] + w1 * r[3];
        }
        out[2 * k] = numerator;
        out[2 * k + 1] = denominator;
    }
}
