#include "proto/octahedron.h"

/* The octahedron |x| + |y| + |z| = 1, its lower half folded outwards over the diagonals, covers the
 * square [-1, 1]^2 (Meyer et al. 2010, section 3). */
static void fold(const float on[3], float square[2])
{
    float x = on[0], y = on[1];
    square[0] = on[2] >= 0.0f ? x : copysignf(1.0f - fabsf(y), x);
    square[1] = on[2] >= 0.0f ? y : copysignf(1.0f - fabsf(x), y);
}

/* Computes the point on the octahedron, not normalised. */
static void unfold(float x, float y, float on[3])
{
    float z = 1.0f - fabsf(x) - fabsf(y);
    float over = z < 0.0f ? -z : 0.0f;
    on[0] = x - copysignf(over, x);
    on[1] = y - copysignf(over, y);
    on[2] = z;
}

static float min_of(float a, float b)
{
    return a < b ? a : b; /* fminf is a call */
}

/* Returns the squared sine of the angle between them, times their lengths. */
static float distance(const float a[3], const float b[3])
{
    float x = a[1] * b[2] - a[2] * b[1];
    float y = a[2] * b[0] - a[0] * b[2];
    float z = a[0] * b[1] - a[1] * b[0];
    return x * x + y * y + z * z;
}

/* Packs a direction as the nearest of the four codes around it. Rounding alone has half as much
 * error again. The four points' lengths are almost the same, so distance() ranks them. */
static void pack(const float n[3], float steps, int32_t code[2])
{
    code[0] = code[1] = 0; /* reads as +z */
    float sum = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    if (!(sum > 0.0f) || !isfinite(sum)) return; /* no direction */
    float on[3] = {n[0] / sum, n[1] / sum, n[2] / sum}, square[2];
    fold(on, square);
    float left = floorf(square[0] * steps), low = floorf(square[1] * steps), least = INFINITY;
    const float scale = 1.0f / steps;
    for (int i = 0; i < 4; i++) {
        float x = min_of(left + (float)(i & 1), steps);
        float y = min_of(low + (float)(i >> 1), steps);
        float candidate[3];
        unfold(x * scale, y * scale, candidate);
        float error = distance(on, candidate);
        if (!(error < least)) continue;
        least = error;
        code[0] = (int32_t)x;
        code[1] = (int32_t)y;
    }
}

uint32_t octahedron_pack16(const float n[3])
{
    int32_t code[2];
    pack(n, 32767.0f, code);
    return ((uint32_t)code[1] & 0xffffu) << 16 | ((uint32_t)code[0] & 0xffffu);
}

void octahedron_unpack16(uint32_t packed, float n[3])
{
    octahedron_unpack((int16_t)(packed & 0xffffu), (int16_t)(packed >> 16), 32767.0f, n);
}

uint16_t octahedron_pack8(const float n[3])
{
    int32_t code[2];
    pack(n, 127.0f, code);
    return (uint16_t)(((uint32_t)code[1] & 0xffu) << 8 | ((uint32_t)code[0] & 0xffu));
}

void octahedron_unpack8(uint16_t packed, float n[3])
{
    octahedron_unpack((int8_t)(packed & 0xffu), (int8_t)(packed >> 8), 127.0f, n);
}
