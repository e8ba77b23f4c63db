#pragma once
/* The weights that sixteen adjacent receivers give to their neighbours on one line, and weighted
 * means. Channels are summed together where possible, so that each tap's weights are loaded once
 * and sums of several channels do not wait for each other. */
#include <stddef.h>

#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/vector.h"

#define TAPS_MAX      128
#define TAPS_CHANNELS 4 /* that go together, at most */

struct taps {
    _Alignas(64) float weight[TAPS_MAX][SIMD_LANES];
    ptrdiff_t at[TAPS_MAX]; /* of the neighbours' first */
    uint32_t count;
};

static inline void taps_add(struct taps *taps, size_t at, const struct simd *weight)
{
    simd_store(weight, taps->weight[taps->count]);
    taps->at[taps->count++] = (ptrdiff_t)at;
}

/* Sums vector v of `channels` channels: weights times differences from the receiver's own value,
 * and the weights, with that of the receiver itself, which is 1. */
SIMD_INLINE void taps_sum(const struct taps *taps, const float *const *in, size_t p, int v,
                          uint32_t channels, simd_vector own[TAPS_CHANNELS],
                          simd_vector sum[TAPS_CHANNELS], simd_vector *weights)
{
    const size_t aside = (size_t)v * SIMD_PER_VECTOR;
    *weights = simd_same(1.0f);
    for (uint32_t c = 0; c < channels; c++) {
        own[c] = simd_load_vector(in[c] + p + aside);
        sum[c] = (simd_vector){0};
    }
    for (uint32_t t = 0; t < taps->count; t++) {
        const simd_vector weight = simd_load_vector(taps->weight[t] + aside);
        const size_t from = (size_t)taps->at[t] + aside;
        *weights += weight;
        for (uint32_t c = 0; c < channels; c++)
            sum[c] = simd_fused(weight, simd_load_vector(in[c] + from) - own[c], sum[c]);
    }
}

SIMD_INLINE void taps_mean_of(const struct taps *taps, const float *const *in, size_t p,
                              uint32_t channels, float *const *out)
{
    for (int v = 0; v < SIMD_VECTORS; v++) {
        simd_vector own[TAPS_CHANNELS], sum[TAPS_CHANNELS], weights;
        taps_sum(taps, in, p, v, channels, own, sum, &weights);
        const simd_vector inverse = 1.0f / weights;
        for (uint32_t c = 0; c < channels; c++)
            *(simd_stored *)(out[c] + p + (size_t)v * SIMD_PER_VECTOR) =
                simd_fused(sum[c], inverse, own[c]);
    }
}

/* Computes means of in[c] for sixteen pixels from p on into out[c]; no array is both. Sums run over
 * differences from the receiver's own value, so that a constant channel stays constant to the last
 * bit. */
static inline void taps_mean(const struct taps *taps, uint32_t count, const float *const *in,
                             size_t p, float *const *out)
{
    uint32_t c = 0;
    for (; c + TAPS_CHANNELS <= count; c += TAPS_CHANNELS)
        taps_mean_of(taps, in + c, p, TAPS_CHANNELS, out + c);
    if (c + 3 <= count) {
        taps_mean_of(taps, in + c, p, 3, out + c);
        c += 3;
    }
    for (; c < count; c++) taps_mean_of(taps, in + c, p, 1, out + c);
}
