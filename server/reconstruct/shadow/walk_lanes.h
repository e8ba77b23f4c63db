#pragma once
/* The walks of shadow_kernels, passes 1b and 2b, and the pixels that walks reach. Sixteen pixels
 * are walked together, first to weigh their taps, then to sum them. */
#include "server/reconstruct/shadow/walk_sum_lanes.h"

static void kernel_walk_columns(const struct shadow_field *f, const uint32_t *pixels,
                                uint32_t count, float *out)
{
    struct walk_taps taps;
    for (uint32_t k = 0; k < count; k += SIMD_LANES) {
        walk_take(f, 0, f->lanes, pixels + k, count - k, &taps);
        walk_sum_columns(f, &taps, out + (size_t)k * 4 * f->scale);
    }
}

static void kernel_walk_rows(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                             float *out)
{
    struct walk_taps taps;
    for (uint32_t k = 0; k < count; k += SIMD_LANES) {
        walk_take(f, 1, 2, pixels + k, count - k, &taps);
        walk_sum_rows(f, &taps, out + 2 * (size_t)k);
    }
}

static void kernel_mark_walks(const struct shadow_field *f, uint32_t axis, const uint32_t *pixels,
                              uint32_t count, uint8_t *marks)
{
    struct walk_group group;
    struct walk_tap tap[2];
    for (uint32_t first = 0; first < count; first += SIMD_LANES) {
        walk_group_load(f, axis, pixels + first, count - first, &group);
        for (int32_t k = -group.reach_max; k <= group.reach_max; k++) {
            walk_place(&group, k, tap);
            walk_mark(tap[0].to, marks);
            walk_mark(tap[1].to, marks);
        }
    }
}
