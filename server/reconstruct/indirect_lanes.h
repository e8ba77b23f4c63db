#pragma once
/* indirect_kernels, sixteen receiving pixels side by side. Plain loops over short arrays, which the
 * compiler vectorises for whatever instruction set the including file is compiled for. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/indirect_kernels.h"

#define LINE_WEIGHT_LEAST 3.0f  /* of the neighbours and the pixel itself, for a line */
#define LINE_SPREAD_LEAST 0.05f /* how far the fit is from one-sided: det / (S0 S2) */
#define LINE_FLOOR        0.25f /* of the mean */
#define NEARNESS_PX       2

/* What sixteen pixels take of their neighbours on one line. */
struct indirect_taps {
    _Alignas(64) float weight[INDIRECT_TAPS][INDIRECT_LANES];
    /* Rule B: signed distances in sqrt 2 beta, then weights times those. */
    _Alignas(64) float moment[INDIRECT_TAPS][INDIRECT_LANES];
    ptrdiff_t at[INDIRECT_TAPS]; /* of the neighbours' first */
    uint32_t count;
};

/* Weighs the taps to one side. A tap that no pixel takes is left out. */
static inline void indirect_weigh(const struct indirect_field *f, size_t p, ptrdiff_t step,
                                  int32_t reach, int moments, struct indirect_taps *taps)
{
    const float *const *x = f->point, *const *n = f->normal;
    const float sign = step < 0 ? -1.0f : 1.0f;
    _Alignas(64) int32_t walks[INDIRECT_LANES];
    for (int i = 0; i < INDIRECT_LANES; i++) walks[i] = -(f->falloff[p + (size_t)i] > 0.0f);
    for (int32_t k = 1; k <= reach; k++) {
        const size_t q = (size_t)((ptrdiff_t)p + k * step);
        float *weight = taps->weight[taps->count], *moment = taps->moment[taps->count];
        int32_t any = 0, taken = 0;
        for (size_t i = 0; i < INDIRECT_LANES; i++) {
            const size_t a = p + i, b = q + i;
            const float dx = x[0][b] - x[0][a], dy = x[1][b] - x[1][a], dz = x[2][b] - x[2][a];
            const float off = fabsf(dx * n[0][a] + dy * n[1][a] + dz * n[2][a]);
            const float alike = n[0][a] * n[0][b] + n[1][a] * n[1][b] + n[2][a] * n[2][b];
            const float exponent = (dx * dx + dy * dy + dz * dz) * f->falloff[a];
            const int32_t far = -!(exponent <= INDIRECT_CUT);
            const int32_t same = -(f->object[a] == f->object[b]);
            const int32_t fits = -(alike >= INDIRECT_COS) & -(off <= f->off[a]);
            const int32_t kept = walks[i] & ~far & fits;
            const float all = gaussian_exp_minus(exponent);
            weight[i] = kept ? all : 0.0f;
            if (moments) moment[i] = sign * sqrtf(kept ? exponent : 0.0f);
            walks[i] &= ~(far & same);
            any |= walks[i];
            taken |= kept;
        }
        taps->at[taps->count] = (ptrdiff_t)q;
        taps->count += taken != 0;
        if (!any) return;
    }
}

static inline void indirect_gather(const struct indirect_field *f, const struct indirect_run *run,
                                   size_t p, int moments, struct indirect_taps *taps)
{
    taps->count = 0;
    indirect_weigh(f, p, -run->step, run->before, moments, taps);
    indirect_weigh(f, p, run->step, run->after, moments, taps);
}

static void kernel_mean(const struct indirect_field *f, const struct indirect_run *run,
                        uint32_t count, const float *const *in, float *const *out)
{
    struct indirect_taps taps;
    for (size_t p = run->first; p < run->first + run->count; p += INDIRECT_LANES) {
        float all[INDIRECT_LANES], inverse[INDIRECT_LANES];
        indirect_gather(f, run, p, 0, &taps);
        for (size_t i = 0; i < INDIRECT_LANES; i++) all[i] = 1.0f;
        for (uint32_t t = 0; t < taps.count; t++)
            for (size_t i = 0; i < INDIRECT_LANES; i++) all[i] += taps.weight[t][i];
        for (size_t i = 0; i < INDIRECT_LANES; i++) inverse[i] = 1.0f / all[i]; /* at least 1 */
        for (uint32_t c = 0; c < count; c++) {
            const float *own = in[c] + p;
            float sum[INDIRECT_LANES] = {0};
            for (uint32_t t = 0; t < taps.count; t++) {
                const float *other = in[c] + taps.at[t];
                for (size_t i = 0; i < INDIRECT_LANES; i++)
                    sum[i] += taps.weight[t][i] * (other[i] - own[i]);
            }
            for (size_t i = 0; i < INDIRECT_LANES; i++)
                out[c][p + i] = own[i] + sum[i] * inverse[i];
        }
    }
}

