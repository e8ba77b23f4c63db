#pragma once
/* The glossy_kernels, sixteen receivers at a time. Whatever instruction set the including file is
 * compiled for, each lane sees the same operations in the same order, fused where it can.
 *
 * With S the sum of both lobes' covariances and h how far apart the lobes meet the point that the
 * receiver's lobe sees, as directions, the log of two lobes' similarity is
 *
 *   log 2 + (log det S_i + log det S_j) / 4 - (log det S) / 2 - (h^T S^-1 h) / 2
 *   h = (mirror_j - mirror_i) + nearness_i (x_j - x_i)
 *
 * in two coordinates at right angles to the receiver's mirrored direction: 0 for a lobe and itself
 * (after Tokuyoshi 2015, with parallax; docs/reconstruction.md, Glossy lobes). */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "server/reconstruct/glossy/glossy_kernels.h"
#include "server/reconstruct/simd/tap_lanes.h"
#include "server/reconstruct/simd/vector.h"

#define GLOSSY_LOG_2   0.693147181f
#define GLOSSY_DET_MIN 1e-30f
#define GLOSSY_SLOPE   0.1225f /* squared: neighbours may lie so far off the plane, over distance */

_Static_assert(TAPS_MAX >= GLOSSY_TAPS, "a line's neighbours");

/* Sixteen receivers. */
struct glossy_receivers {
    struct simd point[3], normal[3], mirror[3];
    struct simd e1[3], e2[3];                    /* along and across, unit */
    struct simd s11, s22;                        /* the covariance, which is diagonal there */
    struct simd sharpness, nearness, off;        /* of the tangent plane */
    struct simd similarity, distance, footprint; /* of the rule */
    struct simd_whole object, receives;
};

/* Computes unit axes of the receivers. Without a lobe they are any finite numbers. */
static inline void glossy_axis(const float *const in[3], size_t p, struct simd unit[3],
                               struct simd *square)
{
    for (int k = 0; k < 3; k++) unit[k] = simd_load(in[k] + p);
    for (int v = 0; v < SIMD_VECTORS; v++) {
        const simd_vector a[3] = {unit[0].v[v], unit[1].v[v], unit[2].v[v]};
        const simd_vector squared = simd_dot(a, a);
        const simd_vector fit = simd_select(squared > GLOSSY_DET_MIN, squared, simd_all(1.0f).v[v]);
        float root[SIMD_PER_VECTOR];
        simd_vector length;
        memcpy(root, &fit, sizeof root);
        for (int i = 0; i < SIMD_PER_VECTOR; i++) root[i] = sqrtf(root[i]);
        length = simd_load_vector(root);
        for (int k = 0; k < 3; k++) unit[k].v[v] = a[k] / length;
        square->v[v] = fit;
    }
}

static inline void glossy_load_receivers(const struct glossy_field *f,
                                         const struct glossy_rule *rule, size_t p,
                                         struct glossy_receivers *a)
{
    const bool own = f->similarity != NULL;
    a->similarity = own ? simd_load(f->similarity + p) : simd_all(rule->similarity);
    a->distance = own ? simd_load(f->distance + p) : simd_all(rule->distance);
    a->footprint = own ? simd_load(f->footprint + p) : simd_all(rule->footprint);
    for (int k = 0; k < 3; k++) {
        a->point[k] = simd_load(f->point[k] + p);
        a->normal[k] = simd_load(f->normal[k] + p);
        a->mirror[k] = simd_load(f->mirror[k] + p);
    }
    glossy_axis(f->along, p, a->e1, &a->s11);
    glossy_axis(f->across, p, a->e2, &a->s22);
    a->sharpness = simd_load(f->sharpness + p);
    a->nearness = simd_load(f->nearness + p);
    a->off = simd_load(f->near_plane + p);
    a->object = simd_load_whole(f->object + p);
    for (int v = 0; v < SIMD_VECTORS; v++) a->receives.v[v] = a->object.v[v] != 0;
}

