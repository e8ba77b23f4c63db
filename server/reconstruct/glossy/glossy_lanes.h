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
#include "server/reconstruct/simd/lanes_vector.h"
#include "server/reconstruct/simd/tap_lanes.h"

#define GLOSSY_LOG_2     0.693147181f
#define GLOSSY_DET_LEAST 1e-30f
#define GLOSSY_SLOPE     0.1225f /* squared: neighbours may lie so far off the plane, over distance */

_Static_assert(TAPS_MOST >= GLOSSY_TAPS && LANES_COUNT == GLOSSY_LANES, "a line's neighbours");

/* Sixteen receivers. */
struct glossy_receivers {
    struct lanes point[3], normal[3], mirror[3];
    struct lanes e1[3], e2[3];                    /* along and across, unit */
    struct lanes s11, s22;                        /* the covariance, which is diagonal there */
    struct lanes sharpness, nearness, off;        /* of the tangent plane */
    struct lanes similarity, distance, footprint; /* of the rule */
    struct lanes_whole object, receives;
};

/* Computes unit axes of the receivers. Without a lobe they are any finite numbers. */
static inline void glossy_axis(const float *const in[3], size_t p, struct lanes unit[3],
                               struct lanes *square)
{
    for (int k = 0; k < 3; k++) unit[k] = lanes_load(in[k] + p);
    for (int v = 0; v < LANES_VECTORS; v++) {
        const lanes_vector a[3] = {unit[0].v[v], unit[1].v[v], unit[2].v[v]};
        const lanes_vector squared = lanes_dot(a, a);
        const lanes_vector fit =
            lanes_select(squared > GLOSSY_DET_LEAST, squared, lanes_all(1.0f).v[v]);
        float root[LANES_PER_VECTOR];
        lanes_vector length;
        memcpy(root, &fit, sizeof root);
        for (int i = 0; i < LANES_PER_VECTOR; i++) root[i] = sqrtf(root[i]);
        length = lanes_load_vector(root);
        for (int k = 0; k < 3; k++) unit[k].v[v] = a[k] / length;
        square->v[v] = fit;
    }
}

static inline void glossy_load_receivers(const struct glossy_field *f,
                                         const struct glossy_rule *rule, size_t p,
                                         struct glossy_receivers *a)
{
    const bool own = f->similarity != NULL;
    a->similarity = own ? lanes_load(f->similarity + p) : lanes_all(rule->similarity);
    a->distance = own ? lanes_load(f->distance + p) : lanes_all(rule->distance);
    a->footprint = own ? lanes_load(f->footprint + p) : lanes_all(rule->footprint);
    for (int k = 0; k < 3; k++) {
        a->point[k] = lanes_load(f->point[k] + p);
        a->normal[k] = lanes_load(f->normal[k] + p);
        a->mirror[k] = lanes_load(f->mirror[k] + p);
    }
    glossy_axis(f->along, p, a->e1, &a->s11);
    glossy_axis(f->across, p, a->e2, &a->s22);
    a->sharpness = lanes_load(f->sharpness + p);
    a->nearness = lanes_load(f->nearness + p);
    a->off = lanes_load(f->near_plane + p);
    a->object = lanes_load_whole(f->object + p);
    for (int v = 0; v < LANES_VECTORS; v++) a->receives.v[v] = a->object.v[v] != 0;
}

/* Returns the natural logarithm of normal numbers above 0, for a mantissa from 0.7 to 1.4 as 2
 * artanh. The absolute error is 2e-7 beside that of adding the exponent. */
static inline lanes_vector glossy_log(lanes_vector x)
{
    const lanes_mask bits = (lanes_mask)x;
    const lanes_mask scaled = (bits & 0x007fffff) | 0x3f800000; /* 1 to 2 */
    const lanes_mask large = (lanes_vector)scaled > 1.41421356f;
    const lanes_vector m = (lanes_vector)(scaled - (large & 0x00800000));
    const lanes_vector e = __builtin_convertvector((bits >> 23) - 127 - large, lanes_vector);
    const lanes_vector t = (m - 1.0f) / (m + 1.0f), s = t * t;
    const lanes_vector low = lanes_fused(s, lanes_same(0.2f), lanes_same(0.333333333f));
    const lanes_vector high = lanes_fused(s, lanes_same(0.111111111f), lanes_same(0.142857143f));
    const lanes_vector series = lanes_fused(t * s, lanes_fused(s * s, high, low), t);
    return lanes_fused(e, lanes_same(GLOSSY_LOG_2), series + series);
}

