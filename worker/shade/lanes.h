#pragma once
/* Sixteen pixels side by side: the shape in which everything is traced and shaded. Plain loops over
 * LANES become vector code of any width. */
#include <stdint.h>

#define LANES        16
#define LANES_ALIGN  64
#define LANES_ACROSS 4 /* a block is 4 x 4 pixels, lane = 4 (y & 3) + (x & 3) */

/* For the parts of loops over lanes. They are inlined early, while the compiler still knows which
 * pointers are restrict. */
#define LANE_INLINE static inline __attribute__((always_inline))

struct lanes3 {
    _Alignas(LANES_ALIGN) float x[LANES];
    _Alignas(LANES_ALIGN) float y[LANES];
    _Alignas(LANES_ALIGN) float z[LANES];
};

/* One truth value per lane: -1 or 0, as in Embree's valid masks. */
struct lanes_mask {
    _Alignas(LANES_ALIGN) int32_t on[LANES];
};

static inline uint32_t lanes_count(const struct lanes_mask *m)
{
    int32_t sum = 0;
    for (int i = 0; i < LANES; i++) sum -= m->on[i];
    return (uint32_t)sum;
}

/* Returns the number of lanes that are on in both. */
static inline uint32_t lanes_count_both(const struct lanes_mask *a, const struct lanes_mask *b)
{
    int32_t sum = 0;
    for (int i = 0; i < LANES; i++) sum -= a->on[i] & b->on[i];
    return (uint32_t)sum;
}
