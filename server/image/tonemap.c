#include "server/image/tonemap.h"

#include <math.h>
#include <string.h>

/* Buckets start at 2^-14, far below the least value that encodes to 1 (0.5/255/12.92). */
#define FIRST_BITS   (((127u - 14u) << 23) >> BUCKET_SHIFT)
#define BUCKET_SHIFT 15
#define ONE_BITS     0x3f800000u

static uint32_t to_bits(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static float from_bits(uint32_t bits)
{
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

float tonemap_srgb(float linear)
{
    if (!(linear > 0.0f)) return 0.0f; /* NaN, too */
    if (linear >= 1.0f) return 1.0f;
    if (linear <= 0.0031308f) return 12.92f * linear;
    return 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

static uint8_t encode(float v)
{
    return (uint8_t)lrintf(255.0f * tonemap_srgb(v));
}

uint8_t tonemap_byte(float linear, float scale)
{
    return encode(linear * scale);
}

/* The bits of positive floats are ordered as the floats are. */
static float least_value(uint8_t byte)
{
    uint32_t low = 0, high = ONE_BITS; /* encode(low) < byte <= encode(high) */
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (encode(from_bits(middle)) < byte)
            low = middle;
        else
            high = middle;
    }
    return from_bits(high);
}

void tonemap_table_init(struct tonemap_table *table)
{
    table->least[0] = 0.0f;
    for (uint32_t i = 1; i < 256; i++) table->least[i] = least_value((uint8_t)i);
    table->least[256] = INFINITY;
    for (uint32_t i = 0; i < TONEMAP_BUCKETS; i++) {
        table->start[i] = encode(from_bits((FIRST_BITS + i) << BUCKET_SHIFT));
    }
}

static uint8_t table_byte(const struct tonemap_table *table, float v)
{
    if (!(v > 0.0f)) return 0;
    if (v >= 1.0f) return 255;
    uint32_t bucket = to_bits(v) >> BUCKET_SHIFT;
    if (bucket < FIRST_BITS) return 0;
    uint32_t byte = table->start[bucket - FIRST_BITS];
    return (uint8_t)(byte + (v >= table->least[byte + 1] ? 1u : 0u));
}

void tonemap_table_bytes(const struct tonemap_table *table, const double *linear, int32_t count,
                         uint8_t *out, int32_t step)
{
    for (int32_t i = 0; i < count; i++, out += step) *out = table_byte(table, (float)linear[i]);
}