/* Returns exp(-x) for x from 0 to GLOSSY_CUT, as the sixteenth power of exp(-x/16)'s series. The
 * relative error is 4.1e-5, and 0 at 0. Results beyond are undefined. */
static inline lanes_vector glossy_exp_minus(lanes_vector x)
{
    const lanes_vector y = x * -0.0625f, squared = y * y;
    const lanes_vector linear = lanes_fused(y, lanes_same(1.0f / 6), lanes_same(0.5f));
    const lanes_vector low = lanes_fused(squared, linear, 1.0f + y);
    const lanes_vector fourth = lanes_fused(y, lanes_same(1.0f / 120), lanes_same(1.0f / 24));
    const lanes_vector high = lanes_fused(squared, lanes_same(1.0f / 720), fourth);
    lanes_vector p = lanes_fused(squared * squared, high, low);
    p = p * p;
    p = p * p;
    p = p * p;
    return p * p;
}

/* The neighbours that receivers may accept, with what their weights follow from: both lobes' shapes
 * and views. All are met before any is weighed. Steps that short let the CPU work on several taps
 * at once. */
struct glossy_met {
    struct taps taps;                                    /* weights: masks of accepted taps */
    _Alignas(64) float det[GLOSSY_TAPS][GLOSSY_LANES];   /* of S */
    _Alignas(64) float apart[GLOSSY_TAPS][GLOSSY_LANES]; /* h^T S^-1 h times that */
    _Alignas(64) float sharp[GLOSSY_TAPS][GLOSSY_LANES];
    float square[GLOSSY_TAPS]; /* of the distance in pixels */
};

/* Compares the lobes of vector v of the receivers with those of the neighbours at `at`, whose
 * points lie at d from the receivers'. */
static inline void glossy_compare(const struct glossy_field *f, const struct glossy_receivers *a,
                                  size_t at, int v, const lanes_vector d[3], struct glossy_met *out)
{
    const uint32_t t = out->taps.count;
    const size_t lane = (size_t)v * LANES_PER_VECTOR;
    const lanes_vector e1[3] = {a->e1[0].v[v], a->e1[1].v[v], a->e1[2].v[v]};
    const lanes_vector e2[3] = {a->e2[0].v[v], a->e2[1].v[v], a->e2[2].v[v]};
    const lanes_vector near = a->nearness.v[v];
    lanes_vector along[3], across[3], h[3];
    for (int k = 0; k < 3; k++) {
        along[k] = lanes_load_vector(f->along[k] + at);
        across[k] = lanes_load_vector(f->across[k] + at);
        h[k] = lanes_fused(near, d[k], lanes_load_vector(f->mirror[k] + at) - a->mirror[k].v[v]);
    }
    const lanes_vector p1 = lanes_dot(along, e1), p2 = lanes_dot(along, e2);
    const lanes_vector q1 = lanes_dot(across, e1), q2 = lanes_dot(across, e2);
    const lanes_vector h1 = lanes_dot(h, e1), h2 = lanes_dot(h, e2);
    const lanes_vector s11 = lanes_fused(p1, p1, lanes_fused(q1, q1, a->s11.v[v]));
    const lanes_vector s22 = lanes_fused(p2, p2, lanes_fused(q2, q2, a->s22.v[v]));
    const lanes_vector s12 = lanes_fused(p1, p2, q1 * q2);
    const lanes_vector raw = lanes_fused(s11, s22, -s12 * s12);
    /* h1 (h1 s22 - h2 s12) + h2 (h2 s11 - h1 s12) */
    const lanes_vector first = lanes_fused(h1, s22, -h2 * s12);
    const lanes_vector second = lanes_fused(h2, s11, -h1 * s12);
    *(lanes_stored *)(out->det[t] + lane) =
        lanes_select(raw > GLOSSY_DET_LEAST, raw, lanes_same(GLOSSY_DET_LEAST));
    *(lanes_stored *)(out->apart[t] + lane) = lanes_fused(h1, first, h2 * second);
    *(lanes_stored *)(out->sharp[t] + lane) =
        a->sharpness.v[v] + lanes_load_vector(f->sharpness + at);
}

