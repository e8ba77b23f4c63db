#pragma once
/* The layers of lens samples, by slope. */
#include <math.h>
#include <stdint.h>
#include <string.h>

/* Layers come nearest first. The first is farther out of focus than LENS_SLOPE_MAX, before the
 * focus. Then come bands of slopes between powers of two and the numbers half-way between them, the
 * layer in focus, bands behind it, and the rest. */
#define LENS_BANDS     9 /* to one side of the focus */
#define LENS_SLOPE_MAX 24.0f
#define LENS_LAYERS    (2 * LENS_BANDS + 3)
#define LENS_FOCUS     (LENS_BANDS + 1) /* slopes from -1 to 1 */

/* How far pixels search for samples that are in focus and hidden from them. */
#define LENS_FOCUS_REACH_PX 6

/* Returns the layer of a slope. Its exponent and first binary digit count the bands. */
static inline uint32_t lens_layer_of(float slope)
{
    const float size = fabsf(slope);
    uint32_t bits;
    memcpy(&bits, &size, sizeof bits);
    const uint32_t least = 127u << 1, k = bits >> 22;
    if (k < least) return LENS_FOCUS;
    const uint32_t band = k - least < LENS_BANDS ? k - least : LENS_BANDS;
    return slope > 0.0f ? LENS_FOCUS - 1 - band : LENS_FOCUS + 1 + band;
}
