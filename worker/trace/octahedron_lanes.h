#pragma once
/* lane_kernels' pack_normals: octahedron_pack16 (proto/octahedron.c) in sixteen lanes, the same
 * bits. Included by lane_kernels_body.h only. */
#include <math.h>

#include "worker/trace/lanes.h"

#define OCTAHEDRON_STEPS 32767.0f

/* What unfolding the code (x, y) misses the direction d by: |d x unfolded|^2. */
static inline float octahedron_error(float x, float y, float dx, float dy, float dz)
{
    float sx = x * (1.0f / OCTAHEDRON_STEPS), sy = y * (1.0f / OCTAHEDRON_STEPS);
    float z = 1.0f - fabsf(sx) - fabsf(sy);
    float over = z < 0.0f ? -z : 0.0f;
    float ux = sx - copysignf(over, sx), uy = sy - copysignf(over, sy);
    float ex = dy * z - dz * uy, ey = dz * ux - dx * z, ez = dx * uy - dy * ux;
    return ex * ex + ey * ey + ez * ez;
}

static void kernel_pack_normals(const struct lanes3 *restrict normal, uint32_t *restrict packed)
{
    for (int i = 0; i < LANES; i++) {
        float nx = normal->x[i], ny = normal->y[i], nz = normal->z[i];
        float sum = fabsf(nx) + fabsf(ny) + fabsf(nz);
        int usable = (sum > 0.0f) & (sum < INFINITY);
        float divisor = usable ? sum : 1.0f;
        float dx = usable ? nx / divisor : 0.0f, dy = usable ? ny / divisor : 0.0f;
        float dz = usable ? nz / divisor : 1.0f;
        float fx = dz >= 0.0f ? dx : copysignf(1.0f - fabsf(dy), dx);
        float fy = dz >= 0.0f ? dy : copysignf(1.0f - fabsf(dx), dy);
        float x0 = floorf(fx * OCTAHEDRON_STEPS), y0 = floorf(fy * OCTAHEDRON_STEPS);
        float x1 = x0 + 1.0f < OCTAHEDRON_STEPS ? x0 + 1.0f : OCTAHEDRON_STEPS;
        float y1 = y0 + 1.0f < OCTAHEDRON_STEPS ? y0 + 1.0f : OCTAHEDRON_STEPS;
        x0 = x0 < OCTAHEDRON_STEPS ? x0 : OCTAHEDRON_STEPS;
        y0 = y0 < OCTAHEDRON_STEPS ? y0 : OCTAHEDRON_STEPS;
        float e00 = octahedron_error(x0, y0, dx, dy, dz),
              e10 = octahedron_error(x1, y0, dx, dy, dz);
        float e01 = octahedron_error(x0, y1, dx, dy, dz),
              e11 = octahedron_error(x1, y1, dx, dy, dz);
        float x = e10 < e00 ? x1 : x0, least = e10 < e00 ? e10 : e00, y = y0;
        x = e01 < least ? x0 : x;
        y = e01 < least ? y1 : y;
        least = e01 < least ? e01 : least;
        x = e11 < least ? x1 : x;
        y = e11 < least ? y1 : y;
        packed[i] = ((uint32_t)(int32_t)y & 0xffffu) << 16 | ((uint32_t)(int32_t)x & 0xffffu);
    }
}
