#pragma once
/* indirect_kernels, sixteen receiving pixels side by side: whatever instruction set the including
 * file is compiled for, each lane sees the same operations in the same order, fused where it can.
 */
#include <math.h>

#include "server/reconstruct/indirect/indirect_kernels.h"
#include "server/reconstruct/simd/lanes_inline.h"
#include "server/reconstruct/simd/lanes_vector.h"
#include "server/reconstruct/simd/tap_lanes.h"

#define LINE_WEIGHT_LEAST 3.0f  /* of the neighbours and the pixel itself, for a line */
#define LINE_SPREAD_LEAST 0.05f /* how far the fit is from one-sided: det / (S0 S2) */
#define LINE_FLOOR        0.25f /* of the mean */
#define LINE_TOGETHER     3     /* channels */

/* Neighbours, and for rule B signed distances in sqrt 2 beta, then weights times those. */
struct indirect_taps {
    struct taps taps;
    _Alignas(64) float moment[INDIRECT_TAPS][INDIRECT_LANES];
};
_Static_assert(TAPS_MOST >= INDIRECT_TAPS && LANES_COUNT == INDIRECT_LANES, "a line's neighbours");

/* What sixteen pixels ask their neighbours. */
struct indirect_receivers {
    struct lanes point[3], normal[3], falloff, off;
    struct lanes_whole object, receives;
};

static inline void indirect_load_receivers(const struct indirect_field *f, size_t p,
                                           struct indirect_receivers *a)
{
    for (int k = 0; k < 3; k++) {
        a->point[k] = lanes_load(f->point[k] + p);
        a->normal[k] = lanes_load(f->normal[k] + p);
    }
    a->falloff = lanes_load(f->falloff + p);
    a->off = lanes_load(f->off + p);
    a->object = lanes_load_whole(f->object + p);
    for (int v = 0; v < LANES_VECTORS; v++) a->receives.v[v] = a->falloff.v[v] > 0.0f;
}

/* exp(-x) for x from 0 to INDIRECT_CUT: the fourth power of a fit of exp(-x/4). Relative error
 * 4e-6, exact at 0; beyond, anything. */
static inline lanes_vector indirect_exp_minus(lanes_vector x)
{
    const lanes_vector squared = x * x;
    const lanes_vector low = lanes_fused(x, lanes_same(-0.24999985f), lanes_same(1.0f));
    const lanes_vector mid = lanes_fused(x, lanes_same(-0.00259792923f), lanes_same(0.0312475927f));
    const lanes_vector high =
        lanes_fused(x, lanes_same(-5.9123179e-06f), lanes_same(0.000157021284f));
    const lanes_vector p = lanes_fused(squared, lanes_fused(squared, high, mid), low);
    const lanes_vector square = p * p;
    return square * square;
}

/* Vector v of the neighbours from q on: their exponents, and which of them are taken by the walks
 * that still go on. Walks end that meet their own object beyond the cut. */
static inline lanes_mask indirect_meet(const struct indirect_field *f,
                                       const struct indirect_receivers *a, size_t q, int v,
                                       lanes_mask *walks, lanes_vector *exponent)
{
    const size_t at = q + (size_t)v * LANES_PER_VECTOR;
    lanes_vector d[3], n[3];
    for (int k = 0; k < 3; k++) {
        d[k] = lanes_load_vector(f->point[k] + at) - a->point[k].v[v];
        n[k] = lanes_load_vector(f->normal[k] + at);
    }
    const lanes_vector own[3] = {a->normal[0].v[v], a->normal[1].v[v], a->normal[2].v[v]};
    const lanes_vector off = lanes_dot(d, own), alike = lanes_dot(n, own);
    *exponent = lanes_dot(d, d) * a->falloff.v[v];
    const lanes_mask near = *exponent <= INDIRECT_CUT;
    const lanes_mask same = lanes_load_mask(f->object + at) == a->object.v[v];
    const lanes_mask taken =
        *walks & near & (alike >= INDIRECT_COS) & (lanes_positive(off) <= a->off.v[v]);
    *walks &= ~(same & ~near);
    return taken;
}

