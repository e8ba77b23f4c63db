#pragma once
/* indirect_kernels, sixteen receiving pixels side by side: whatever instruction set the including
 * file is compiled for, each lane sees the same operations in the same order, fused where it can.
 */
#include <math.h>

#include "server/reconstruct/indirect/indirect_kernels.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/tap_lanes.h"
#include "server/reconstruct/simd/vector.h"

#define LINE_WEIGHT_MIN 3.0f  /* of the neighbours and the pixel itself, for a line */
#define LINE_SPREAD_MIN 0.05f /* how far the fit is from one-sided: det / (S0 S2) */
#define LINE_FLOOR      0.25f /* of the mean */
#define LINE_TOGETHER   3     /* channels */

/* Neighbours, and for rule B signed distances in sqrt 2 beta, then weights times those. */
struct indirect_taps {
    struct taps taps;
    _Alignas(64) float moment[INDIRECT_TAPS][SIMD_LANES];
};
_Static_assert(TAPS_MAX >= INDIRECT_TAPS, "a line's neighbours");

/* What sixteen pixels compare their neighbours with. */
struct indirect_receivers {
    struct simd point[3], normal[3], falloff, off;
    struct simd_whole object, receives;
};

static inline void indirect_load_receivers(const struct indirect_field *f, size_t p,
                                           struct indirect_receivers *a)
{
    for (int k = 0; k < 3; k++) {
        a->point[k] = simd_load(f->point[k] + p);
        a->normal[k] = simd_load(f->normal[k] + p);
    }
    a->falloff = simd_load(f->falloff + p);
    a->off = simd_load(f->off + p);
    a->object = simd_load_whole(f->object + p);
    for (int v = 0; v < SIMD_VECTORS; v++) a->receives.v[v] = a->falloff.v[v] > 0.0f;
}

/* Returns exp(-x) for x from 0 to INDIRECT_CUT, as the fourth power of a fit of exp(-x/4). The
 * relative error is 4e-6, and 0 at 0. Results beyond are undefined. */
static inline simd_vector indirect_exp_minus(simd_vector x)
{
    const simd_vector squared = x * x;
    const simd_vector low = simd_fused(x, simd_same(-0.24999985f), simd_same(1.0f));
    const simd_vector mid = simd_fused(x, simd_same(-0.00259792923f), simd_same(0.0312475927f));
    const simd_vector high = simd_fused(x, simd_same(-5.9123179e-06f), simd_same(0.000157021284f));
    const simd_vector p = simd_fused(squared, simd_fused(squared, high, mid), low);
    const simd_vector square = p * p;
    return square * square;
}

/* Meets vector v of the neighbours from q on. Finds their exponents, and which of them are taken by
 * walks that still go on. A walk ends that meets its own object beyond the cut. */
static inline simd_mask indirect_meet(const struct indirect_field *f,
                                      const struct indirect_receivers *a, size_t q, int v,
                                      simd_mask *walks, simd_vector *exponent)
{
    const size_t at = q + (size_t)v * SIMD_PER_VECTOR;
    simd_vector d[3], n[3];
    for (int k = 0; k < 3; k++) {
        d[k] = simd_load_vector(f->point[k] + at) - a->point[k].v[v];
        n[k] = simd_load_vector(f->normal[k] + at);
    }
    const simd_vector own[3] = {a->normal[0].v[v], a->normal[1].v[v], a->normal[2].v[v]};
    const simd_vector off = simd_dot(d, own), alike = simd_dot(n, own);
    *exponent = simd_dot(d, d) * a->falloff.v[v];
    const simd_mask near = *exponent <= INDIRECT_CUT;
    const simd_mask same = simd_load_mask(f->object + at) == a->object.v[v];
    const simd_mask taken =
        *walks & near & (alike >= INDIRECT_COS) & (simd_positive(off) <= a->off.v[v]);
    *walks &= ~(same & ~near);
    return taken;
}

