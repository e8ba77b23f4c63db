#pragma once
/* hit_kernels' pack_unorms and pack_normals. The second is octahedron_pack16 and _pack8
 * (proto/octahedron.c) in sixteen lanes, with the same bits. */
#include <math.h>

#include "worker/shade/lanes.h"

/* Returns how far the code (sx, sy), unfolded, is from the direction d: |d x unfolded|^2. */
static inline float octahedron_error(float sx, float sy, float dx, float dy, float dz)
{
    float z = 1.0f - fabsf(sx) - fabsf(sy);
    float over = z < 0.0f ? -z : 0.0f;
    float ux = sx - copysignf(over, sx), uy = sy - copysignf(over, sy);
    float ex = dy * z - dz * uy, ey = dz * ux - dx * z, ez = dx * uy - dy * ux;
    return ex * ex + ey * ey + ez * ez;
}

static void kernel_pack_normals(const struct lanes3 *restrict normal, uint32_t bits,
                                uint32_t *restrict packed)
{
    const float steps = (float)((1u << (bits - 1)) - 1), scale = 1.0f / steps;
    const uint32_t mask = (1u << bits) - 1;
    for (int i = 0; i < LANES; i++) {
        float nx = normal->x[i], ny = normal->y[i], nz = normal->z[i];
        float sum = fabsf(nx) + fabsf(ny) + fabsf(nz);
        int usable = (sum > 0.0f) & (sum < INFINITY);
        float divisor = usable ? sum : 1.0f;
        float dx = usable ? nx / divisor : 0.0f, dy = usable ? ny / divisor : 0.0f;
        float dz = usable ? nz / divisor : 1.0f;
        float fx = dz >= 0.0f ? dx : copysignf(1.0f - fabsf(dy), dx);
        float fy = dz >= 0.0f ? dy : copysignf(1.0f - fabsf(dx), dy);
        float x0 = floorf(fx * steps), y0 = floorf(fy * steps);
        float x1 = x0 + 1.0f < steps ? x0 + 1.0f : steps;
        float y1 = y0 + 1.0f < steps ? y0 + 1.0f : steps;
        x0 = x0 < steps ? x0 : steps;
        y0 = y0 < steps ? y0 : steps;
        float e00 = octahedron_error(x0 * scale, y0 * scale, dx, dy, dz),
              e10 = octahedron_error(x1 * scale, y0 * scale, dx, dy, dz);
        float e01 = octahedron_error(x0 * scale, y1 * scale, dx, dy, dz),
              e11 = octahedron_error(x1 * scale, y1 * scale, dx, dy, dz);
        float x = e10 < e00 ? x1 : x0, least = e10 < e00 ? e10 : e00, y = y0;
        x = e01 < least ? x0 : x;
        y = e01 < least ? y1 : y;
        least = e01 < least ? e01 : least;
        x = e11 < least ? x1 : x;
        y = e11 < least ? y1 : y;
        packed[i] = ((uint32_t)(int32_t)y & mask) << bits | ((uint32_t)(int32_t)x & mask);
    }
}

static void kernel_pack_unorms(const float *restrict v, uint16_t *restrict packed)
{
    for (int i = 0; i < LANES; i++) {
        float low = v[i] > 0.0f ? v[i] : 0.0f, c = low < 1.0f ? low : 1.0f;
        packed[i] = (uint16_t)(int32_t)(c * 65535.0f + 0.5f);
    }
}
