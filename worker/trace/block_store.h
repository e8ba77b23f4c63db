#pragma once
/* Puts a block's lanes where they belong in the planes of its tile. Planes that the plan does not
 * ask for are NULL and nothing happens. */
#include "worker/trace/block.h"

void block_store_f32(const struct block *b, const float v[LANES], float *plane);
void block_store_u32(const struct block *b, const uint32_t v[LANES], uint32_t *plane);
void block_store_u16(const struct block *b, const uint16_t v[LANES], uint16_t *plane);
void block_store_u8(const struct block *b, const uint8_t v[LANES], uint8_t *plane);

/* Half floats of v * scale. */
void block_store_half(const struct block *b, const float v[LANES], float scale, uint16_t *plane);

/* The same for positive values that must not become zero by rounding: at least the smallest normal
 * half where v is positive. */
void block_store_positive_half(const struct block *b, const float v[LANES], float scale,
                               uint16_t *plane);
