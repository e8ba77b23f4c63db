#pragma once
/* The sum_slopes of shadow_kernels, for adjacent pixels. */
#include <stddef.h>

#include "server/reconstruct/shadow/compatible_lanes.h"
#include "server/reconstruct/shadow/shadow_lanes.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/vector.h"

#define SLOPES_SIDE    5
#define SLOPES_REACH   (SLOPES_SIDE / 2)
#define SLOPES_COLUMNS (SIMD_LANES + SLOPES_SIDE - 1) /* that adjacent pixels read */
/* For a pixel at least SLOPES_REACH from the edges, vectors reach SIMD_LANES - 1 past the planes.
 */
_Static_assert(SIMD_LANES - 1 <= SHADOW_PLANE_PAD, "vectors of all lanes");

/* A row of neighbours, from its first on. */
struct slopes_row {
    const float *shown[6]; /* points and normals */
    const float *a, *b;
};

/* Returns how many of the `most` pixels of the list, from the first on, lie among SIMD_LANES in a
 * row. */
static inline uint32_t slopes_count(const uint32_t *pixels, uint32_t most)
{
    uint32_t count = 1;
    while (count < most && pixels[count] > pixels[count - 1] &&
           pixels[count] - pixels[0] < SIMD_LANES)
        count++;
    return count;
}

static inline struct slopes_row slopes_look(const struct shadow_pixels *p, size_t from,
                                            const float *a, const float *b)
{
    return (struct slopes_row){{p->point[0] + from, p->point[1] + from, p->point[2] + from,
                                p->normal[0] + from, p->normal[1] + from, p->normal[2] + from},
                               a + from,
                               b + from};
}

/* Returns whether any of the neighbours has values. The last vector overlaps the one before. */
static inline bool slopes_has_values(const struct slopes_row *row)
{
    simd_mask has = {0};
    for (size_t i = 0; i + SIMD_PER_VECTOR <= SLOPES_COLUMNS; i += SIMD_PER_VECTOR)
        has |= ~(simd_load_vector(row->a + i) < 0.0f);
    has |= ~(simd_load_vector(row->a + SLOPES_COLUMNS - SIMD_PER_VECTOR) < 0.0f);
    return simd_signs(has) != 0;
}

/* Sums of the lanes of one vector: number, a and b. */
struct slopes_sums {
    simd_vector count, a, b;
};

/* Adds a row of neighbours of the lanes from `first` on. */
SIMD_INLINE void slopes_add(const struct compatible_receivers *receiver,
                            const struct slopes_row *row, size_t first, struct slopes_sums *out)
{
#pragma GCC unroll 5
    for (size_t x = first; x < first + SLOPES_SIDE; x++) {
        simd_vector point[3], normal[3];
        for (int k = 0; k < 3; k++) {
            point[k] = simd_load_vector(row->shown[k] + x);
            normal[k] = simd_load_vector(row->shown[3 + k] + x);
        }
        const simd_vector a = simd_load_vector(row->a + x), b = simd_load_vector(row->b + x);
        const simd_chosen taken =
            compatible_chosen(receiver, point, normal) & simd_up_to(simd_same(0.0f), a);
        out->count = simd_add_to(out->count, taken, simd_same(1.0f));
        out->a = simd_add_to(out->a, taken, a);
        out->b = simd_add_to(out->b, taken, b);
    }
}

/* Computes the number of neighbours and the sums of a and b for adjacent pixels from `first` on. */
static inline void slopes_sum(const struct shadow_field *f, size_t first, const float *a,
                              const float *b, float out[3][SIMD_LANES])
{
    struct slopes_sums sums[SIMD_VECTORS] = {0};
    struct compatible_receivers receivers[SIMD_VECTORS];
    for (size_t v = 0; v < SIMD_VECTORS; v++)
        receivers[v] = compatible_receivers_of(f->pixels, first + v * SIMD_PER_VECTOR);
    for (ptrdiff_t y = -SLOPES_REACH; y <= SLOPES_REACH; y++) {
        const ptrdiff_t from = (ptrdiff_t)first + y * f->width - SLOPES_REACH;
        const struct slopes_row row = slopes_look(f->pixels, (size_t)from, a, b);
        if (!slopes_has_values(&row)) continue;
        for (size_t v = 0; v < SIMD_VECTORS; v++)
            slopes_add(&receivers[v], &row, v * SIMD_PER_VECTOR, &sums[v]);
    }
    for (size_t v = 0; v < SIMD_VECTORS; v++) {
        *(simd_stored *)(out[0] + v * SIMD_PER_VECTOR) = sums[v].count;
        *(simd_stored *)(out[1] + v * SIMD_PER_VECTOR) = sums[v].a;
        *(simd_stored *)(out[2] + v * SIMD_PER_VECTOR) = sums[v].b;
    }
}

/* Takes up to SIMD_LANES adjacent pixels at once. The list need not hold all of them. */
static void kernel_sum_slopes(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                              const float *a, const float *b, float *out)
{
    _Alignas(64) float sums[3][SIMD_LANES];
    for (uint32_t k = 0, n; k < count; k += n) {
        const size_t first = pixels[k];
        n = slopes_count(pixels + k, count - k);
        slopes_sum(f, first, a, b, sums);
        for (uint32_t i = 0; i < n; i++, out += 3) {
            for (size_t j = 0; j < 3; j++) out[j] = sums[j][pixels[k + i] - first];
        }
    }
}