/* Weighs the taps to one side. A tap that no pixel takes is left out. */
static inline void indirect_weigh(const struct indirect_field *f,
                                  const struct indirect_receivers *a, size_t p, ptrdiff_t step,
                                  int32_t reach, int moments, struct indirect_taps *taps)
{
    struct lanes_whole walks = a->receives, taken;
    const float sign = step < 0 ? -1.0f : 1.0f;
    for (int32_t k = 1; k <= reach && lanes_any(&walks); k++) {
        const size_t q = (size_t)((ptrdiff_t)p + k * step);
        float *moment = taps->moment[taps->taps.count];
        struct lanes exponent, w;
        for (int v = 0; v < LANES_VECTORS; v++) {
            taken.v[v] = indirect_meet(f, a, q, v, &walks.v[v], &exponent.v[v]);
            w.v[v] = lanes_where(taken.v[v], indirect_exp_minus(exponent.v[v]));
        }
        if (!lanes_any(&taken)) continue;
        if (moments) {
            for (int v = 0; v < LANES_VECTORS; v++)
                exponent.v[v] = lanes_where(taken.v[v], exponent.v[v]);
            lanes_store(&exponent, moment);
            for (int i = 0; i < INDIRECT_LANES; i++) moment[i] = sign * sqrtf(moment[i]);
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
    for (size_t p = run->first; p < run->first + run->count; p += INDIRECT_LANES) {
        indirect_gather(f, run, p, 0, &taps);
        taps_mean(&taps.taps, count, in, p, out);
    }
}

/* Of each pixel: what turns sums into the line's value at it. */
struct indirect_line {
    struct lanes inverse; /* of the sum of weights */
    struct lanes first, second;
};

/* With r the signed distance and T0, T1 the sums of w (c - own) and w r (c - own), the line's value
 * less the own one is (S2 T0 - S1 T1) / det: of T0, `first`, and of T1, `second`. */
static inline void indirect_fit(struct indirect_taps *taps, struct indirect_line *line)
{
    struct lanes s0 = lanes_all(1.0f), s1 = lanes_all(0.0f), s2 = lanes_all(0.0f);
    for (uint32_t t = 0; t < taps->taps.count; t++) {
        const struct lanes w = lanes_load(taps->taps.weight[t]), r = lanes_load(taps->moment[t]);
        struct lanes m;
        for (int v = 0; v < LANES_VECTORS; v++) {
            m.v[v] = w.v[v] * r.v[v];
            s0.v[v] += w.v[v];
            s1.v[v] += m.v[v];
            s2.v[v] = lanes_fused(m.v[v], r.v[v], s2.v[v]);
        }
        lanes_store(&m, taps->moment[t]);
    }
    for (int v = 0; v < LANES_VECTORS; v++) {
        const lanes_vector det = lanes_fused(s0.v[v], s2.v[v], -s1.v[v] * s1.v[v]);
        const lanes_mask fits =
            (s0.v[v] > LINE_WEIGHT_LEAST) & (det > LINE_SPREAD_LEAST * s0.v[v] * s2.v[v]);
        const lanes_vector by = lanes_select(fits, det, lanes_all(1.0f).v[v]);
        line->inverse.v[v] = 1.0f / s0.v[v];
        line->first.v[v] = lanes_select(fits, s2.v[v] / by, line->inverse.v[v]);
        line->second.v[v] = lanes_select(fits, s1.v[v] / by, lanes_all(0.0f).v[v]);
    }
}

/* Vector v of `channels` channels, LINE_TOGETHER at most: their sums stay in registers. */
LANES_INLINE void indirect_line_of(const struct indirect_taps *taps,
                                   const struct indirect_line *line, const float *const *in,
                                   size_t p, int v, uint32_t channels, float *const *out)
{
    const size_t aside = (size_t)v * LANES_PER_VECTOR;
    lanes_vector own[LINE_TOGETHER], sum[LINE_TOGETHER], moment[LINE_TOGETHER];
    for (uint32_t c = 0; c < channels; c++) {
        own[c] = lanes_load_vector(in[c] + p + aside);
        sum[c] = moment[c] = (lanes_vector){0};
    }
    for (uint32_t t = 0; t < taps->taps.count; t++) {
        const lanes_vector w = lanes_load_vector(taps->taps.weight[t] + aside);
        const lanes_vector m = lanes_load_vector(taps->moment[t] + aside);
        const size_t from = (size_t)taps->taps.at[t] + aside;
        for (uint32_t c = 0; c < channels; c++) {
            const lanes_vector more = lanes_load_vector(in[c] + from) - own[c];
            sum[c] = lanes_fused(w, more, sum[c]);
            moment[c] = lanes_fused(m, more, moment[c]);
        }
    }
    for (uint32_t c = 0; c < channels; c++) {
        const lanes_vector least = LINE_FLOOR * lanes_fused(sum[c], line->inverse.v[v], own[c]);
        const lanes_vector skew = line->second.v[v] * moment[c];
        const lanes_vector at = own[c] + lanes_fused(line->first.v[v], sum[c], -skew);
        *(lanes_stored *)(out[c] + p + aside) = lanes_select(at > least, at, least);
    }
}

static void kernel_line(const struct indirect_field *f, const struct indirect_run *run,
                        uint32_t count, const float *const *in, float *const *out)
{
    struct indirect_taps taps;
    struct indirect_line line;
    for (size_t p = run->first; p < run->first + run->count; p += INDIRECT_LANES) {
        indirect_gather(f, run, p, 1, &taps);
        indirect_fit(&taps, &line);
        for (int v = 0; v < LANES_VECTORS; v++) {
            uint32_t c = 0;
            for (; c + LINE_TOGETHER <= count; c += LINE_TOGETHER)
                indirect_line_of(&taps, &line, in + c, p, v, LINE_TOGETHER, out + c);
            for (; c < count; c++) indirect_line_of(&taps, &line, in + c, p, v, 1, out + c);
        }
    }
}

/* Adds `near` where it is above 0 and of the same object, and counts it. */
static inline void nearness_add(lanes_mask object, lanes_mask own, lanes_vector near,
                                lanes_vector *sum, lanes_vector *counts)
{
    const lanes_vector one = lanes_all(1.0f).v[0];
#ifdef __AVX512F__
    const __mmask16 same = _mm512_cmpeq_epi32_mask((__m512i)object, (__m512i)own);
    const lanes_chosen met =
        _mm512_mask_cmp_ps_mask(same, (__m512)near, _mm512_setzero_ps(), _CMP_GT_OQ);
#else
    const lanes_chosen met = (object == own) & (near > 0.0f);
#endif
    *sum = lanes_add_to(*sum, met, near);
    *counts = lanes_add_to(*counts, met, one);
}

/* Groups of sixteen pixels at once: as many as registers hold sums of. Each sum waits for its last
 * addend. */
#ifdef __AVX512F__
#define NEARNESS_GROUPS 2
#else
#define NEARNESS_GROUPS 1
#endif

/* `groups` of sixteen pixels from p on. */
LANES_INLINE void nearness_mean(const struct indirect_field *f, const struct indirect_run *run,
                                const float *nearness, size_t p, int groups, float *out)
{
    struct lanes sum[NEARNESS_GROUPS], counts[NEARNESS_GROUPS];
    struct lanes_whole own[NEARNESS_GROUPS];
    for (int g = 0; g < groups; g++) {
        sum[g] = counts[g] = lanes_all(0.0f);
        own[g] = lanes_load_whole(f->object + p + g * INDIRECT_LANES);
    }
    for (int32_t y = -run->before; y <= run->after; y++) {
        for (int32_t x = -INDIRECT_NEAR_PX; x <= INDIRECT_NEAR_PX; x++) {
            for (int g = 0; g < groups; g++) {
                const size_t q = (size_t)((ptrdiff_t)p + y * run->step + x + g * INDIRECT_LANES);
                const struct lanes_whole object = lanes_load_whole(f->object + q);
                const struct lanes near = lanes_load(nearness + q);
                for (int v = 0; v < LANES_VECTORS; v++)
                    nearness_add(object.v[v], own[g].v[v], near.v[v], &sum[g].v[v],
                                 &counts[g].v[v]);
            }
        }
    }
    for (int g = 0; g < groups; g++) {
        for (int v = 0; v < LANES_VECTORS; v++)
            sum[g].v[v] /=
                lanes_select(counts[g].v[v] > 0.0f, counts[g].v[v], lanes_all(1.0f).v[v]);
        lanes_store(&sum[g], out + p + g * INDIRECT_LANES);
    }
}

static void kernel_nearness(const struct indirect_field *f, const struct indirect_run *run,
                            const float *nearness, float *out)
{
    const size_t end = run->first + run->count;
    size_t p = run->first;
    for (; p + NEARNESS_GROUPS * INDIRECT_LANES <= end; p += NEARNESS_GROUPS * INDIRECT_LANES)
        nearness_mean(f, run, nearness, p, NEARNESS_GROUPS, out);
    for (; p < end; p += INDIRECT_LANES) nearness_mean(f, run, nearness, p, 1, out);
}
