#include "server/film/passes.h"

#include <stddef.h>

/* Once a pass and pixel, in double: the difference of two means that are nearly equal must not lose
 * the digits that a long render has earned. */
static void merge_spread(float *spread, const float *more_spread, const float *sum,
                         const float *more, size_t area, double n_a, double n_b)
{
    const double weight = n_a * n_b / (n_a + n_b); /* both at least 1 */
    for (size_t i = 0; i < area; i++) {
        const double d = (double)more[i] / n_b - (double)sum[i] / n_a;
        spread[i] = (float)((double)spread[i] + (double)more_spread[i] + d * d * weight);
    }
}

static void merge_spreads(struct samples *sum, double sum_spp, const struct samples *more,
                          double more_spp, size_t area)
{
    for (uint32_t c = 0; c < 3 && samples_f32(sum, PLANE_PATH_SPREAD, c); c++)
        merge_spread(samples_f32(sum, PLANE_PATH_SPREAD, c),
                     samples_f32(more, PLANE_PATH_SPREAD, c),
                     samples_f32(sum, PLANE_PATH_RADIANCE, c),
                     samples_f32(more, PLANE_PATH_RADIANCE, c), area, sum_spp, more_spp);
}

static void add_plane(struct samples *sum, const struct samples *more, enum plane_id plane,
                      size_t area)
{
    const bool scalar = plane == PLANE_PATH_COVERAGE || plane == PLANE_PATH_OCCLUSION;
    for (uint32_t c = 0; c < (scalar ? 1u : 3u); c++) {
        float *to = samples_f32(sum, plane, c);
        const float *from = samples_f32(more, plane, c);
        for (size_t i = 0; i < area; i++) to[i] += from[i];
    }
}

void passes_add(struct samples *sum, uint32_t sum_spp, const struct samples *more,
                uint32_t more_spp)
{
    const size_t area = (size_t)sum->layout.width_px * (size_t)sum->layout.height_px;
    const uint32_t planes = sum->layout.planes & PLANES_PATH & ~(1u << PLANE_PATH_SPREAD);
    merge_spreads(sum, sum_spp, more, more_spp, area); /* needs the radiance of before */
    for (uint32_t p = 0; p < PLANE_ID_COUNT; p++)
        if (planes >> p & 1u) add_plane(sum, more, p, area);
}
