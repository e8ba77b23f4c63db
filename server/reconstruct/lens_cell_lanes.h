#pragma once
/* lens_kernels that fill the cells of a layer's image, vectors of pixels or cells side by side:
 * whatever instruction set the including file is compiled for, each sees the same operations in the
 * same order. */
#include <string.h>

#include "server/reconstruct/indirect_vector.h"
#include "server/reconstruct/lens_kernels.h"

/* The greatest whole numbers not above x, which are small. */
static inline lanes_mask lens_floor(lanes_vector x)
{
    const lanes_mask whole = __builtin_convertvector(x, lanes_mask);
    return whole + (__builtin_convertvector(whole, lanes_vector) > x);
}

/* Whose samples a vector of them are: columns of their pixels. */
static inline lanes_mask lens_columns(int32_t first)
{
    static const int32_t steps[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    return lanes_load_mask(steps) + first;
}

/* A mask of the last `count` digits. */
static inline lanes_mask lens_digits(int32_t count)
{
    const int32_t digits = (1 << count) - 1;
    return (lanes_mask){0} + digits;
}

/* A bit for each lane whose sign is set, the first lane's lowest. */
static inline uint32_t lens_signs(lanes_mask mask)
{
#ifdef __AVX512F__
    return (uint32_t)_mm512_movepi32_mask((__m512i)mask);
#elif defined __AVX__
    return (uint32_t)_mm256_movemask_ps((__m256)mask);
#else
    return (uint32_t)_mm_movemask_ps((__m128)mask);
#endif
}

/* Where samples i on lie, and which of them do: those of the layer where their slope takes them. */
static inline uint32_t lens_place_vector(const struct lens_place *p, uint32_t i, lanes_mask *cell)
{
    const lanes_vector s = lanes_load_vector(p->slope + i);
    const lanes_mask near = s >= p->low, own = near & (s < p->high);
    const lanes_mask taken = p->beyond ? ~near : own;
    if (!lens_signs(taken)) return 0;
    const lanes_mask moves = (s >= p->close) & (s < p->high) & (p->fixed ? 0 : -1);
    const lanes_vector slope = lanes_select(moves, s, lanes_load_vector(p->pass + i));
    const lanes_vector u = lanes_load_vector(p->left + i) +
                           lanes_load_vector(p->chord + i) *
                               ((p->stratum + lanes_load_vector(p->along + i)) * p->strata_inverse);
    const lanes_mask pixel = lens_columns(p->x + (int32_t)i),
                     phase = pixel & lens_digits(p->coarse);
    const lanes_vector x =
        p->cells * (__builtin_convertvector(phase, lanes_vector) + 0.5f + slope * u);
    const lanes_vector y =
        p->cells * (p->row_phase + 0.5f + slope * lanes_load_vector(p->height + i));
    const lanes_mask column = (pixel >> p->coarse << p->fine) + lens_floor(x) - p->column;
    const lanes_mask row = lens_floor(y) - p->row;
    const lanes_mask inside = (column >= 0) & (column < p->columns) & (row >= 0) & (row < p->rows);
    *cell = row * p->stride + (column & lens_digits(p->fine)) * p->phase_step + (column >> p->fine);
    return lens_signs(taken & inside);
}

/* Adds four numbers to four of a cell's sums. */
static inline void lens_add_quad(float *to, __m128 quad)
{
    _mm_store_ps(to, _mm_load_ps(to) + quad);
}

/* Samples i .. i + 3 of the layer to the sums of their cells: those whose bits are set. */
static inline void lens_add_own(const struct lens_place *p, uint32_t i, uint32_t bits,
                                const int32_t cell[4], float *sums)
{
    const __m128 one = _mm_set1_ps(1.0f), sign = _mm_set1_ps(-0.0f);
    const __m128 size = _mm_andnot_ps(sign, _mm_loadu_ps(p->slope + i));
    __m128 r = _mm_loadu_ps(p->light[0] + i), g = _mm_loadu_ps(p->light[1] + i);
    __m128 b = _mm_loadu_ps(p->light[2] + i), square = r * r + g * g + b * b;
    const __m128 low = _mm_unpacklo_ps(one, size), high = _mm_unpackhi_ps(one, size);
    _MM_TRANSPOSE4_PS(r, g, b, square);
    const __m128 light[4] = {r, g, b, square};
    const __m128 others[4] = {_mm_movelh_ps(low, one), _mm_shuffle_ps(low, one, 0x0e),
                              _mm_movelh_ps(high, one), _mm_shuffle_ps(high, one, 0x0e)};
    for (uint32_t k = 0; k < 4; k++) {
        if (!(bits >> k & 1u)) continue;
        float *to = sums + (size_t)LENS_CELL_SUMS * (size_t)cell[k];
        lens_add_quad(to, light[k]);
        lens_add_quad(to + 4, others[k]);
    }
}

/* The same of samples that pass the layer: by slopes that are known where others of the pixel lie
 * in it. */
static inline void lens_add_passing(const struct lens_place *p, uint32_t i, uint32_t bits,
                                    const int32_t cell[4], float *sums)
{
    const __m128 one = _mm_set1_ps(1.0f), sign = _mm_set1_ps(-0.0f);
    const __m128 known = _mm_cmpgt_ps(_mm_loadu_ps(p->known + i), _mm_setzero_ps());
    const __m128 size = _mm_and_ps(known, _mm_andnot_ps(sign, _mm_loadu_ps(p->pass + i)));
    const __m128 share = _mm_and_ps(known, one), zero = _mm_setzero_ps();
    const __m128 low = _mm_unpacklo_ps(zero, size), high = _mm_unpackhi_ps(zero, size);
    const __m128 low_share = _mm_unpacklo_ps(one, share), high_share = _mm_unpackhi_ps(one, share);
    const __m128 others[4] = {_mm_movelh_ps(low, low_share), _mm_movehl_ps(low_share, low),
                              _mm_movelh_ps(high, high_share), _mm_movehl_ps(high_share, high)};
    for (uint32_t k = 0; k < 4; k++)
        if (bits >> k & 1u)
            lens_add_quad(sums + (size_t)LENS_CELL_SUMS * (size_t)cell[k] + 4, others[k]);
}

/* Those of a vector, from sample i on, whose bits are set. */
static inline void lens_add_vector(const struct lens_place *p, uint32_t i, uint32_t bits,
                                   lanes_mask cell, float *sums)
{
    int32_t cells[LANES_PER_VECTOR];
    *(lanes_stored_mask *)cells = cell;
    for (uint32_t k = 0; k < LANES_PER_VECTOR; k += 4) {
        const uint32_t four = bits >> k & 15u;
        if (four && p->beyond) lens_add_passing(p, i + k, four, cells + k, sums);
        if (four && !p->beyond) lens_add_own(p, i + k, four, cells + k, sums);
    }
}

#define LENS_PLACE_ARRAYS 10

/* Fewer samples than a vector has. */
static inline void lens_add_few(const struct lens_place *p, uint32_t count, float *sums)
{
    float memory[LENS_PLACE_ARRAYS][LANES_PER_VECTOR] = {{0}};
    lanes_mask cell = {0};
    struct lens_place few = *p;
    const float **const arrays[LENS_PLACE_ARRAYS] = {
        &few.slope, &few.along, &few.left,     &few.chord,    &few.height,
        &few.pass,  &few.known, &few.light[0], &few.light[1], &few.light[2]};
    for (int k = 0; k < LENS_PLACE_ARRAYS; k++) {
        memcpy(memory[k], *arrays[k], count * sizeof(float));
        *arrays[k] = memory[k];
    }
    const uint32_t bits = lens_place_vector(&few, 0, &cell) & ((1u << count) - 1);
    lens_add_vector(&few, 0, bits, cell, sums);
}

/* The last vector may begin among the samples of the one before. */
static void kernel_add(const struct lens_place *place, uint32_t count, float *sums)
{
    const struct lens_place p = *place;
    const uint32_t most = LANES_PER_VECTOR;
    if (count < most) {
        lens_add_few(&p, count, sums);
        return;
    }
    for (uint32_t i = 0; i < count; i += most) {
        const uint32_t at = i + most > count ? count - most : i;
        lanes_mask cell = {0};
        __builtin_prefetch(p.slope + at + p.next);
        if (!p.beyond)
            for (int k = 0; k < 3; k++) __builtin_prefetch(p.light[k] + at + p.next);
        const uint32_t bits = lens_place_vector(&p, at, &cell) & ~0u << (i - at);
        if (bits) lens_add_vector(&p, at, bits, cell, sums);
    }
}

static void kernel_slopes(const float *slope, float low, float high, uint32_t count, float *sums,
                          float *counts)
{
    const uint32_t most = LANES_PER_VECTOR;
    const lanes_vector one = 1.0f - (lanes_vector){0};
    uint32_t i = 0;
    for (; i + most <= count; i += most) {
        const lanes_vector s = lanes_load_vector(slope + i);
        const lanes_mask own = (s >= low) & (s < high);
        *(lanes_stored *)(sums + i) += lanes_where(own, s);
        *(lanes_stored *)(counts + i) += lanes_where(own, one);
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
    const lanes_vector others = middle - (lanes_vector){0};
    for (size_t i = 0; i < count; i += LANES_PER_VECTOR) {
        const lanes_vector number = lanes_load_vector(counts + i);
        const lanes_mask known = (number > 0.0f) & (fixed ? 0 : -1);
        *(lanes_stored *)(pass + i) =
            lanes_select(known, lanes_load_vector(sums + i) / number, others);
    }
}

/* The sums of LENS_LANES cells, each of a kind side by side. */
static inline void lens_turn(const float *sums, float turned[LENS_CELL_SUMS][LENS_LANES])
{
    for (size_t i = 0; i < LENS_LANES; i += 4)
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

/* Cells `at` on of the planes from sums that are side by side from `i` on. */
static inline void lens_finish_vector(const struct lens_finish *f,
                                      float sums[LENS_CELL_SUMS][LENS_LANES], size_t i, size_t at)
{
    const lanes_vector middle = f->middle - (lanes_vector){0};
    const lanes_vector samples = lanes_load_vector(sums[4] + i),
                       all = lanes_load_vector(sums[6] + i), known = lanes_load_vector(sums[7] + i);
    const lanes_mask own = (known > 0.0f) & (f->fixed ? 0 : -1), any = all > 0.0f;
    const lanes_vector slope = lanes_select(own, lanes_load_vector(sums[5] + i) / known, middle);
    const lanes_vector weight = lanes_where(any, 1.0f / (slope * slope)); /* slopes: 1 at least */
    const lanes_vector each = lanes_where(any, weight / all);
    *(lanes_stored *)(f->plane[LENS_CELL_REACH] + at) = slope * f->inradius + 0.5f;
    *(lanes_stored *)(f->plane[LENS_CELL_WEIGHT] + at) = weight;
    *(lanes_stored *)(f->plane[LENS_CELL_SHARE] + at) = samples * each;
    for (int k = 0; k < LENS_LIGHTS; k++)
        *(lanes_stored *)(f->plane[LENS_CELL_LIGHT + k] + at) =
            lanes_load_vector(sums[k] + i) * each;
}

static void kernel_finish(const struct lens_finish *finish, size_t first, size_t count)
{
    for (size_t at = first; at < first + count; at += LENS_LANES) {
        float sums[LENS_CELL_SUMS][LENS_LANES];
        lens_turn(finish->sums + LENS_CELL_SUMS * at, sums);
        for (size_t i = 0; i < LENS_LANES; i += LANES_PER_VECTOR)
            lens_finish_vector(finish, sums, i, at + i);
    }
}