/* Returns the natural logarithm of normal numbers above 0, for a mantissa from 0.7 to 1.4 as 2
 * artanh. The absolute error is 2e-7 beside that of adding the exponent. */
static inline simd_vector glossy_log(simd_vector x)
{
    const simd_mask bits = (simd_mask)x;
    const simd_mask scaled = (bits & 0x007fffff) | 0x3f800000; /* 1 to 2 */
    const simd_mask large = (simd_vector)scaled > 1.41421356f;
    const simd_vector m = (simd_vector)(scaled - (large & 0x00800000));
    const simd_vector e = __builtin_convertvector((bits >> 23) - 127 - large, simd_vector);
    const simd_vector t = (m - 1.0f) / (m + 1.0f), s = t * t;
    const simd_vector low = simd_fused(s, simd_same(0.2f), simd_same(0.333333333f));
    const simd_vector high = simd_fused(s, simd_same(0.111111111f), simd_same(0.142857143f));
    const simd_vector series = simd_fused(t * s, simd_fused(s * s, high, low), t);
    return simd_fused(e, simd_same(GLOSSY_LOG_2), series + series);
}

/* Returns exp(-x) for x from 0 to GLOSSY_CUT, as the sixteenth power of exp(-x/16)'s series. The
 * relative error is 4.1e-5, and 0 at 0. Results beyond are undefined. */
static inline simd_vector glossy_exp_minus(simd_vector x)
{
    const simd_vector y = x * -0.0625f, squared = y * y;
    const simd_vector linear = simd_fused(y, simd_same(1.0f / 6), simd_same(0.5f));
    const simd_vector low = simd_fused(squared, linear, 1.0f + y);
    const simd_vector fourth = simd_fused(y, simd_same(1.0f / 120), simd_same(1.0f / 24));
    const simd_vector high = simd_fused(squared, simd_same(1.0f / 720), fourth);
    simd_vector p = simd_fused(squared * squared, high, low);
    p = p * p;
    p = p * p;
    p = p * p;
    return p * p;
}

/* The neighbours that receivers may accept, with what their weights follow from: both lobes' shapes
 * and views. All are met before any is weighed. Steps that short let the CPU work on several taps
 * at once. */
struct glossy_met {
    struct taps taps;                                  /* weights: masks of accepted taps */
    _Alignas(64) float det[GLOSSY_TAPS][SIMD_LANES];   /* of S */
    _Alignas(64) float apart[GLOSSY_TAPS][SIMD_LANES]; /* h^T S^-1 h times that */
    _Alignas(64) float sharp[GLOSSY_TAPS][SIMD_LANES];
    float square[GLOSSY_TAPS]; /* of the distance in pixels */
};

/* Compares the lobes of vector v of the receivers with those of the neighbours at `at`, whose
 * points lie at d from the receivers'. */
static inline void glossy_compare(const struct glossy_field *f, const struct glossy_receivers *a,
                                  size_t at, int v, const simd_vector d[3], struct glossy_met *out)
{
    const uint32_t t = out->taps.count;
    const size_t lane = (size_t)v * SIMD_PER_VECTOR;
    const simd_vector e1[3] = {a->e1[0].v[v], a->e1[1].v[v], a->e1[2].v[v]};
    const simd_vector e2[3] = {a->e2[0].v[v], a->e2[1].v[v], a->e2[2].v[v]};
    const simd_vector near = a->nearness.v[v];
    simd_vector along[3], across[3], h[3];
    for (int k = 0; k < 3; k++) {
        along[k] = simd_load_vector(f->along[k] + at);
        across[k] = simd_load_vector(f->across[k] + at);
        h[k] = simd_fused(near, d[k], simd_load_vector(f->mirror[k] + at) - a->mirror[k].v[v]);
    }
    const simd_vector p1 = simd_dot(along, e1), p2 = simd_dot(along, e2);
    const simd_vector q1 = simd_dot(across, e1), q2 = simd_dot(across, e2);
    const simd_vector h1 = simd_dot(h, e1), h2 = simd_dot(h, e2);
    const simd_vector s11 = simd_fused(p1, p1, simd_fused(q1, q1, a->s11.v[v]));
    const simd_vector s22 = simd_fused(p2, p2, simd_fused(q2, q2, a->s22.v[v]));
    const simd_vector s12 = simd_fused(p1, p2, q1 * q2);
    const simd_vector raw = simd_fused(s11, s22, -s12 * s12);
    /* h1 (h1 s22 - h2 s12) + h2 (h2 s11 - h1 s12) */
    const simd_vector first = simd_fused(h1, s22, -h2 * s12);
    const simd_vector second = simd_fused(h2, s11, -h1 * s12);
    *(simd_stored *)(out->det[t] + lane) =
        simd_select(raw > GLOSSY_DET_MIN, raw, simd_same(GLOSSY_DET_MIN));
    *(simd_stored *)(out->apart[t] + lane) = simd_fused(h1, first, h2 * second);
    *(simd_stored *)(out->sharp[t] + lane) =
        a->sharpness.v[v] + simd_load_vector(f->sharpness + at);
}

