#include "worker/trace/block_store.h"

#include <string.h>

#include "proto/half.h"

#define HALF_NORMAL_MIN 0x1p-14f

#define DEFINE_STORE(name, type)                                                                   \
    void name(const struct block *b, const type v[LANES], type *plane)                             \
    {                                                                                              \
        if (!plane) return;                                                                        \
        if (b->whole)                                                                              \
            for (int i = 0; i < LANES; i += LANES_ACROSS)                                          \
                memcpy(plane + b->element[i], v + i, LANES_ACROSS * sizeof v[0]);                  \
        else                                                                                       \
            for (int i = 0; i < LANES; i++)                                                        \
                if (b->kept.on[i]) plane[b->element[i]] = v[i];                                    \
    }

DEFINE_STORE(block_store_f32, float)
DEFINE_STORE(block_store_u32, uint32_t)
DEFINE_STORE(block_store_u16, uint16_t)
DEFINE_STORE(block_store_u8, uint8_t)

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