/* Of each pixel: what turns sums into the line's value at it. */
struct indirect_line {
    float inverse[INDIRECT_LANES]; /* of the sum of weights */
    float first[INDIRECT_LANES], second[INDIRECT_LANES];
};

/* With r the signed distance and T0, T1 the sums of w (c - own) and w r (c - own), the line's value
 * less the own one is (S2 T0 - S1 T1) / det: of T0, `first`, and of T1, `second`. */
static inline void indirect_fit(struct indirect_taps *taps, struct indirect_line *line)
{
    float s0[INDIRECT_LANES], s1[INDIRECT_LANES] = {0}, s2[INDIRECT_LANES] = {0};
    for (size_t i = 0; i < INDIRECT_LANES; i++) s0[i] = 1.0f;
    for (uint32_t t = 0; t < taps->count; t++) {
        for (size_t i = 0; i < INDIRECT_LANES; i++) {
            const float w = taps->weight[t][i], r = taps->moment[t][i], m = w * r;
            s0[i] += w;
            s1[i] += m;
            s2[i] += m * r;
            taps->moment[t][i] = m;
        }
    }
    for (size_t i = 0; i < INDIRECT_LANES; i++) {
        const float det = s0[i] * s2[i] - s1[i] * s1[i];
        const int32_t fits =
            (s0[i] > LINE_WEIGHT_LEAST) & (det > LINE_SPREAD_LEAST * s0[i] * s2[i]);
        line->inverse[i] = 1.0f / s0[i];
        line->first[i] = fits ? s2[i] / det : line->inverse[i];
        line->second[i] = fits ? s1[i] / det : 0.0f;
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
        for (uint32_t c = 0; c < count; c++) {
            const float *own = in[c] + p;
            float sum[INDIRECT_LANES] = {0}, moment[INDIRECT_LANES] = {0};
            for (uint32_t t = 0; t < taps.count; t++) {
                const float *other = in[c] + taps.at[t];
                for (size_t i = 0; i < INDIRECT_LANES; i++) {
                    const float more = other[i] - own[i];
                    sum[i] += taps.weight[t][i] * more;
                    moment[i] += taps.moment[t][i] * more;
                }
            }
            for (size_t i = 0; i < INDIRECT_LANES; i++) {
                const float mean = own[i] + sum[i] * line.inverse[i];
                const float at = own[i] + (line.first[i] * sum[i] - line.second[i] * moment[i]);
                const float least = LINE_FLOOR * mean;
                out[c][p + i] = at > least ? at : least;
            }
        }
    }
}

static void kernel_nearness(const struct indirect_field *f, const struct indirect_run *run,
                            const float *nearness, float *out)
{
    for (size_t p = run->first; p < run->first + run->count; p += INDIRECT_LANES) {
        float sum[INDIRECT_LANES] = {0}, counts[INDIRECT_LANES] = {0};
        for (int32_t v = -run->before; v <= run->after; v++) {
            for (int32_t u = -NEARNESS_PX; u <= NEARNESS_PX; u++) {
                const size_t q = (size_t)((ptrdiff_t)p + v * run->step + u);
                for (size_t i = 0; i < INDIRECT_LANES; i++) {
                    const float near = nearness[q + i];
                    const int32_t met = (f->object[q + i] == f->object[p + i]) & (near > 0.0f);
                    sum[i] += met ? near : 0.0f;
                    counts[i] += met ? 1.0f : 0.0f;
                }
            }
        }
        for (size_t i = 0; i < INDIRECT_LANES; i++)
            out[p + i] = counts[i] > 0.0f ? sum[i] / counts[i] : 0.0f;
    }
}
