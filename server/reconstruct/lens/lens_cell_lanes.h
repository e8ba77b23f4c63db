#pragma once
/* The lens_kernels that turn the cells of a layer's image into planes, and find by which slopes
 * samples pass it, a vector of pixels or cells at a time. Whatever instruction set the including
 * file is compiled for, each sees the same operations in the same order. */
#include "server/reconstruct/lens/lens_kernels.h"
#include "server/reconstruct/simd/vector.h"

static void kernel_slopes(const float *slope, float low, float high, uint32_t count, float *sums,
                          float *counts)
{
    const uint32_t most = SIMD_PER_VECTOR;
    const simd_vector one = 1.0f - (simd_vector){0};
    uint32_t i = 0;
    for (; i + most <= count; i += most) {
        const simd_vector s = simd_load_vector(slope + i);
        const simd_mask own = (s >= low) & (s < high);
        *(simd_stored *)(sums + i) += simd_where(own, s);
        *(simd_stored *)(counts + i) += simd_where(own, one);
    }
    for (; i < count; i++) {
        const int own = slope[i] >= low && slope[i] < high;
        sums[i] += own ? slope[i] : 0.0f;
        counts[i] += own ? 1.0f : 0.0f;
    }
}

static void kernel_passes(const float *sums, const float *counts, float middle, int32_t fixed,
                          size_t count, float *pass)
{
    const simd_vector others = middle - (simd_vector){0};
    for (size_t i = 0; i < count; i += SIMD_PER_VECTOR) {
        const simd_vector number = simd_load_vector(counts + i);
        const simd_mask known = (number > 0.0f) & (fixed ? 0 : -1);
        *(simd_stored *)(pass + i) =
            simd_select(known, simd_load_vector(sums + i) / number, others);
    }
}

/* Transposes the sums of SIMD_LANES cells, so that those of a kind lie side by side. */
static inline void lens_turn(const float *sums, float turned[LENS_CELL_SUMS][SIMD_LANES])
{
    for (size_t i = 0; i < SIMD_LANES; i += 4)
        for (size_t k = 0; k < LENS_CELL_SUMS; k += 4) {
            const float *from = sums + LENS_CELL_SUMS * i + k;
            __m128 a = _mm_loadu_ps(from), b = _mm_loadu_ps(from + LENS_CELL_SUMS);
            __m128 c = _mm_loadu_ps(from + (size_t)2 * LENS_CELL_SUMS);
            __m128 d = _mm_loadu_ps(from + (size_t)3 * LENS_CELL_SUMS);
            _MM_TRANSPOSE4_PS(a, b, c, d);
            _mm_storeu_ps(turned[k] + i, a);
            _mm_storeu_ps(turned[k + 1] + i, b);
            _mm_storeu_ps(turned[k + 2] + i, c);
            _mm_storeu_ps(turned[k + 3] + i, d);
        }
}

/* Computes the planes of the cells from `at` on, from transposed sums from `i` on. */
static inline void lens_finish_vector(const struct lens_finish *f,
                                      float sums[LENS_CELL_SUMS][SIMD_LANES], size_t i, size_t at)
{
    const simd_vector middle = f->middle - (simd_vector){0};
    const simd_vector samples = simd_load_vector(sums[4] + i), all = simd_load_vector(sums[6] + i),
                      known = simd_load_vector(sums[7] + i);
    const simd_mask own = (known > 0.0f) & (f->fixed ? 0 : -1), any = all > 0.0f;
    const simd_vector slope = simd_select(own, simd_load_vector(sums[5] + i) / known, middle);
    const simd_vector weight = simd_where(any, 1.0f / (slope * slope)); /* slopes: 1 at least */
    const simd_vector each = simd_where(any, weight / all);
    *(simd_stored *)(f->plane[LENS_CELL_REACH] + at) = slope * f->inradius + 0.5f;
    *(simd_stored *)(f->plane[LENS_CELL_WEIGHT] + at) = weight;
    *(simd_stored *)(f->plane[LENS_CELL_SHARE] + at) = samples * each;
    for (int k = 0; k < LENS_LIGHTS; k++)
        *(simd_stored *)(f->plane[LENS_CELL_LIGHT + k] + at) = simd_load_vector(sums[k] + i) * each;
}

static void kernel_finish(const struct lens_finish *finish, size_t first, size_t count)
{
    for (size_t at = first; at < first + count; at += SIMD_LANES) {
        float sums[LENS_CELL_SUMS][SIMD_LANES];
        lens_turn(finish->sums + LENS_CELL_SUMS * at, sums);
        for (size_t i = 0; i < SIMD_LANES; i += SIMD_PER_VECTOR)
            lens_finish_vector(finish, sums, i, at + i);
    }
}
