#pragma once
/* The lobes of sixteen receivers beside those of neighbours. Each way to compare two lobes gives
 * numbers `det`, `apart` and, by the pixels' own, `sharp`, of which the log of their similarity is
 *
 *   log 2 + sharp - (log det) / 2 - apart / det / 2
 *
 * and is 0 for a lobe and itself (docs/reconstruction.md, Glossy lobes and Lobes as published). */
#include <stdbool.h>

#include "server/reconstruct/glossy/glossy_kernels.h"
#include "server/reconstruct/glossy/glossy_mixture.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/tap_lanes.h"
#include "server/reconstruct/simd/vector.h"

#define GLOSSY_LOG_2   0.693147181f
#define GLOSSY_DET_MIN 1e-30f
#define GLOSSY_FAR     16.0f /* exp of less is as good as 0 */
#define GLOSSY_OPPOSED 1e-4f /* of the sum of two sharpnesses: less does not count */

_Static_assert(TAPS_MAX >= GLOSSY_TAPS, "a line's neighbours");

/* Sixteen receivers. */
struct glossy_receivers {
    struct simd point[3], normal[3], mirror[3];
    struct simd e1[3], e2[3];                    /* along and across, unit */
    struct simd s11, s22;                        /* the covariance, which is diagonal there */
    struct simd round;                           /* variance of the round lobe */
    struct simd sharpness, nearness, off;        /* of the tangent plane */
    struct simd similarity, distance, footprint; /* of the rule */
    float taper, cut;
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
        const simd_vector fit = simd_select(squared > GLOSSY_DET_MIN, squared, simd_same(1.0f));
        const simd_vector length = simd_root(fit);
        for (int k = 0; k < 3; k++) unit[k].v[v] = a[k] / length;
        square->v[v] = fit;
    }
}

SIMD_INLINE void glossy_load_receivers(const struct glossy_field *f, enum glossy_shape shape,
                                       const struct glossy_rule *rule, size_t p,
                                       struct glossy_receivers *a)
{
    const bool own = f->similarity != NULL;
    a->taper = rule->taper;
    a->cut = rule->taper * GLOSSY_CUT > 1.0f ? 1.0f / rule->taper : GLOSSY_CUT;
    a->similarity = own ? simd_load(f->similarity + p) : simd_all(rule->similarity);
    a->distance = own ? simd_load(f->distance + p) : simd_all(rule->distance);
    a->footprint = own ? simd_load(f->footprint + p) : simd_all(rule->footprint);
    for (int k = 0; k < 3; k++) {
        a->point[k] = simd_load(f->point[k] + p);
        a->normal[k] = simd_load(f->normal[k] + p);
        a->mirror[k] = simd_load(f->mirror[k] + p);
    }
    if (shape == GLOSSY_ELLIPTIC) {
        glossy_axis(f->along, p, a->e1, &a->s11);
        glossy_axis(f->across, p, a->e2, &a->s22);
    } else {
        a->round = simd_load(f->round + p);
    }
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
 * relative error is 4.1e-5, and 0 at 0; up to GLOSSY_FAR it is 0.9 %. Results beyond are undefined.
 */
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
    struct taps taps; /* weights: masks of accepted taps */
    _Alignas(64) float det[GLOSSY_TAPS][SIMD_LANES];
    _Alignas(64) float apart[GLOSSY_TAPS][SIMD_LANES];
    _Alignas(64) float sharp[GLOSSY_TAPS][SIMD_LANES];
    float square[GLOSSY_TAPS]; /* of the distance in pixels */
};

/* Compares elliptic lobes of vector v of the receivers with those of the neighbours at `at`. S is
 * the sum of both lobes' covariances, in two coordinates at right angles to the receiver's mirrored
 * direction, and h how far apart the lobes meet the point that the receiver's lobe sees, as
 * directions. det is that of S, and apart h^T S^-1 h times that. As S is a sum of products v v^T of
 * four vectors, both are sums of squares of cross products, which lose nothing where lobes are
 * narrow. */
static inline void glossy_compare_elliptic(const struct glossy_field *f,
                                           const struct glossy_receivers *a, size_t at, int v,
                                           const simd_vector h[3], simd_vector *det,
                                           simd_vector *apart)
{
    const simd_vector e1[3] = {a->e1[0].v[v], a->e1[1].v[v], a->e1[2].v[v]};
    const simd_vector e2[3] = {a->e2[0].v[v], a->e2[1].v[v], a->e2[2].v[v]};
    const simd_vector s11 = a->s11.v[v], s22 = a->s22.v[v];
    simd_vector along[3], across[3];
    for (int k = 0; k < 3; k++) {
        along[k] = simd_load_vector(f->along[k] + at);
        across[k] = simd_load_vector(f->across[k] + at);
    }
    const simd_vector p1 = simd_dot(along, e1), p2 = simd_dot(along, e2);
    const simd_vector q1 = simd_dot(across, e1), q2 = simd_dot(across, e2);
    const simd_vector h1 = simd_dot(h, e1), h2 = simd_dot(h, e2);
    const simd_vector pq = simd_fused(p1, q2, -p2 * q1);
    const simd_vector ph = simd_fused(p1, h2, -p2 * h1), qh = simd_fused(q1, h2, -q2 * h1);
    const simd_vector t11 = simd_fused(p1, p1, q1 * q1), t22 = simd_fused(p2, p2, q2 * q2);
    const simd_vector own = simd_fused(s11, s22, pq * pq);
    const simd_vector other = simd_fused(h2 * h2, s11, h1 * h1 * s22);
    *det = simd_fused(s11, t22, simd_fused(s22, t11, own));
    *apart = simd_fused(ph, ph, simd_fused(qh, qh, other));
}

