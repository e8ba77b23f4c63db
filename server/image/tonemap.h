#pragma once
/* Encodes linear radiance for a screen. */
#include <stdint.h>

/* Returns the IEC 61966-2-1 encoding of a value clipped to [0, 1]; NaN gives 0. */
float tonemap_srgb(float linear);

/* Returns round(255 * tonemap_srgb(linear * scale)). */
uint8_t tonemap_byte(float linear, float scale);

/* A table that gives the same bytes without a power for each, for whole pictures. Floats of [0, 1)
 * that share their exponent and first 8 bits of mantissa differ by at most one byte, so that a
 * start and the least value of the next byte give the byte. Below the table's range the byte is 0.
 */
#define TONEMAP_BUCKETS (14 * 256)
struct tonemap_table {
    float least[257];               /* least value that encodes to byte i; [256]: none does */
    uint8_t start[TONEMAP_BUCKETS]; /* byte of a bucket's first value */
};
void tonemap_table_init(struct tonemap_table *table);

/* Puts the bytes of `count` values, rounded to floats, at every step-th place. */
void tonemap_table_bytes(const struct tonemap_table *table, const double *linear, int32_t count,
                         uint8_t *out, int32_t step);
