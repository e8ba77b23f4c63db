#pragma once
/* Unit vectors on the octahedron: two signed normalised integers a direction.
 * Source: Meyer et al. 2010, "On floating-point normal vectors". */
#include <math.h>
#include <stdint.h>

/* Packs a direction into 2 x 16 bits, x in the low half; the error is below 5e-5 rad. `n` need not
 * be unit, but must not be zero. */
uint32_t octahedron_pack16(const float n[3]);
void octahedron_unpack16(uint32_t packed, float n[3]);

/* Packs one into 2 x 8 bits; the error is below 0.013 rad. For matching surfaces, not for
 * shading. */
uint16_t octahedron_pack8(const float n[3]);
void octahedron_unpack8(uint16_t packed, float n[3]);

/* Returns the 8-bit code of what a 16-bit code stands for, without unpacking it; the error is below
 * 0.02 rad. */
static inline uint32_t octahedron_coarsen(uint32_t packed)
{
    const float x = (float)(int16_t)(packed & 0xffffu), y = (float)(int16_t)(packed >> 16);
    const int32_t left = (int32_t)floorf(x * (127.0f / 32767.0f) + 0.5f);
    const int32_t low = (int32_t)floorf(y * (127.0f / 32767.0f) + 0.5f);
    return ((uint32_t)low & 0xffu) << 8 | ((uint32_t)left & 0xffu);
}

/* Unpacks a code whose coordinates have `steps` steps from 0 to 1 and to -1. */
static inline void octahedron_unpack(int32_t x, int32_t y, float steps, float n[3])
{
    /* The lowest integer has no positive counterpart: it reads as -1 as well. */
    const float left = -(float)x / steps, low = -(float)y / steps;
    const float a = -(left < 1.0f ? left : 1.0f), b = -(low < 1.0f ? low : 1.0f);
    const float z = 1.0f - fabsf(a) - fabsf(b), over = z < 0.0f ? -z : 0.0f;
    const float on[3] = {a - copysignf(over, a), b - copysignf(over, b), z};
    /* |x| + |y| + |z| is 1, so the length is at least 1/sqrt(3). */
    const float scale = 1.0f / sqrtf(on[0] * on[0] + on[1] * on[1] + on[2] * on[2]);
    for (int i = 0; i < 3; i++) n[i] = on[i] * scale;
}