/* Weighs the taps to one side. A tap that no pixel takes is left out. */
static inline void indirect_weigh(const struct indirect_field *f,
                                  const struct indirect_receivers *a, size_t p, ptrdiff_t step,
                                  int32_t reach, int moments, struct indirect_taps *taps)
{
    struct simd_whole walks = a->receives, taken;
    const float sign = step < 0 ? -1.0f : 1.0f;
    for (int32_t k = 1; k <= reach && simd_any(&walks); k++) {
        const size_t q = (size_t)((ptrdiff_t)p + k * step);
        float *moment = taps->moment[taps->taps.count];
        struct simd exponent, w;
        for (int v = 0; v < SIMD_VECTORS; v++) {
            taken.v[v] = indirect_meet(f, a, q, v, &walks.v[v], &exponent.v[v]);
            w.v[v] = simd_where(taken.v[v], indirect_exp_minus(exponent.v[v]));
        }
        if (!simd_any(&taken)) continue;
        if (moments) {
            for (int v = 0; v < SIMD_VECTORS; v++)
                exponent.v[v] = simd_where(taken.v[v], exponent.v[v]);
            simd_store(&exponent, moment);
            for (int i = 0; i < SIMD_LANES; i++) moment[i] = sign * sqrtf(moment[i]);
        }
        taps_add(&taps->taps, q, &w);
    }
}

static inline void indirect_gather(const struct indirect_field *f, const struct indirect_run *run,
                                   size_t p, int moments, struct indirect_taps *taps)
{
    struct indirect_receivers receivers;
    taps->taps.count = 0;
    indirect_load_receivers(f, p, &receivers);
    indirect_weigh(f, &receivers, p, -run->step, run->before, moments, taps);
    indirect_weigh(f, &receivers, p, run->step, run->after, moments, taps);
}

static void kernel_mean(const struct indirect_field *f, const struct indirect_run *run,
                        uint32_t count, const float *const *in, float *const *out)
{
    struct indirect_taps taps;
    for (size_t p = run->first; p < run->first + run->count; p += SIMD_LANES) {
        indirect_gather(f, run, p, 0, &taps);
        taps_mean(&taps.taps, count, in, p, out);
    }
}

/* What turns each pixel's sums into the line's value at it. */
struct indirect_line {
    struct simd inverse; /* of the sum of weights */
    struct simd first, second;
};

/* Fits the lines. With r the signed distance and T0, T1 the sums of w (c - own) and w r (c - own),
 * the line's value less the own one is (S2 T0 - S1 T1) / det: of T0, `first`, and of T1,
 * `second`. */
static inline void indirect_fit(struct indirect_taps *taps, struct indirect_line *line)
{
    struct simd s0 = simd_all(1.0f), s1 = simd_all(0.0f), s2 = simd_all(0.0f);
    for (uint32_t t = 0; t < taps->taps.count; t++) {
        const struct simd w = simd_load(taps->taps.weight[t]), r = simd_load(taps->moment[t]);
        struct simd m;
        for (int v = 0; v < SIMD_VECTORS; v++) {
            m.v[v] = w.v[v] * r.v[v];
            s0.v[v] += w.v[v];
            s1.v[v] += m.v[v];
            s2.v[v] = simd_fused(m.v[v], r.v[v], s2.v[v]);
        }
        simd_store(&m, taps->moment[t]);
    }
    for (int v = 0; v < SIMD_VECTORS; v++) {
        const simd_vector det = simd_fused(s0.v[v], s2.v[v], -s1.v[v] * s1.v[v]);
        const simd_mask fits =
            (s0.v[v] > LINE_WEIGHT_MIN) & (det > LINE_SPREAD_MIN * s0.v[v] * s2.v[v]);
        const simd_vector by = simd_select(fits, det, simd_all(1.0f).v[v]);
        line->inverse.v[v] = 1.0f / s0.v[v];
        line->first.v[v] = simd_select(fits, s2.v[v] / by, line->inverse.v[v]);
        line->second.v[v] = simd_select(fits, s1.v[v] / by, simd_all(0.0f).v[v]);
    }
}

/* Computes vector v of `channels` channels, LINE_TOGETHER at most, whose sums stay in registers. */
SIMD_INLINE void indirect_line_of(const struct indirect_taps *taps,
                                  const struct indirect_line *line, const float *const *in,
                                  size_t p, int v, uint32_t channels, float *const *out)
{
    const size_t aside = (size_t)v * SIMD_PER_VECTOR;
    simd_vector own[LINE_TOGETHER], sum[LINE_TOGETHER], moment[LINE_TOGETHER];
    for (uint32_t c = 0; c < channels; c++) {
        own[c] = simd_load_vector(in[c] + p + aside);
        sum[c] = moment[c] = (simd_vector){0};
    }
    for (uint32_t t = 0; t < taps->taps.count; t++) {
        const simd_vector w = simd_load_vector(taps->taps.weight[t] + aside);
        const simd_vector m = simd_load_vector(taps->moment[t] + aside);
        const size_t from = (size_t)taps->taps.at[t] + aside;
        for (uint32_t c = 0; c < channels; c++) {
            const simd_vector more = simd_load_vector(in[c] + from) - own[c];
            sum[c] = simd_fused(w, more, sum[c]);
            moment[c] = simd_fused(m, more, moment[c]);
        }
    }
    for (uint32_t c = 0; c < channels; c++) {
        const simd_vector least = LINE_FLOOR * simd_fused(sum[c], line->inverse.v[v], own[c]);
        const simd_vector skew = line->second.v[v] * moment[c];
        const simd_vector at = own[c] + simd_fused(line->first.v[v], sum[c], -skew);
        *(simd_stored *)(out[c] + p + aside) = simd_select(at > least, at, least);
    }
}

