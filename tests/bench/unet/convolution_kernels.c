#include "tests/bench/unet/convolution_kernels.h"

#include <immintrin.h>
#include <stddef.h>

#include "tests/bench/unet/tensor.h"

typedef float lanes __attribute__((vector_size(4 * CONVOLUTION_LANES), aligned(4), may_alias));

/* Pixels whose sums registers hold at once. */
#if defined __AVX512F__
#define PIXELS 14
#elif defined __FMA__
#define PIXELS 6
#else
#define PIXELS 2
#endif
_Static_assert(PIXELS <= TENSOR_SLACK_PX, "blocks of pixels may pass the row's end");

/* Computes *sum += weights v. */
static inline void add_times(const lanes *weights, float v, lanes *sum)
{
#if defined __AVX512F__
    *sum = (lanes)_mm512_fmadd_ps((__m512)*weights, _mm512_set1_ps(v), (__m512)*sum);
#elif defined __FMA__
    for (int i = 0; i < CONVOLUTION_LANES; i++)
        (*sum)[i] = __builtin_fmaf((*weights)[i], v, (*sum)[i]);
#else
    *sum += *weights * v;
#endif
}

/* The sums of PIXELS pixels from the x-th. */
static inline void add_window(const struct convolution_row *r, int32_t x, lanes sums[PIXELS])
{
    const size_t n = (size_t)r->channels;
    const float *weights = r->weights;
    for (int tap = 0; tap < 9; tap++) {
        const float *from = r->inputs[tap / 3] + (size_t)(x + tap % 3) * n;
        for (size_t c = 0; c < n; c++, weights += CONVOLUTION_LANES) {
            const lanes w = *(const lanes *)weights;
#pragma GCC unroll 16
            for (size_t p = 0; p < PIXELS; p++) add_times(&w, from[p * n + c], &sums[p]);
        }
    }
}

static void convolve_row(const struct convolution_row *r)
{
    for (int32_t x = 0; x < r->width; x += PIXELS) {
        lanes sums[PIXELS];
        for (int p = 0; p < PIXELS; p++) sums[p] = *(const lanes *)r->bias;
        add_window(r, x, sums);
        for (int32_t p = 0; p < PIXELS && x + p < r->width; p++) {
            float *to = r->output + (size_t)(x + p) * (size_t)r->stride;
            for (int i = 0; i < CONVOLUTION_LANES; i++)
                to[i] = sums[p][i] > 0.0f ? sums[p][i] : 0.0f;
        }
    }
}

const struct convolution_kernels KERNELS(convolution_kernels) = {.row = convolve_row};
