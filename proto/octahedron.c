#include "proto/octahedron.h"

#include <math.h>

/* The octahedron |x| + |y| + |z| = 1, its lower half folded outwards over the diagonals, covers the
 * square [-1, 1]^2 (Meyer et al. 2010, section 3). */
static void square_from_direction(const float n[3], float square[2])
{
    float sum = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    square[0] = square[1] = 0.0f;
    if (!(sum > 0.0f) || !isfinite(sum)) return; /* no direction: reads as +z */
    float x = n[0] / sum, y = n[1] / sum;
    square[0] = n[2] >= 0.0f ? x : copysignf(1.0f - fabsf(y), x);
    square[1] = n[2] >= 0.0f ? y : copysignf(1.0f - fabsf(x), y);
}

static void direction_from_square(float x, float y, float n[3])
{
    float z = 1.0f - fabsf(x) - fabsf(y);
    float fold = z < 0.0f ? -z : 0.0f;
    x -= copysignf(fold, x);
    y -= copysignf(fold, y);
    /* |x| + |y| + |z| is 1, so the length is at least 1/sqrt(3). */
    float scale = 1.0f / sqrtf(x * x + y * y + z * z);
    n[0] = x * scale;
    n[1] = y * scale;
    n[2] = z * scale;
}

static int32_t to_step(float v, float steps)
{
    return (int32_t)floorf(fminf(fmaxf(v, -1.0f), 1.0f) * steps + 0.5f);
}

/* The lowest integer has no positive counterpart: it reads as -1 as well. */
static float from_step(int32_t step, float steps)
{
    return fmaxf((float)step / steps, -1.0f);
}

uint32_t octahedron_pack16(const float n[3])
{
    float square[2];
    square_from_direction(n, square);
    uint32_t x = (uint32_t)to_step(square[0], 32767.0f) & 0xffffu;
    uint32_t y = (uint32_t)to_step(square[1], 32767.0f) & 0xffffu;
    return y << 16 | x;
}

void octahedron_unpack16(uint32_t packed, float n[3])
{
    int16_t x = (int16_t)(packed & 0xffffu), y = (int16_t)(packed >> 16);
    direction_from_square(from_step(x, 32767.0f), from_step(y, 32767.0f), n);
}

uint16_t octahedron_pack8(const float n[3])
{
    float square[2];
    square_from_direction(n, square);
    uint32_t x = (uint32_t)to_step(square[0], 127.0f) & 0xffu;
    uint32_t y = (uint32_t)to_step(square[1], 127.0f) & 0xffu;
    return (uint16_t)(y << 8 | x);
}

void octahedron_unpack8(uint16_t packed, float n[3])
{
    int8_t x = (int8_t)(packed & 0xffu), y = (int8_t)(packed >> 8);
    direction_from_square(from_step(x, 127.0f), from_step(y, 127.0f), n);
}