static void kernel_line(const struct indirect_field *f, const struct indirect_run *run,
                        uint32_t count, const float *const *in, float *const *out)
{
    struct indirect_taps taps;
    struct indirect_line line;
    for (size_t p = run->first; p < run->first + run->count; p += SIMD_LANES) {
        indirect_gather(f, run, p, 1, &taps);
        indirect_fit(&taps, &line);
        for (int v = 0; v < SIMD_VECTORS; v++) {
            uint32_t c = 0;
            for (; c + LINE_TOGETHER <= count; c += LINE_TOGETHER)
                indirect_line_of(&taps, &line, in + c, p, v, LINE_TOGETHER, out + c);
            for (; c < count; c++) indirect_line_of(&taps, &line, in + c, p, v, 1, out + c);
        }
    }
}

/* Adds `near` where it is above 0 and of the same object, and counts it. */
static inline void nearness_add(simd_mask object, simd_mask own, simd_vector near, simd_vector *sum,
                                simd_vector *counts)
{
    const simd_vector one = simd_all(1.0f).v[0];
#ifdef __AVX512F__
    const __mmask16 same = _mm512_cmpeq_epi32_mask((__m512i)object, (__m512i)own);
    const simd_chosen met =
        _mm512_mask_cmp_ps_mask(same, (__m512)near, _mm512_setzero_ps(), _CMP_GT_OQ);
#else
    const simd_chosen met = (object == own) & (near > 0.0f);
#endif
    *sum = simd_add_to(*sum, met, near);
    *counts = simd_add_to(*counts, met, one);
}

/* Groups of sixteen pixels that are summed at once, as many as registers hold sums of, since each
 * sum waits for its last addend. */
#ifdef __AVX512F__
#define NEARNESS_GROUPS 2
#else
#define NEARNESS_GROUPS 1
#endif

/* Computes the means of `groups` times sixteen pixels from p on. */
SIMD_INLINE void nearness_mean(const struct indirect_field *f, const struct indirect_run *run,
                               const float *nearness, size_t p, int groups, float *out)
{
    struct simd sum[NEARNESS_GROUPS], counts[NEARNESS_GROUPS];
    struct simd_whole own[NEARNESS_GROUPS];
    for (int g = 0; g < groups; g++) {
        sum[g] = counts[g] = simd_all(0.0f);
        own[g] = simd_load_whole(f->object + p + g * SIMD_LANES);
    }
    for (int32_t y = -run->before; y <= run->after; y++) {
        for (int32_t x = -INDIRECT_NEAR_PX; x <= INDIRECT_NEAR_PX; x++) {
            for (int g = 0; g < groups; g++) {
                const size_t q = (size_t)((ptrdiff_t)p + y * run->step + x + g * SIMD_LANES);
                const struct simd_whole object = simd_load_whole(f->object + q);
                const struct simd near = simd_load(nearness + q);
                for (int v = 0; v < SIMD_VECTORS; v++)
                    nearness_add(object.v[v], own[g].v[v], near.v[v], &sum[g].v[v],
                                 &counts[g].v[v]);
            }
        }
    }
    for (int g = 0; g < groups; g++) {
        for (int v = 0; v < SIMD_VECTORS; v++)
            sum[g].v[v] /= simd_select(counts[g].v[v] > 0.0f, counts[g].v[v], simd_all(1.0f).v[v]);
        simd_store(&sum[g], out + p + g * SIMD_LANES);
    }
}

static void kernel_nearness(const struct indirect_field *f, const struct indirect_run *run,
                            const float *nearness, float *out)
{
    const size_t end = run->first + run->count;
    size_t p = run->first;
    for (; p + NEARNESS_GROUPS * SIMD_LANES <= end; p += NEARNESS_GROUPS * SIMD_LANES)
        nearness_mean(f, run, nearness, p, NEARNESS_GROUPS, out);
    for (; p < end; p += SIMD_LANES) nearness_mean(f, run, nearness, p, 1, out);
}