/* Returns the mask of receivers of vector v that may accept the neighbours from q on. */
static inline lanes_mask glossy_meet(const struct glossy_field *f, const struct glossy_receivers *a,
                                     size_t q, int v, struct glossy_met *out)
{
    const size_t at = q + (size_t)v * LANES_PER_VECTOR;
    const lanes_vector n[3] = {a->normal[0].v[v], a->normal[1].v[v], a->normal[2].v[v]};
    lanes_vector d[3];
    for (int k = 0; k < 3; k++) d[k] = lanes_load_vector(f->point[k] + at) - a->point[k].v[v];
    const lanes_vector off = lanes_dot(d, n), length = lanes_dot(d, d);
    const lanes_mask flat =
        (lanes_positive(off) <= a->off.v[v]) | (off * off <= GLOSSY_SLOPE * length);
    const lanes_mask same = lanes_load_mask(f->object + at) == a->object.v[v];
    glossy_compare(f, a, at, v, d, out);
    return flat & same & a->receives.v[v];
}

/* Returns whether any neighbour shows an object of the receivers. */
static inline int glossy_meets(const struct glossy_field *f, const struct glossy_receivers *a,
                               size_t q)
{
    struct lanes_whole same;
    for (int v = 0; v < LANES_VECTORS; v++)
        same.v[v] = a->receives.v[v] &
                    (lanes_load_mask(f->object + q + v * LANES_PER_VECTOR) == a->object.v[v]);
    return lanes_any(&same);
}

/* Meets the neighbours to one side, without those that no receiver may accept. */
static inline void glossy_walk(const struct glossy_field *f, const struct glossy_receivers *a,
                               size_t p, ptrdiff_t step, int32_t reach, struct glossy_met *out)
{
    for (int32_t k = 1; k <= reach; k++) {
        const size_t q = (size_t)((ptrdiff_t)p + k * step);
        struct lanes_whole taken;
        struct lanes masks;
        if (!glossy_meets(f, a, q)) continue;
        for (int v = 0; v < LANES_VECTORS; v++) {
            taken.v[v] = glossy_meet(f, a, q, v, out);
            masks.v[v] = (lanes_vector)taken.v[v];
        }
        if (!lanes_any(&taken)) continue;
        out->square[out->taps.count] = (float)k * (float)k;
        taps_add(&out->taps, q, &masks);
    }
}

/* Returns the weights that vector v of the receivers gives to tap t. Parallax within a pixel's
 * footprint is forgiven, because the picture does not resolve it. */
static inline lanes_vector glossy_weight(const struct glossy_receivers *a,
                                         const struct glossy_met *met, uint32_t t, int v)
{
    const size_t lane = (size_t)v * LANES_PER_VECTOR;
    const lanes_mask may = (lanes_mask)lanes_load_vector(met->taps.weight[t] + lane);
    const lanes_vector det = lanes_load_vector(met->det[t] + lane);
    const lanes_vector square = lanes_same(met->square[t]);
    const lanes_vector sharp = lanes_load_vector(met->sharp[t] + lane);
    const lanes_vector shape =
        lanes_fused(glossy_log(det), lanes_same(0.5f), -(sharp + GLOSSY_LOG_2));
    const lanes_vector apart = lanes_load_vector(met->apart[t] + lane) / det;
    const lanes_vector view = a->similarity.v[v] * (0.5f * apart);
    const lanes_vector most = square * a->footprint.v[v];
    const lanes_vector own = lanes_fused(a->similarity.v[v], shape, lanes_least(view, most));
    const lanes_vector x = lanes_fused(a->distance.v[v], square, lanes_where(own > 0.0f, own));
    return lanes_where(may & (x <= GLOSSY_CUT), glossy_exp_minus(x));
}

static inline void glossy_weigh(const struct glossy_receivers *a, struct glossy_met *met)
{
    for (uint32_t t = 0; t < met->taps.count; t++) {
        struct lanes weight;
        for (int v = 0; v < LANES_VECTORS; v++) weight.v[v] = glossy_weight(a, met, t, v);
        lanes_store(&weight, met->taps.weight[t]);
    }
}

static inline void glossy_gather(const struct glossy_field *f, const struct glossy_rule *rule,
                                 const struct glossy_run *run, size_t p, struct glossy_met *out)
{
    struct glossy_receivers receivers;
    out->taps.count = 0;
    glossy_load_receivers(f, rule, p, &receivers);
    if (!lanes_any(&receivers.receives)) return;
    glossy_walk(f, &receivers, p, -run->step, run->before, out);
    glossy_walk(f, &receivers, p, run->step, run->after, out);
    glossy_weigh(&receivers, out);
}

static void kernel_spread(const struct glossy_field *f, const struct glossy_rule *rule,
                          const struct glossy_run *run, uint32_t count, const float *const *in,
                          float *const *out)
{
    struct glossy_met met;
    for (size_t p = run->first; p < run->first + run->count; p += GLOSSY_LANES) {
        glossy_gather(f, rule, run, p, &met);
        taps_mean(&met.taps, count, in, p, out);
    }
}
