/* The turns of these plain loops do not depend on each other: the compiler makes vectors of them,
 * and pictures do not depend on the CPU. */
#include "server/reconstruct/lighting/lens_relight_kernels.h"

#include <math.h>

#include "proto/octahedron.h"
#include "proto/pattern.h"
#include "proto/pattern_path.h"
#include "proto/samples.h"
#include "proto/shared_exponent.h"

static inline float lens_relight_clamp(float x, float low, float high)
{
    const float from = x > low ? x : low;
    return from < high ? from : high;
}

/* A sample of pixel position p at lens position u shows what the middle sees at p + slope u. */
static void lens_relight_find(const struct lens_relight_row r, uint32_t begin, uint32_t end,
                              float *restrict across, float *restrict down)
{
    const float *restrict slope = r.slope, *restrict along = r.along, *restrict height = r.height;
    const float *restrict left = r.left, *restrict length = r.length;
    const uint32_t *restrict order = r.order, *restrict u = r.u, *restrict v = r.v;
    for (uint32_t i = begin; i < end; i++) {
        const struct path_seeds seeds = {order[i], u[i], v[i]};
        float x, y;
        path_seeded_pair(seeds, r.sample, &x, &y);
        across[i] = r.x + (float)(int32_t)i + x +
                    slope[i] * (left[i] + length[i] * pattern_axis(along[i], r.l, r.k));
        down[i] = r.y + y + slope[i] * height[i];
    }
}

static void lens_relight_project(const struct lens_relight_row r, uint32_t begin, uint32_t end,
                                 const float *restrict across, const float *restrict down,
                                 float *restrict z, float *restrict distance, float *restrict off,
                                 float *restrict px, float *restrict py, float *restrict pz)
{
    for (uint32_t i = begin; i < end; i++) {
        const float a = r.a_start + r.a_step * across[i], b = r.b_start + r.b_step * down[i];
        const float far = z[i] * r.unit;
        z[i] = far;
        px[i] = far * (a * r.right[0] + b * r.up[0] + r.forward[0]);
        py[i] = far * (a * r.right[1] + b * r.up[1] + r.forward[1]);
        pz[i] = far * (a * r.right[2] + b * r.up[2] + r.forward[2]);
        distance[i] = far * sqrtf(1.0f + a * a + b * b);
        off[i] = r.allowed * distance[i];
    }
}

/* Places become pixels, counted from `low` on, and the rest. */
static void lens_relight_pixels(float low, float high, uint32_t begin, uint32_t end,
                                float *restrict place, int32_t *restrict pixel)
{
    for (uint32_t i = begin; i < end; i++) {
        const float x = lens_relight_clamp(place[i] - 0.5f, low, high), whole = floorf(x);
        pixel[i] = (int32_t)(whole - low);
        place[i] = x - whole;
    }
}

static void lens_relight_normals(const uint16_t *restrict code, uint32_t begin, uint32_t end,
                                 float *restrict x, float *restrict y, float *restrict z)
{
    for (uint32_t i = begin; i < end; i++) {
        float n[3];
        octahedron_unpack((int8_t)(code[i] & 0xffu), (int8_t)(code[i] >> 8), 127.0f, n);
        x[i] = n[0];
        y[i] = n[1];
        z[i] = n[2];
    }
}

static void kernel_place(const struct lens_relight_row *row, uint32_t begin, uint32_t end)
{
    const struct lens_relight_row r = *row;
    lens_relight_find(r, begin, end, r.across, r.down);
    lens_relight_project(r, begin, end, r.across, r.down, r.z, r.distance, r.off, r.point[0],
                         r.point[1], r.point[2]);
    lens_relight_pixels(r.x_low, r.x_high, begin, end, r.across, r.column);
    lens_relight_pixels(r.y_low, r.y_high, begin, end, r.down, r.row);
    lens_relight_normals(r.code, begin, end, r.normal[0], r.normal[1], r.normal[2]);
}

static void lens_relight_unpack(const uint32_t *restrict packed, float scale, uint32_t count,
                                float *restrict r, float *restrict g, float *restrict b)
{
    for (uint32_t i = 0; i < count; i++) {
        float light[3];
        shared_exponent_unpack(packed[i], SHARED_EXPONENT_8, light);
        r[i] = light[0] * scale;
        g[i] = light[1] * scale;
        b[i] = light[2] * scale;
    }
}

static void kernel_own(const uint32_t *packed, float scale, uint32_t count, float *const light[3])
{
    lens_relight_unpack(packed, scale, count, light[0], light[1], light[2]);
}

static void kernel_add(const uint32_t *restrict albedo, const float *restrict light,
                       const float *shine, uint32_t c, uint32_t count, float *out)
{
    const uint32_t shift = c * SHARED_EXPONENT_9, full = (1u << SHARED_EXPONENT_9) - 1;
    /* Each number comes of those at its own place alone. */
#pragma GCC ivdep
    for (uint32_t i = 0; i < count; i++) {
        const int32_t exponent =
            (int32_t)(albedo[i] >> 3 * SHARED_EXPONENT_9) + shared_exponent_min(SHARED_EXPONENT_9);
        const float a =
            (float)(int32_t)(albedo[i] >> shift & full) * shared_exponent_power(exponent);
        const float sum = shine[i] + a * light[i];
        out[i] = sum < LENS_RADIANCE_MAX ? sum : LENS_RADIANCE_MAX;
    }
}

/* Numbers above 0 are in the order of their bits. */
static float kernel_max(const float *restrict slope, uint32_t count, float most)
{
    int32_t bits = 0;
    memcpy(&bits, &most, sizeof bits);
    for (uint32_t i = 0; i < count; i++) {
        int32_t size;
        memcpy(&size, slope + i, sizeof size);
        size &= INT32_MAX;
        bits = size > bits ? size : bits;
    }
    memcpy(&most, &bits, sizeof most);
    return most;
}

const struct lens_relight_kernels KERNELS(lens_relight_kernels) = {
    .place = kernel_place,
    .own = kernel_own,
    .add = kernel_add,
    .max = kernel_max,
};
