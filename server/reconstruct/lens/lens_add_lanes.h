#pragma once
/* The lens_kernels that add samples to the cells of a layer's image, a vector of pixels at a time.
 * Whatever instruction set the including file is compiled for, each cell sees the same operations
 * in the same order. */
#include <string.h>

#include "server/reconstruct/lens/lens_cell_lanes.h"
#include "server/reconstruct/lens/lens_kernels.h"
#include "server/reconstruct/simd/vector.h"

/* Returns the greatest whole numbers not above x, which are small. */
static inline simd_mask lens_floor(simd_vector x)
{
#ifdef __AVX512F__
    return (simd_mask)_mm512_cvttps_epi32(_mm512_floor_ps((__m512)x));
#elif defined __AVX__
    return (simd_mask)_mm256_cvttps_epi32(_mm256_floor_ps((__m256)x));
#else
    return (simd_mask)_mm_cvttps_epi32(_mm_floor_ps((__m128)x));
#endif
}

/* Returns where samples lie on the lens along rows. */
static inline simd_vector lens_along(const float *along, const float *left, const float *chord,
                                     float stratum, float strata_inverse)
{
    return simd_load_vector(left) +
           simd_load_vector(chord) * ((stratum + simd_load_vector(along)) * strata_inverse);
}

/* Returns the columns of the pixels of a vector of samples. */
static inline simd_mask lens_columns(int32_t first)
{
    static const int32_t steps[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    return simd_load_mask(steps) + first;
}

/* Returns the mask of numbers from 0 below `end`. */
static inline simd_mask lens_within(simd_mask numbers, int32_t end)
{
    typedef uint32_t whole __attribute__((vector_size(SIMD_VECTOR_BYTES)));
    return (simd_mask)((whole)numbers < (uint32_t)end);
}

/* The pixels of a vector: where they lie in their cells, in pixels, and the columns of these. */
struct lens_pixels {
    simd_vector phase;
    simd_mask column;
};

static inline struct lens_pixels lens_pixels_at(const struct lens_splat *p, uint32_t i)
{
    const simd_mask pixel = lens_columns(p->x + (int32_t)i), phase = pixel & ((1 << p->coarse) - 1);
    return (struct lens_pixels){.phase = __builtin_convertvector(phase, simd_vector) + 0.5f,
                                .column = (pixel >> p->coarse << p->fine) - p->column};
}

/* Returns the slopes by which samples are moved. */
static inline simd_vector lens_moves(const struct lens_splat *p, uint32_t i, simd_vector s,
                                     int beyond)
{
    if (p->fixed) return simd_load_vector(p->pass + i);
    return beyond ? simd_select(s >= p->close, s, simd_load_vector(p->pass + i)) : s;
}

/* Computes where samples from i on lie, in bytes from the first cell's sums. Those of the layer lie
 * where their slope takes them. Others, and those without `wanted`, lie in spare cells. Returns
 * whether any lies in the layer. */
static inline int lens_splat_vector(const struct lens_splat *p, uint32_t i,
                                    const struct lens_pixels *pixels, simd_mask wanted,
                                    simd_mask *at, int beyond)
{
    const simd_vector s = simd_load_vector(p->slope + i);
    const simd_mask near = s >= p->low, taken = beyond ? ~near : near & (s < p->high);
    if (!simd_signs(taken)) return 0;
    const simd_vector slope = lens_moves(p, i, s, beyond);
    const simd_vector u =
        lens_along(p->along + i, p->left + i, p->chord + i, p->stratum, p->strata_inverse);
    const simd_vector x = p->cells * (pixels->phase + slope * u);
    const simd_vector y =
        p->cells * (p->row_phase + 0.5f + slope * simd_load_vector(p->height + i));
    const simd_mask column = pixels->column + lens_floor(x), row = lens_floor(y) - p->row;
    simd_mask cell = row * p->stride + (column >> p->fine);
    if (p->fine) cell += (column & ((1 << p->fine) - 1)) * p->phase_step;
    const simd_mask in =
        taken & wanted & lens_within(column, p->columns) & lens_within(row, p->rows);
    cell = (in & cell) | (~in & lens_columns(p->spare));
    *at = cell * (LENS_CELL_SUMS * (int32_t)sizeof(float));
    return simd_signs(in) != 0;
}

/* What eight samples, or four, add to the sums of their cells, with numbers of two kinds side by
 * side. */
#ifdef __AVX__
#define LENS_QUADS 8
typedef __m256 lens_quads;
typedef int32_t lens_quad_mask __attribute__((vector_size(32)));
#else
#define LENS_QUADS 4
typedef __m128 lens_quads;
typedef int32_t lens_quad_mask __attribute__((vector_size(16)));
#endif

static inline lens_quads lens_quads_load(const float *from)
{
#ifdef __AVX__
    return _mm256_loadu_ps(from);
#else
    return _mm_loadu_ps(from);
#endif
}

/* Transposes four numbers of each sample, which lie side by side by their kinds. out[k] has those
 * of sample k, and of sample k + 4 in its upper half. */
static inline void lens_quads_turn(lens_quads a, lens_quads b, lens_quads c, lens_quads d,
                                   lens_quads out[4])
{
#ifdef __AVX__
    const __m256d ab = (__m256d)_mm256_unpacklo_ps(a, b), cd = (__m256d)_mm256_unpacklo_ps(c, d);
    const __m256d high = (__m256d)_mm256_unpackhi_ps(a, b);
    const __m256d more = (__m256d)_mm256_unpackhi_ps(c, d);
    out[0] = (__m256)_mm256_unpacklo_pd(ab, cd);
    out[1] = (__m256)_mm256_unpackhi_pd(ab, cd);
    out[2] = (__m256)_mm256_unpacklo_pd(high, more);
    out[3] = (__m256)_mm256_unpackhi_pd(high, more);
#else
    _MM_TRANSPOSE4_PS(a, b, c, d);
    out[0] = a, out[1] = b, out[2] = c, out[3] = d;
#endif
}

/* Returns the lower half, or the upper one. */
static inline __m128 lens_quad_of(lens_quads quads, int upper)
{
#ifdef __AVX__
    return upper ? _mm256_extractf128_ps(quads, 1) : _mm256_castps256_ps128(quads);
#else
    (void)upper;
    return quads;
#endif
}

static inline void lens_add_quad(float *to, __m128 quad)
{
    _mm_storeu_ps(to, _mm_loadu_ps(to) + quad);
}

/* All sums of a cell. */
struct lens_record {
#ifdef __AVX__
    __m256 all;
#else
    __m128 light, others;
#endif
};

static inline void lens_records(const lens_quads light[4], const lens_quads others[4],
                                struct lens_record out[LENS_QUADS])
{
    for (int k = 0; k < 4; k++) {
#ifdef __AVX__
        out[k].all = _mm256_permute2f128_ps(light[k], others[k], 0x20);
        out[k + 4].all = _mm256_permute2f128_ps(light[k], others[k], 0x31);
#else
        out[k] = (struct lens_record){light[k], others[k]};
#endif
    }
}

/* Returns the sums that lie `at` bytes from the first cell's. */
static inline float *lens_sums_at(float *sums, uint32_t at)
{
    return (float *)(void *)((char *)sums + at);
}

static inline void lens_add_record(float *sums, uint32_t at, struct lens_record record)
{
    float *to = lens_sums_at(sums, at);
#ifdef __AVX__
    _mm256_storeu_ps(to, _mm256_loadu_ps(to) + record.all);
#else
    lens_add_quad(to, record.light);
    lens_add_quad(to + 4, record.others);
#endif
}

/* Adds samples of the layer from i on to the sums of their cells, in their order. */
static inline void lens_add_own(const struct lens_splat *p, uint32_t i, const uint32_t *at,
                                float *sums)
{
    const lens_quads one = 1.0f - (lens_quads){0};
    const lens_quads sign = -0.0f - (lens_quads){0}, slope = lens_quads_load(p->slope + i);
    const lens_quads r = lens_quads_load(p->light[0] + i), g = lens_quads_load(p->light[1] + i);
    const lens_quads b = lens_quads_load(p->light[2] + i);
    const lens_quads size = (lens_quads)(~(lens_quad_mask)sign & (lens_quad_mask)slope);
    lens_quads light[4], others[4];
    struct lens_record records[LENS_QUADS];
    lens_quads_turn(r, g, b, r * r + g * g + b * b, light);
    lens_quads_turn(one, size, one, one, others);
    lens_records(light, others, records);
    for (uint32_t k = 0; k < LENS_QUADS; k++) lens_add_record(sums, at[k], records[k]);
}

/* Adds samples that pass the layer, by slopes that are known where others of the pixel lie in it.
 */
static inline void lens_add_passing(const struct lens_splat *p, uint32_t i, const uint32_t *at,
                                    float *sums)
{
    const lens_quads zero = {0}, one = 1.0f - zero, known = lens_quads_load(p->known + i);
    const lens_quad_mask is_known = known > 0.0f, positive = INT32_MAX - (lens_quad_mask){0};
    const lens_quads pass = lens_quads_load(p->pass + i);
    const lens_quads size = (lens_quads)(is_known & positive & (lens_quad_mask)pass);
    const lens_quads share = (lens_quads)(is_known & (lens_quad_mask)one);
    lens_quads turned[4];
    lens_quads_turn(zero, size, one, share, turned);
    for (int k = 0; k < 4; k++)
        lens_add_quad(lens_sums_at(sums, at[k]) + 4, lens_quad_of(turned[k], 0));
    for (int k = 4; k < LENS_QUADS; k++)
        lens_add_quad(lens_sums_at(sums, at[k]) + 4, lens_quad_of(turned[k - 4], 1));
}

/* Adds a vector of samples from i on. */
static inline void lens_add_vector(const struct lens_splat *p, uint32_t i, simd_mask at,
                                   float *sums, int beyond)
{
    uint32_t all[SIMD_PER_VECTOR];
    *(simd_stored_mask *)(void *)all = at;
    for (uint32_t k = 0; k < SIMD_PER_VECTOR; k += LENS_QUADS)
        if (beyond)
            lens_add_passing(p, i + k, all + k, sums);
        else
            lens_add_own(p, i + k, all + k, sums);
}

#define LENS_PLACE_ARRAYS 10

/* Adds fewer samples than a vector has. */
static inline void lens_add_few(const struct lens_splat *p, uint32_t count, float *sums, int beyond)
{
    float memory[LENS_PLACE_ARRAYS][SIMD_PER_VECTOR] = {{0}};
    simd_mask cell = {0};
    struct lens_splat few = *p;
    const struct lens_pixels pixels = lens_pixels_at(p, 0);
    const float **const arrays[LENS_PLACE_ARRAYS] = {
        &few.slope, &few.along, &few.left,     &few.chord,    &few.height,
        &few.pass,  &few.known, &few.light[0], &few.light[1], &few.light[2]};
    for (int k = 0; k < LENS_PLACE_ARRAYS; k++) {
        memcpy(memory[k], *arrays[k], count * sizeof(float));
        *arrays[k] = memory[k];
    }
    const simd_mask wanted = lens_columns(-(int32_t)count) < 0;
    if (lens_splat_vector(&few, 0, &pixels, wanted, &cell, beyond))
        lens_add_vector(&few, 0, cell, sums, beyond);
}

static inline void lens_fetch(const struct lens_splat *p, uint32_t i, int beyond)
{
    __builtin_prefetch(p->slope + i + p->next);
    for (int k = 0; k < 3 && !beyond; k++) __builtin_prefetch(p->light[k] + i + p->next);
}

/* Adds a row of samples. The last vector may begin among the samples of the one before. Cells are
 * at most four pixels wide, so vectors begin at the same place in them. */
static inline void lens_add_row(const struct lens_splat *splat, uint32_t count, float *sums,
                                int beyond)
{
    const struct lens_splat p = *splat;
    const uint32_t most = SIMD_PER_VECTOR, last = count - most;
    const simd_mask all = (simd_mask){0} - 1;
    struct lens_pixels pixels = lens_pixels_at(&p, 0);
    for (uint32_t i = 0; i <= last; i += most) {
        simd_mask cell = {0};
        if (i % SIMD_LANES == 0) lens_fetch(&p, i, beyond);
        if (lens_splat_vector(&p, i, &pixels, all, &cell, beyond))
            lens_add_vector(&p, i, cell, sums, beyond);
        pixels.column += (int32_t)most >> p.coarse << p.fine;
    }
    if (count % most == 0) return;
    simd_mask cell = {0};
    pixels = lens_pixels_at(&p, last);
    const simd_mask wanted = lens_columns((int32_t)(count % most) - (int32_t)most) >= 0;
    if (lens_splat_vector(&p, last, &pixels, wanted, &cell, beyond))
        lens_add_vector(&p, last, cell, sums, beyond);
}

static void kernel_add(const struct lens_splat *splat, uint32_t count, float *sums)
{
    if (count < SIMD_PER_VECTOR)
        lens_add_few(splat, count, sums, splat->beyond != 0);
    else if (splat->beyond)
        lens_add_row(splat, count, sums, 1);
    else
        lens_add_row(splat, count, sums, 0);
}