/* Compares round lobes of variances s: Tokuyoshi's equation 12. det is (s_i + s_j)^2. The distance
 * of unit vectors tells how far apart they are without loss, where 1 - cosine would not. */
static inline void glossy_compare_round(const struct glossy_field *f,
                                        const struct glossy_receivers *a, size_t at, int v,
                                        const simd_vector h[3], simd_vector *det,
                                        simd_vector *apart)
{
    const simd_vector sum = a->round.v[v] + simd_load_vector(f->round + at);
    *det = sum * sum;
    *apart = simd_dot(h, h) * sum;
}

/* Two mixtures: the variances of the one lobe that each stands for, and how far apart they are. */
struct glossy_product {
    simd_vector si, sj;
    simd_vector apart;   /* |r_i - r_j|^2 */
    simd_vector both;    /* s_i s_j */
    simd_vector inverse; /* 1 over that */
};

/* Returns what Gaussians l of the receivers and m of the neighbours add to the product, without the
 * factor exp(-x). With d the sum of both sharpnesses and n the length of the sum of both axes times
 * these, all times s_i s_j, that is (1 - exp(-2 n / s_i s_j)) / n, and x is (d - n) / s_i s_j,
 * though not by that difference. */
SIMD_INLINE simd_vector glossy_pair(const struct glossy_product *a, int l, int m, simd_vector *x)
{
    const float *times = glossy_mixed_times;
    const float amount = glossy_mixed_amount[l] * glossy_mixed_amount[m];
    const simd_vector d = simd_fused(simd_same(times[l]), a->sj, times[m] * a->si);
    const simd_vector p = times[l] * times[m] * a->apart, square = simd_fused(d, d, -p * a->both);
    const simd_vector root = simd_root(simd_where(square > 0.0f, square));
    const simd_vector n = simd_max(root, GLOSSY_OPPOSED * d), sum = d + n;
    const simd_vector r = 1.0f / (n * sum), z = 2.0f * n * a->inverse;
    const simd_vector part = amount * sum * r;
    *x = p * (n * r);
    if (!simd_some(simd_up_to(z, simd_same(GLOSSY_FAR)))) return part;
    return part - simd_where(z <= GLOSSY_FAR, part * glossy_exp_minus(z));
}

/* Compares mixtures of round lobes: equation 11, with sinh(n) / (exp(d) n) as (1 - exp(-2 n)) / 2 n
 * times exp(-x). The widest two have the least x. det is 1 over the sum's square. */
SIMD_INLINE void glossy_compare_mixtures(const struct glossy_field *f,
                                         const struct glossy_receivers *a, size_t at, int v,
                                         const simd_vector h[3], simd_vector *det,
                                         simd_vector *apart)
{
    const simd_vector si = a->round.v[v], sj = simd_load_vector(f->round + at);
    const simd_vector both = si * sj;
    const struct glossy_product product = {si, sj, simd_dot(h, h), both, 1.0f / both};
    simd_vector x, least, sum = glossy_pair(&product, GLOSSY_MIXED - 1, GLOSSY_MIXED - 1, &least);
    for (int k = 0; k < GLOSSY_MIXED * GLOSSY_MIXED - 1; k++) {
        const simd_vector part = glossy_pair(&product, k / GLOSSY_MIXED, k % GLOSSY_MIXED, &x);
        const simd_vector more = simd_max(x - least, (simd_vector){0});
        sum += simd_where(more <= GLOSSY_FAR, part * glossy_exp_minus(more));
    }
    *det = 1.0f / (sum * sum);
    *apart = 2.0f * least * *det;
}

/* Compares the lobes of vector v of the receivers with those of the neighbours at `at`, whose
 * points lie at d from the receivers'. */
SIMD_INLINE void glossy_compare(const struct glossy_field *f, enum glossy_shape shape,
                                const struct glossy_receivers *a, size_t at, int v,
                                const simd_vector d[3], struct glossy_met *out)
{
    const uint32_t t = out->taps.count;
    const size_t lane = (size_t)v * SIMD_PER_VECTOR;
    simd_vector h[3], det, apart;
    for (int k = 0; k < 3; k++) h[k] = simd_load_vector(f->mirror[k] + at) - a->mirror[k].v[v];
    for (int k = 0; k < 3 && shape == GLOSSY_ELLIPTIC; k++)
        h[k] = simd_fused(a->nearness.v[v], d[k], h[k]);
    if (shape == GLOSSY_ELLIPTIC) glossy_compare_elliptic(f, a, at, v, h, &det, &apart);
    if (shape == GLOSSY_ROUND) glossy_compare_round(f, a, at, v, h, &det, &apart);
    if (shape == GLOSSY_MIXTURE) glossy_compare_mixtures(f, a, at, v, h, &det, &apart);
    *(simd_stored *)(out->det[t] + lane) =
        simd_select(det > GLOSSY_DET_MIN, det, simd_same(GLOSSY_DET_MIN));
    *(simd_stored *)(out->apart[t] + lane) = apart;
    *(simd_stored *)(out->sharp[t] + lane) =
        a->sharpness.v[v] + simd_load_vector(f->sharpness + at);
}
