#pragma once
/* Puts a block's lanes where they belong in the planes of its tile. Planes that the plan does not
 * ask for are NULL and skipped. */
#include <float.h>
#include <string.h>

#include "worker/trace/hit/block.h"

/* Stores elements of `size` bytes. It is inlined, so that the copies are moves. */
LANE_INLINE void block_scatter(const struct block *b, const void *values, void *plane, size_t size)
{
    const uint8_t *from = values;
    uint8_t *to = plane;
    if (!plane) return;
    if (b->whole)
        for (size_t i = 0; i < LANES; i += LANES_ACROSS)
            memcpy(to + size * b->element[i], from + size * i, LANES_ACROSS * size);
    else
        for (size_t i = 0; i < LANES; i++)
            if (b->kept.on[i]) memcpy(to + size * b->element[i], from + size * i, size);
}

/* Loads elements. Lanes that are not kept read element 0. */
LANE_INLINE void block_gather(const struct block *b, const void *plane, void *values, size_t size)
{
    const uint8_t *from = plane;
    uint8_t *to = values;
    if (b->whole)
        for (size_t i = 0; i < LANES; i += LANES_ACROSS)
            memcpy(to + size * i, from + size * b->element[i], LANES_ACROSS * size);
    else
        for (size_t i = 0; i < LANES; i++) memcpy(to + size * i, from + size * b->element[i], size);
}

void block_store_f32(const struct block *b, const float v[LANES], float *plane);
void block_store_u32(const struct block *b, const uint32_t v[LANES], uint32_t *plane);
void block_store_u16(const struct block *b, const uint16_t v[LANES], uint16_t *plane);
void block_store_u8(const struct block *b, const uint8_t v[LANES], uint8_t *plane);

/* Stores v * scale as half floats. */
void block_store_half(const struct block *b, const float v[LANES], float scale, uint16_t *plane);

/* Does the same for values that must not become zero by rounding: a positive v becomes at least the
 * smallest normal half. */
void block_store_positive_half(const struct block *b, const float v[LANES], float scale,
                               uint16_t *plane);

/* The largest half below BOUNCE_DISTANCE_NONE. */
#define BLOCK_DISTANCE_MAX 65472.0f

/* Returns a hit's distance over the length unit as planes hold it. 0 would say that there was no
 * ray, and BOUNCE_DISTANCE_NONE that nothing was met. */
static inline float block_distance(float scaled)
{
    const float positive = scaled > FLT_MIN ? scaled : FLT_MIN;
    return positive < BLOCK_DISTANCE_MAX ? positive : BLOCK_DISTANCE_MAX;
}
