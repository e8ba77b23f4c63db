#pragma once
/* From linear radiance to what a screen takes. */
#include <stdint.h>

/* IEC 61966-2-1 encoding of a value clipped to [0, 1]; NaN gives 0. */
float tonemap_srgb(float linear);

/* round(255 * tonemap_srgb(linear * scale)). */
uint8_t tonemap_byte(float linear, float scale);
