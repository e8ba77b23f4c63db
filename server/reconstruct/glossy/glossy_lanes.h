#pragma once
/* The glossy_kernels, sixteen receivers at a time. Whatever instruction set the including file is
 * compiled for, each lane sees the same operations in the same order, fused where it can. */
#include "server/reconstruct/glossy/glossy_compare_lanes.h"

#define GLOSSY_SLOPE 0.1225f /* squared: neighbours may lie so far off the plane, over distance */

/* Returns the mask of receivers of vector v that may accept the neighbours from q on. */
SIMD_INLINE simd_mask glossy_meet(const struct glossy_field *f, enum glossy_shape shape,
                                  const struct glossy_receivers *a, size_t q, int v,
                                  struct glossy_met *out)
{
    const size_t at = q + (size_t)v * SIMD_PER_VECTOR;
    const simd_vector n[3] = {a->normal[0].v[v], a->normal[1].v[v], a->normal[2].v[v]};
    simd_vector d[3];
    for (int k = 0; k < 3; k++) d[k] = simd_load_vector(f->point[k] + at) - a->point[k].v[v];
    const simd_vector off = simd_dot(d, n), length = simd_dot(d, d);
    const simd_mask flat =
        (simd_positive(off) <= a->off.v[v]) | (off * off <= GLOSSY_SLOPE * length);
    const simd_mask same = simd_load_mask(f->object + at) == a->object.v[v];
    glossy_compare(f, shape, a, at, v, d, out);
    return flat & same & a->receives.v[v];
}

/* Returns whether any neighbour shows an object of the receivers. */
static inline int glossy_meets(const struct glossy_field *f, const struct glossy_receivers *a,
                               size_t q)
{
    struct simd_whole same;
    for (int v = 0; v < SIMD_VECTORS; v++)
        same.v[v] = a->receives.v[v] &
                    (simd_load_mask(f->object + q + v * SIMD_PER_VECTOR) == a->object.v[v]);
    return simd_any(&same);
}

/* Meets the neighbours to one side, without those that no receiver may accept. */
SIMD_INLINE void glossy_walk(const struct glossy_field *f, enum glossy_shape shape,
                             const struct glossy_receivers *a, size_t p, ptrdiff_t step,
                             int32_t reach, struct glossy_met *out)
{
    for (int32_t k = 1; k <= reach; k++) {
        const size_t q = (size_t)((ptrdiff_t)p + k * step);
        struct simd_whole taken;
        struct simd masks;
        if (!glossy_meets(f, a, q)) continue;
        for (int v = 0; v < SIMD_VECTORS; v++) {
            taken.v[v] = glossy_meet(f, shape, a, q, v, out);
            masks.v[v] = (simd_vector)taken.v[v];
        }
        if (!simd_any(&taken)) continue;
        out->square[out->taps.count] = (float)k * (float)k;
        taps_add(&out->taps, q, &masks);
    }
}

/* Returns the weights that vector v of the receivers gives to tap t. Parallax within a pixel's
 * footprint is forgiven, because the picture does not resolve it. */
static inline simd_vector glossy_weight(const struct glossy_receivers *a,
                                        const struct glossy_met *met, uint32_t t, int v)
{
    const size_t lane = (size_t)v * SIMD_PER_VECTOR;
    const simd_mask may = (simd_mask)simd_load_vector(met->taps.weight[t] + lane);
    const simd_vector det = simd_load_vector(met->det[t] + lane);
    const simd_vector square = simd_same(met->square[t]);
    const simd_vector sharp = simd_load_vector(met->sharp[t] + lane);
    const simd_vector shape = simd_fused(glossy_log(det), simd_same(0.5f), -(sharp + GLOSSY_LOG_2));
    const simd_vector apart = simd_load_vector(met->apart[t] + lane) / det;
    const simd_vector view = a->similarity.v[v] * (0.5f * apart);
    const simd_vector most = square * a->footprint.v[v];
    const simd_vector own = simd_fused(a->similarity.v[v], shape, simd_min(view, most));
    const simd_vector x = simd_fused(a->distance.v[v], square, simd_where(own > 0.0f, own));
    const simd_vector tapered = simd_fused(x, simd_same(-a->taper), simd_same(1.0f));
    return simd_where(may & (x < a->cut), glossy_exp_minus(x) * tapered);
}

static inline void glossy_weigh(const struct glossy_receivers *a, struct glossy_met *met)
{
    for (uint32_t t = 0; t < met->taps.count; t++) {
        struct simd weight;
        for (int v = 0; v < SIMD_VECTORS; v++) weight.v[v] = glossy_weight(a, met, t, v);
        simd_store(&weight, met->taps.weight[t]);
    }
}

SIMD_INLINE void glossy_gather(const struct glossy_field *f, enum glossy_shape shape,
                               const struct glossy_rule *rule, const struct glossy_run *run,
                               size_t p, struct glossy_met *out)
{
    struct glossy_receivers receivers;
    out->taps.count = 0;
    glossy_load_receivers(f, shape, rule, p, &receivers);
    if (!simd_any(&receivers.receives)) return;
    glossy_walk(f, shape, &receivers, p, -run->step, run->before, out);
    glossy_walk(f, shape, &receivers, p, run->step, run->after, out);
    glossy_weigh(&receivers, out);
}

SIMD_INLINE void glossy_spread(const struct glossy_field *f, enum glossy_shape shape,
                               const struct glossy_rule *rule, const struct glossy_run *run,
                               uint32_t count, const float *const *in, float *const *out)
{
    struct glossy_met met;
    for (size_t p = run->first; p < run->first + run->count; p += SIMD_LANES) {
        glossy_gather(f, shape, rule, run, p, &met);
        taps_mean(&met.taps, count, in, p, out);
    }
}

static void kernel_spread_elliptic(const struct glossy_field *f, const struct glossy_rule *rule,
                                   const struct glossy_run *run, uint32_t count,
                                   const float *const *in, float *const *out)
{
    glossy_spread(f, GLOSSY_ELLIPTIC, rule, run, count, in, out);
}

static void kernel_spread_round(const struct glossy_field *f, const struct glossy_rule *rule,
                                const struct glossy_run *run, uint32_t count,
                                const float *const *in, float *const *out)
{
    glossy_spread(f, GLOSSY_ROUND, rule, run, count, in, out);
}

static void kernel_spread_mixture(const struct glossy_field *f, const struct glossy_rule *rule,
                                  const struct glossy_run *run, uint32_t count,
                                  const float *const *in, float *const *out)
{
    glossy_spread(f, GLOSSY_MIXTURE, rule, run, count, in, out);
}
