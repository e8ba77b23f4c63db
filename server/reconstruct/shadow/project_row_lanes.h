#pragma once
/* Pass 2a of shadow_kernels, the projection along rows. A node's sum runs over the cells in order,
 * so that it stays in a register. */
#include <string.h>

#include "server/reconstruct/shadow/project_lanes.h"
#include "server/reconstruct/shadow/shadow_lanes.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/vector.h"

#define PROJECT_CHUNK   16 /* nodes whose sums stay in registers */
#define PROJECT_VECTORS (2 * PROJECT_CHUNK / SIMD_PER_VECTOR)
#define PROJECT_PAD     (SHADOW_STRATA_MAX + 2) /* nodes before weights that are 0 */
#define PROJECT_EVEN    0.75f /* how far a cell's sample lies before its first node */
#define PROJECT_ODD     0.25f
#define PROJECT_PADDED  (PROJECT_PAD + 2 * SHADOW_STRATA_MAX)

/* A pixel's weights for cells of one parity. That of node n stands twice, at 2 (PROJECT_PAD + n).
 */
struct project_padded {
    _Alignas(64) float of[2 * PROJECT_PADDED];
};

/* Weighs as project_weigh does, at the phase itself. `y` is that of the nodes. */
static inline void project_pad(const struct project_row *row, uint32_t window, float g,
                               struct project_padded *out)
{
    const float *from = row->weights + (uint32_t)(g * SHADOW_PHASES) * window;
    float *to = out->of + (size_t)2 * PROJECT_PAD;
    const fused_four none = {0}, slope = row->slope - none;
    const fused_four own = fused(row->slope, g, row->base) - none;
    fused_four nodes = {0, 1, 2, 3};
    for (uint32_t j = 0; j < window; j += 4, nodes += 4.0f) {
        const shadow_four w = *(const fused_four *)(from + j) * fused_4(slope, nodes, own);
        shadow_four *twice = (shadow_four *)(to + (size_t)2 * j);
        twice[0] = __builtin_shufflevector(w, w, 0, 0, 1, 1);
        twice[1] = __builtin_shufflevector(w, w, 2, 2, 3, 3);
    }
}

/* Returns a cell's two numbers, repeated. */
static inline simd_vector project_pair(const float *pair)
{
    typedef int64_t pairs __attribute__((vector_size(SIMD_VECTOR_BYTES)));
    int64_t both;
    memcpy(&both, pair, sizeof both);
    return (simd_vector)(both + (pairs){0});
}

/* Returns whether a cell has weight at any node of vector v, from `first` on. It is always true
 * where the answer is not a compile-time constant: a test costs more than adding zeros. */
SIMD_INLINE bool project_reaches(uint32_t scale, uint32_t cell, uint32_t first, uint32_t v)
{
    const uint32_t low = first + v * (SIMD_PER_VECTOR / 2), end = low + SIMD_PER_VECTOR / 2;
    if (!__builtin_constant_p(end > cell + 1 && low <= cell + scale)) return true;
    return end > cell + 1 && low <= cell + scale;
}

SIMD_INLINE void project_cells(uint32_t scale, const struct project_padded *even,
                               const struct project_padded *odd, const float *cells, uint32_t first,
                               simd_vector sums[PROJECT_VECTORS])
{
    for (int v = 0; v < PROJECT_VECTORS; v++) sums[v] = (simd_vector){0};
#pragma GCC unroll 8
    for (uint32_t c = 0; c < scale; c++) {
        const size_t at = 2 * (size_t)(PROJECT_PAD + first - 1 - c);
        const simd_vector a = project_pair(cells + (size_t)4 * c);
        const simd_vector b = project_pair(cells + (size_t)4 * c + 2);
        for (int v = 0; v < PROJECT_VECTORS; v++)
            if (project_reaches(scale, c, first, (uint32_t)v))
                sums[v] =
                    simd_fused(simd_load_vector(even->of + at + v * SIMD_PER_VECTOR), a, sums[v]);
        for (int v = 0; v < PROJECT_VECTORS; v++)
            if (project_reaches(scale, c, first, (uint32_t)v))
                sums[v] =
                    simd_fused(simd_load_vector(odd->of + at + v * SIMD_PER_VECTOR), b, sums[v]);
    }
}

/* Stores a pixel's nodes from `first` on, of `used`. */
static inline void project_store_rows(const simd_vector sums[PROJECT_VECTORS], uint32_t first,
                                      uint32_t used, float *rows)
{
    for (uint32_t v = 0; v < PROJECT_VECTORS; v++) {
        const uint32_t at = 2 * first + v * SIMD_PER_VECTOR, end = 2 * used;
        if (at + SIMD_PER_VECTOR <= end)
            *(simd_stored *)(rows + at) = sums[v];
        else if (at < end)
            memcpy(rows + at, &sums[v], (end - at) * sizeof *rows);
    }
}

SIMD_INLINE void project_rows(const struct shadow_field *f, uint32_t scale, const uint32_t *pixels,
                              uint32_t count, const float *cells)
{
    const uint32_t used = 2 * scale, window = (scale + 7) / 8 * 8; /* no weight reaches the rest */
    struct project_padded even[PROJECT_GROUP] = {0}, odd[PROJECT_GROUP] = {0};
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t own = k % PROJECT_GROUP, left = count - k;
        for (uint32_t i = 0; own == 0 && i < PROJECT_GROUP && i < left; i++) {
            const struct project_row row = project_row_of(f, 1, pixels[k + i]);
            project_pad(&row, window, PROJECT_EVEN, &even[i]);
            project_pad(&row, window, PROJECT_ODD, &odd[i]);
        }
        float *rows = f->rows + (size_t)f->pixels->slot[pixels[k]] * 2 * (used + 2);
        for (uint32_t n = 0; n < used; n += PROJECT_CHUNK) {
            simd_vector sums[PROJECT_VECTORS];
            project_cells(scale, &even[own], &odd[own], cells + (size_t)k * 4 * scale, n, sums);
            project_store_rows(sums, n, used, rows);
        }
        memset(rows + (size_t)used * 2, 0, 4 * sizeof *rows);
    }
}