/* Returns the mask of receivers of vector v that may accept the neighbours from q on. */
static inline simd_mask glossy_meet(const struct glossy_field *f, const struct glossy_receivers *a,
                                    size_t q, int v, struct glossy_met *out)
{
    const size_t at = q + (size_t)v * SIMD_PER_VECTOR;
    const simd_vector n[3] = {a->normal[0].v[v], a->normal[1].v[v], a->normal[2].v[v]};
    simd_vector d[3];
    for (int k = 0; k < 3; k++) d[k] = simd_load_vector(f->point[k] + at) - a->point[k].v[v];
    const simd_vector off = simd_dot(d, n), length = simd_dot(d, d);
    const simd_mask flat =
        (simd_positive(off) <= a->off.v[v]) | (off * off <= GLOSSY_SLOPE * length);
    const simd_mask same = simd_load_mask(f->object + at) == a->object.v[v];
    glossy_compare(f, a, at, v, d, out);
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
static inline void glossy_walk(const struct glossy_field *f, const struct glossy_receivers *a,
                               size_t p, ptrdiff_t step, int32_t reach, struct glossy_met *out)
{
    for (int32_t k = 1; k <= reach; k++) {
        const size_t q = (size_t)((ptrdiff_t)p + k * step);
        struct simd_whole taken;
        struct simd masks;
        if (!glossy_meets(f, a, q)) continue;
        for (int v = 0; v < SIMD_VECTORS; v++) {
            taken.v[v] = glossy_meet(f, a, q, v, out);
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
    return simd_where(may & (x <= GLOSSY_CUT), glossy_exp_minus(x));
}

static inline void glossy_weigh(const struct glossy_receivers *a, struct glossy_met *met)
{
    for (uint32_t t = 0; t < met->taps.count; t++) {
        struct simd weight;
        for (int v = 0; v < SIMD_VECTORS; v++) weight.v[v] = glossy_weight(a, met, t, v);
        simd_store(&weight, met->taps.weight[t]);
    }
}

static inline void glossy_gather(const struct glossy_field *f, const struct glossy_rule *rule,
                                 const struct glossy_run *run, size_t p, struct glossy_met *out)
{
    struct glossy_receivers receivers;
    out->taps.count = 0;
    glossy_load_receivers(f, rule, p, &receivers);
    if (!simd_any(&receivers.receives)) return;
    glossy_walk(f, &receivers, p, -run->step, run->before, out);
    glossy_walk(f, &receivers, p, run->step, run->after, out);
    glossy_weigh(&receivers, out);
}

static void kernel_spread(const struct glossy_field *f, const struct glossy_rule *rule,
                          const struct glossy_run *run, uint32_t count, const float *const *in,
                          float *const *out)
{
    struct glossy_met met;
    for (size_t p = run->first; p < run->first + run->count; p += SIMD_LANES) {
        glossy_gather(f, rule, run, p, &met);
        taps_mean(&met.taps, count, in, p, out);
    }
}
