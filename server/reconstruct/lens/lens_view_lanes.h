#pragma once
/* The lens_kernels that composite layers, a vector of pixels at a time. Whatever instruction set
 * the including file is compiled for, each pixel sees the same operations in the same order. */
#include "server/reconstruct/lens/lens_cell_lanes.h"
#include "server/reconstruct/lens/lens_kernels.h"
#include "server/reconstruct/simd/vector.h"

struct lens_focus_sums {
    simd_vector light[LENS_LIGHTS], met, all;
};

static inline struct lens_focus_sums lens_focus_sum(const struct lens_focus *f, size_t i)
{
    const simd_vector one = 1.0f - (simd_vector){0};
    struct lens_focus_sums sum = {.met = {0}};
    for (uint32_t j = 0; j < f->samples; j++) {
        const simd_vector s = simd_load_vector(f->slope + j * f->area + i);
        const simd_mask all = s < f->high, met = all & (s >= f->low);
        sum.all += simd_where(all, one);
        if (!simd_signs(met)) continue; /* nothing to add */
        sum.met += simd_where(met, one);
        for (uint32_t k = 0; k < 3; k++) {
            const simd_vector c =
                simd_where(met, simd_load_vector(f->light + (j * 3 + k) * f->area + i));
            sum.light[k] += c;
            sum.light[3] += c * c;
        }
    }
    return sum;
}

static inline void lens_replace(simd_mask mask, float *at, simd_vector by)
{
    *(simd_stored *)at = simd_select(mask, by, simd_load_vector(at));
}

/* Returns the lanes that see through to no known sample. Pixels that no nearer layer hides get the
 * plain average, to the last bit: the whole lens sees means. */
static inline simd_mask lens_focus_vector(const struct lens_focus *f, size_t i)
{
    simd_vector through = {0};
    for (int g = 0; g < LENS_GROUPS; g++)
        through += simd_load_vector(f->through[g] + i) * f->share[g];
    const simd_mask looks = through > 0.0f;
    if (!simd_signs(looks)) return looks;
    const struct lens_focus_sums sum = lens_focus_sum(f, i);
    const simd_mask seen = looks & (sum.met > 0.0f);
    const simd_vector met = sum.met / sum.all, left = 1.0f - met;
    for (int g = 0; g < LENS_GROUPS; g++)
        lens_replace(seen, f->through[g] + i, simd_load_vector(f->through[g] + i) * left);
    for (int k = 0; k < LENS_LIGHTS; k++)
        lens_replace(seen, f->lights[k] + i,
                     simd_load_vector(f->lights[k] + i) + sum.light[k] / sum.all * through);
    lens_replace(seen, f->shares + i, simd_load_vector(f->shares + i) + met * through);
    return looks & ~(sum.all > 0.0f);
}

static uint32_t kernel_focus(const struct lens_focus *focus, uint32_t count, uint32_t *hidden)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; i += SIMD_PER_VECTOR) {
        const simd_mask none = lens_focus_vector(focus, i);
        for (uint32_t k = 0; k < SIMD_PER_VECTOR; k++)
            if (none[k]) hidden[n++] = i + k;
    }
    return n;
}

/* Returns how much of the lens is left, from its quarters. */
static inline simd_vector lens_left(const float share[LENS_GROUPS],
                                    const simd_vector through[LENS_GROUPS])
{
    simd_vector all = through[0] * share[0];
    for (size_t g = 1; g < LENS_GROUPS; g++) all += through[g] * share[g];
    return all;
}

/* Returns the lanes whose bits are set, the first lane's lowest. */
static inline simd_mask lens_bits(uint32_t bits)
{
    static const int32_t own[] = {1,       1 << 1,  1 << 2,  1 << 3, 1 << 4,  1 << 5,
                                  1 << 6,  1 << 7,  1 << 8,  1 << 9, 1 << 10, 1 << 11,
                                  1 << 12, 1 << 13, 1 << 14, 1 << 15};
    return (simd_load_mask(own) & (int32_t)bits) != 0;
}

/* Composites a layer. A quarter of the lens through which no cell was seen takes the sums of all
 * quarters. Cells on the lines between quarters belong to one quarter each, so the transparencies
 * of the quarters are scaled at the end to leave what the layer did not take of the lens. */
static inline void lens_composite_vector(const struct lens_composite *c, size_t i,
                                         float seen[LENS_VIEWS][SIMD_LANES])
{
    simd_vector total[LENS_SUMS] = {{0}}, before[LENS_GROUPS], after[LENS_GROUPS];
    for (size_t g = 0; g < LENS_GROUPS; g++) {
        before[g] = after[g] = simd_load_vector(seen[LENS_VIEW_THROUGH + g] + i);
        for (size_t k = 0; k < LENS_SUMS; k++)
            total[k] += simd_load_vector(c->sums + (g * LENS_SUMS + k) * SIMD_LANES + i);
    }
    const simd_mask near = lens_bits(c->near >> i);
    const simd_mask any = near & (total[LENS_SUM_SHARE] > 0.0f); /* then there is weight, too */
    const simd_vector left = lens_left(c->lens, before), cells = lens_left(c->share, before);
    const simd_vector scale = simd_where(cells > 0.0f, left / cells);
    simd_vector taken = {0};
    for (size_t g = 0; g < LENS_GROUPS; g++) {
        const float *sums = c->sums + g * LENS_SUMS * SIMD_LANES + i;
        const simd_mask own = simd_load_vector(sums + LENS_SUM_WEIGHT * SIMD_LANES) > 0.0f;
        simd_vector sum[LENS_SUMS];
        for (size_t k = 0; k < LENS_SUMS; k++)
            sum[k] = simd_select(own, simd_load_vector(sums + k * SIMD_LANES), total[k]);
        const simd_vector weight = sum[LENS_SUM_WEIGHT], share = sum[LENS_SUM_SHARE];
        const simd_mask met = any & (share > 0.0f);
        const simd_vector by = scale * before[g] * c->share[g] / weight;
        for (size_t k = 0; k < LENS_LIGHTS; k++) {
            float *light = seen[LENS_VIEW_LIGHT + k] + i;
            lens_replace(met, light, simd_load_vector(light) + sum[LENS_SUM_LIGHT + k] * by);
        }
        float *shares = seen[LENS_VIEW_SHARE] + i, *spread = seen[LENS_VIEW_SPREAD] + i;
        lens_replace(met, shares, simd_load_vector(shares) + share * by);
        lens_replace(met, spread, simd_load_vector(spread) + share * by * c->slope);
        taken += simd_where(met, share * by);
        after[g] = simd_select(met, simd_where(share < weight, before[g] * (1.0f - share / weight)),
                               before[g]);
    }
    const simd_vector rest = lens_left(c->lens, after);
    const simd_vector should = simd_where(taken < left, left - taken);
    const simd_vector by = simd_where(rest > 0.0f, should / rest);
    for (size_t g = 0; g < LENS_GROUPS; g++)
        lens_replace(any, seen[LENS_VIEW_THROUGH + g] + i, after[g] * by);
}

static void kernel_composite(const struct lens_composite *composite,
                             float seen[LENS_VIEWS][SIMD_LANES])
{
    for (size_t i = 0; i < SIMD_LANES; i += SIMD_PER_VECTOR)
        lens_composite_vector(composite, i, seen);
}
