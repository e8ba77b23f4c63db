#pragma once
/* The lens_kernels that composite layers, a vector of pixels at a time. Whatever instruction set
 * the including file is compiled for, each pixel sees the same operations in the same order. */
#include "server/reconstruct/lens/lens_cell_lanes.h"
#include "server/reconstruct/lens/lens_kernels.h"
#include "server/reconstruct/simd/lanes_vector.h"

struct lens_focus_sums {
    lanes_vector light[LENS_LIGHTS], met, all;
};

static inline struct lens_focus_sums lens_focus_sum(const struct lens_focus *f, size_t i)
{
    const lanes_vector one = 1.0f - (lanes_vector){0};
    struct lens_focus_sums sum = {.met = {0}};
    for (uint32_t j = 0; j < f->samples; j++) {
        const lanes_vector s = lanes_load_vector(f->slope + j * f->area + i);
        const lanes_mask all = s < f->high, met = all & (s >= f->low);
        sum.all += lanes_where(all, one);
        if (!lanes_signs(met)) continue; /* nothing to add */
        sum.met += lanes_where(met, one);
        for (uint32_t k = 0; k < 3; k++) {
            const lanes_vector c =
                lanes_where(met, lanes_load_vector(f->light + (j * 3 + k) * f->area + i));
            sum.light[k] += c;
            sum.light[3] += c * c;
        }
    }
    return sum;
}

static inline void lens_replace(lanes_mask mask, float *at, lanes_vector by)
{
    *(lanes_stored *)at = lanes_select(mask, by, lanes_load_vector(at));
}

/* Returns the lanes that see through to no known sample. Pixels that no nearer layer hides get the
 * plain average, to the last bit: the whole lens sees means. */
static inline lanes_mask lens_focus_vector(const struct lens_focus *f, size_t i)
{
    lanes_vector through = {0};
    for (int g = 0; g < LENS_GROUPS; g++)
        through += lanes_load_vector(f->through[g] + i) * f->share[g];
    const lanes_mask looks = through > 0.0f;
    if (!lanes_signs(looks)) return looks;
    const struct lens_focus_sums sum = lens_focus_sum(f, i);
    const lanes_mask seen = looks & (sum.met > 0.0f);
    const lanes_vector met = sum.met / sum.all, left = 1.0f - met;
    for (int g = 0; g < LENS_GROUPS; g++)
        lens_replace(seen, f->through[g] + i, lanes_load_vector(f->through[g] + i) * left);
    for (int k = 0; k < LENS_LIGHTS; k++)
        lens_replace(seen, f->lights[k] + i,
                     lanes_load_vector(f->lights[k] + i) + sum.light[k] / sum.all * through);
    lens_replace(seen, f->shares + i, lanes_load_vector(f->shares + i) + met * through);
    return looks & ~(sum.all > 0.0f);
}

static uint32_t kernel_focus(const struct lens_focus *focus, uint32_t count, uint32_t *hidden)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; i += LANES_PER_VECTOR) {
        const lanes_mask none = lens_focus_vector(focus, i);
        for (uint32_t k = 0; k < LANES_PER_VECTOR; k++)
            if (none[k]) hidden[n++] = i + k;
    }
    return n;
}

/* Returns how much of the lens is left, from its quarters. */
static inline lanes_vector lens_left(const float share[LENS_GROUPS],
                                     const lanes_vector through[LENS_GROUPS])
{
    lanes_vector all = through[0] * share[0];
    for (size_t g = 1; g < LENS_GROUPS; g++) all += through[g] * share[g];
    return all;
}

/* Returns the lanes whose bits are set, the first lane's lowest. */
static inline lanes_mask lens_bits(uint32_t bits)
{
    static const int32_t own[] = {1,       1 << 1,  1 << 2,  1 << 3, 1 << 4,  1 << 5,
                                  1 << 6,  1 << 7,  1 << 8,  1 << 9, 1 << 10, 1 << 11,
                                  1 << 12, 1 << 13, 1 << 14, 1 << 15};
    return (lanes_load_mask(own) & (int32_t)bits) != 0;
}

/* Composites a layer. A quarter of the lens through which no cell was seen takes the sums of all
 * quarters. Cells on the lines between quarters belong to one quarter each, so the transparencies
 * of the quarters are scaled at the end to leave what the layer did not take of the lens. */
static inline void lens_composite_vector(const struct lens_composite *c, size_t i,
                                         float seen[LENS_VIEWS][LENS_LANES])
{
    lanes_vector total[LENS_SUMS] = {{0}}, before[LENS_GROUPS], after[LENS_GROUPS];
    for (size_t g = 0; g < LENS_GROUPS; g++) {
        before[g] = after[g] = lanes_load_vector(seen[LENS_VIEW_THROUGH + g] + i);
        for (size_t k = 0; k < LENS_SUMS; k++)
            total[k] += lanes_load_vector(c->sums + (g * LENS_SUMS + k) * LENS_LANES + i);
    }
    const lanes_mask near = lens_bits(c->near >> i);
    const lanes_mask any = near & (total[LENS_SUM_SHARE] > 0.0f); /* then there is weight, too */
    const lanes_vector left = lens_left(c->lens, before), cells = lens_left(c->share, before);
    const lanes_vector scale = lanes_where(cells > 0.0f, left / cells);
    lanes_vector taken = {0};
    for (size_t g = 0; g < LENS_GROUPS; g++) {
        const float *sums = c->sums + g * LENS_SUMS * LENS_LANES + i;
        const lanes_mask own = lanes_load_vector(sums + LENS_SUM_WEIGHT * LENS_LANES) > 0.0f;
        lanes_vector sum[LENS_SUMS];
        for (size_t k = 0; k < LENS_SUMS; k++)
            sum[k] = lanes_select(own, lanes_load_vector(sums + k * LENS_LANES), total[k]);
        const lanes_vector weight = sum[LENS_SUM_WEIGHT], share = sum[LENS_SUM_SHARE];
        const lanes_mask met = any & (share > 0.0f);
        const lanes_vector by = scale * before[g] * c->share[g] / weight;
        for (size_t k = 0; k < LENS_LIGHTS; k++) {
            float *light = seen[LENS_VIEW_LIGHT + k] + i;
            lens_replace(met, light, lanes_load_vector(light) + sum[LENS_SUM_LIGHT + k] * by);
        }
        float *shares = seen[LENS_VIEW_SHARE] + i, *spread = seen[LENS_VIEW_SPREAD] + i;
        lens_replace(met, shares, lanes_load_vector(shares) + share * by);
        lens_replace(met, spread, lanes_load_vector(spread) + share * by * c->slope);
        taken += lanes_where(met, share * by);
        after[g] = lanes_select(
            met, lanes_where(share < weight, before[g] * (1.0f - share / weight)), before[g]);
    }
    const lanes_vector rest = lens_left(c->lens, after);
    const lanes_vector should = lanes_where(taken < left, left - taken);
    const lanes_vector by = lanes_where(rest > 0.0f, should / rest);
    for (size_t g = 0; g < LENS_GROUPS; g++)
        lens_replace(any, seen[LENS_VIEW_THROUGH + g] + i, after[g] * by);
}

static void kernel_composite(const struct lens_composite *composite,
                             float seen[LENS_VIEWS][LENS_LANES])
{
    for (size_t i = 0; i < LENS_LANES; i += LANES_PER_VECTOR)
        lens_composite_vector(composite, i, seen);
}
