#include "worker/trace/hit/block_store.h"

#include "proto/half.h"

#define HALF_NORMAL_MIN 0x1p-14f

void block_store_f32(const struct block *b, const float v[LANES], float *plane)
{
    block_scatter(b, v, plane, sizeof v[0]);
}

void block_store_u32(const struct block *b, const uint32_t v[LANES], uint32_t *plane)
{
    block_scatter(b, v, plane, sizeof v[0]);
}

void block_store_u16(const struct block *b, const uint16_t v[LANES], uint16_t *plane)
{
    block_scatter(b, v, plane, sizeof v[0]);
}

void block_store_u8(const struct block *b, const uint8_t v[LANES], uint8_t *plane)
{
    block_scatter(b, v, plane, sizeof v[0]);
}

void block_store_half(const struct block *b, const float v[LANES], float scale, uint16_t *plane)
{
    float scaled[LANES];
    uint16_t halves[LANES];
    if (!plane) return;
    for (int i = 0; i < LANES; i++) scaled[i] = v[i] * scale;
    half_from_floats(scaled, halves, LANES);
    block_store_u16(b, halves, plane);
}

void block_store_positive_half(const struct block *b, const float v[LANES], float scale,
                               uint16_t *plane)
{
    float raised[LANES];
    uint16_t halves[LANES];
    if (!plane) return;
    for (int i = 0; i < LANES; i++) {
        float scaled = v[i] * scale;
        float least = v[i] > 0.0f ? HALF_NORMAL_MIN : 0.0f;
        raised[i] = scaled > least ? scaled : least;
    }
    half_from_floats(raised, halves, LANES);
    block_store_u16(b, halves, plane);
}