#define PROJECT_CELL_NODES 8 /* that a cell of nine samples weighs */

#ifdef __AVX512F__
/* Where a cell has weight at eight nodes, a pixel's nodes fill two registers and weights one.
 * Shifting a register is faster than loading across two cache lines. */

/* The number of pixels that take turns, because the steps of one sum wait for each other. */
#define PROJECT_TURNS 4

/* Returns the weights of project_pad, each twice. */
SIMD_INLINE __m512i project_twice(const struct project_row *row, float g)
{
    const fused_eight nodes = {0, 1, 2, 3, 4, 5, 6, 7}, none = {0}, slope = row->slope - none;
    const uint32_t phase = (uint32_t)(g * SHADOW_PHASES);
    fused_eight bend = fused(row->slope, g, row->base) - none;
    fused_add_8(&slope, &nodes, &bend);
    const fused_eight w = *(const fused_eight *)(row->weights + phase * PROJECT_CELL_NODES) * bend;
    const __m512i order = _mm512_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7);
    return _mm512_permutexvar_epi32(order, _mm512_castps_si512(_mm512_castps256_ps512((__m256)w)));
}

/* Returns eight of sixteen pairs, from pair n < 8 on. The instruction contains n, so loops over it
 * are unrolled. */
SIMD_INLINE simd_vector project_shift(__m512i low, __m512i high, int n)
{
    switch (n) {
    case 0:
        return (simd_vector)low;
    case 1:
        return (simd_vector)_mm512_alignr_epi64(high, low, 1);
    case 2:
        return (simd_vector)_mm512_alignr_epi64(high, low, 2);
    case 3:
        return (simd_vector)_mm512_alignr_epi64(high, low, 3);
    case 4:
        return (simd_vector)_mm512_alignr_epi64(high, low, 4);
    case 5:
        return (simd_vector)_mm512_alignr_epi64(high, low, 5);
    case 6:
        return (simd_vector)_mm512_alignr_epi64(high, low, 6);
    default:
        return (simd_vector)_mm512_alignr_epi64(high, low, 7);
    }
}

/* Adds two numbers of cell c to a pixel's nodes. */
SIMD_INLINE void project_shifted(int c, __m512i weights, simd_vector two,
                                 simd_vector sums[PROJECT_VECTORS])
{
    const __m512i none = _mm512_setzero_si512();
    const int last = PROJECT_CELL_NODES - 1;
    if (c < last) sums[0] = simd_fused(project_shift(none, weights, last - c), two, sums[0]);
    sums[1] = simd_fused(project_shift(weights, none, last - c), two, sums[1]);
}

/* Projects up to PROJECT_TURNS pixels. */
SIMD_INLINE void project_turns(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                               const float *cells)
{
    enum { USED = 2 * PROJECT_CELL_NODES };
    __m512i even[PROJECT_TURNS], odd[PROJECT_TURNS];
    simd_vector sums[PROJECT_TURNS][PROJECT_VECTORS];
    for (uint32_t i = 0; i < count; i++) {
        const struct project_row row = project_row_of(f, 1, pixels[i]);
        even[i] = project_twice(&row, PROJECT_EVEN);
        odd[i] = project_twice(&row, PROJECT_ODD);
        for (int v = 0; v < PROJECT_VECTORS; v++) sums[i][v] = (simd_vector){0};
    }
#pragma GCC unroll 8
    for (int c = 0; c < PROJECT_CELL_NODES; c++)
        for (uint32_t i = 0; i < count; i++) {
            const float *cell = cells + (size_t)4 * (PROJECT_CELL_NODES * i + (uint32_t)c);
            project_shifted(c, even[i], project_pair(cell), sums[i]);
            project_shifted(c, odd[i], project_pair(cell + 2), sums[i]);
        }
    for (uint32_t i = 0; i < count; i++) {
        float *rows = f->rows + (size_t)f->pixels->slot[pixels[i]] * 2 * (USED + 2);
        project_store_rows(sums[i], 0, USED, rows);
        memset(rows + 2 * USED, 0, 4 * sizeof *rows);
    }
}

static void project_rows_eight(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                               const float *cells)
{
    const size_t each = 4 * PROJECT_CELL_NODES;
    uint32_t k = 0;
    for (; k + PROJECT_TURNS <= count; k += PROJECT_TURNS)
        project_turns(f, pixels + k, PROJECT_TURNS, cells + k * each);
    for (; k < count; k++) project_turns(f, pixels + k, 1, cells + k * each);
}

#else

static void project_rows_eight(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                               const float *cells)
{
    project_rows(f, PROJECT_CELL_NODES, pixels, count, cells);
}

#endif

static void kernel_project_rows(const struct shadow_field *f, const uint32_t *pixels,
                                uint32_t count, const float *cells)
{
    if (f->scale == PROJECT_CELL_NODES)
        project_rows_eight(f, pixels, count, cells);
    else
        project_rows(f, f->scale, pixels, count, cells);
}
