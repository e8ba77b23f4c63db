#include "server/film/passes.h"

#include <stddef.h>
#include <string.h>

#include "proto/half.h"

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
    const bool scalar =
        plane == PLANE_PATH_COVERAGE || plane == PLANE_PATH_OCCLUSION || plane == PLANE_PATH_SPLIT;
    for (uint32_t c = 0; c < (scalar ? 1u : 3u); c++) {
        float *to = samples_f32(sum, plane, c);
        const float *from = samples_f32(more, plane, c);
        for (size_t i = 0; i < area; i++) to[i] += from[i];
    }
}

static void add_paths(struct samples *sum, uint32_t sum_spp, const struct samples *more,
                      uint32_t more_spp)
{
    const size_t area = (size_t)sum->layout.width_px * (size_t)sum->layout.height_px;
    const uint64_t planes = sum->layout.planes & PLANES_PATH & ~PLANE_BIT(PATH_SPREAD);
    merge_spreads(sum, sum_spp, more, more_spp, area); /* needs the radiance of before */
    for (uint32_t p = 0; p < PLANE_ID_COUNT; p++)
        if (planes >> p & 1u) add_plane(sum, more, p, area);
}

#define RUN 64 /* pixels whose halves are numbers at a time */

/* to = the mean of to and from, weighted; finite halves stay finite. */
static void merge_means(uint16_t *to, const uint16_t *from, size_t area, float to_weight,
                        float from_weight)
{
    const float share = from_weight / (to_weight + from_weight);
    float a[RUN], b[RUN];
    for (size_t done = 0; done < area; done += RUN) {
        const size_t n = area - done < RUN ? area - done : RUN;
        half_to_floats(to + done, a, n);
        half_to_floats(from + done, b, n);
        for (size_t i = 0; i < n; i++) a[i] += share * (b[i] - a[i]);
        half_from_floats(a, to + done, n);
    }
}

/* Positive halves are ordered like their bits, and nearer ones count; 0 stands for no rays, where
 * both have none. */
static void take_nearer(uint16_t *to, const uint16_t *from, size_t area)
{
    for (size_t i = 0; i < area; i++) to[i] = from[i] < to[i] ? from[i] : to[i];
}

/* Rays of glossy lobes: as many as bounce rays. Their halves are of one size but for one ray. */
static void add_lobes(struct samples *sum, uint32_t count, const struct samples *more,
                      uint32_t more_count)
{
    static const enum plane_id planes[] = {PLANE_GLOSSY_MEAN, PLANE_GLOSSY_HALF,
                                           PLANE_GLOSSY_NEARNESS};
    const size_t area = (size_t)sum->layout.width_px * (size_t)sum->layout.height_px;
    for (size_t k = 0; k < sizeof planes / sizeof planes[0]; k++) {
        const uint32_t components = planes[k] == PLANE_GLOSSY_NEARNESS ? 1 : 4;
        for (uint32_t c = 0; c < components && samples_u16(sum, planes[k], c); c++)
            merge_means(samples_u16(sum, planes[k], c), samples_u16(more, planes[k], c), area,
                        (float)count, (float)more_count);
    }
}

static void add_bounces(struct samples *sum, uint32_t count, const struct samples *more,
                        uint32_t more_count)
{
    const size_t area = (size_t)sum->layout.width_px * (size_t)sum->layout.height_px;
    const uint32_t odd_count = count / 2;
    const float odd = (float)odd_count, even = (float)(count - odd_count),
                half = 0.5f * (float)more_count;
    for (uint32_t c = 0; c < 6 && samples_u16(sum, PLANE_INDIRECT_HALVES, c); c++)
        merge_means(samples_u16(sum, PLANE_INDIRECT_HALVES, c),
                    samples_u16(more, PLANE_INDIRECT_HALVES, c), area, c < 3 ? even : odd, half);
    if (samples_u16(sum, PLANE_OPEN, 0))
        merge_means(samples_u16(sum, PLANE_OPEN, 0), samples_u16(more, PLANE_OPEN, 0), area,
                    (float)count, (float)more_count);
    if (samples_u16(sum, PLANE_REFLECTOR, 0))
        take_nearer(samples_u16(sum, PLANE_REFLECTOR, 0), samples_u16(more, PLANE_REFLECTOR, 0),
                    area);
}

/* to = the mean of to, of `count` rays, and from, of so many squared. */
static void merge_sides(uint16_t *to, const uint16_t *from, size_t area, float count,
                        const uint8_t *sides)
{
    float a[RUN], b[RUN];
    for (size_t done = 0; done < area; done += RUN) {
        const size_t n = area - done < RUN ? area - done : RUN;
        half_to_floats(to + done, a, n);
        half_to_floats(from + done, b, n);
        for (size_t i = 0; i < n; i++) {
            const float more = (float)sides[done + i] * (float)sides[done + i];
            a[i] += more / (count + more) * (b[i] - a[i]);
        }
        half_from_floats(a, to + done, n);
    }
}

/* Of rays of glossy lobes; light and weights together, whose quotient filters make. */
static void add_second_lobes(struct samples *sum, uint32_t count, const struct samples *more,
                             const uint8_t *lobes)
{
    const size_t area = (size_t)sum->layout.width_px * (size_t)sum->layout.height_px;
    for (uint32_t c = 0; c < 4 && samples_u16(sum, PLANE_GLOSSY_MEAN, c); c++)
        merge_sides(samples_u16(sum, PLANE_GLOSSY_MEAN, c), samples_u16(more, PLANE_GLOSSY_MEAN, c),
                    area, (float)count, lobes);
}

static void add_second_set(struct samples *sum, uint32_t count, const struct samples *more,
                           const uint8_t *sides)
{
    const size_t area = (size_t)sum->layout.width_px * (size_t)sum->layout.height_px;
    for (uint32_t c = 0; c < 3 && samples_u16(sum, PLANE_INDIRECT_MEAN, c); c++)
        merge_sides(samples_u16(sum, PLANE_INDIRECT_MEAN, c),
                    samples_u16(more, PLANE_INDIRECT_MEAN, c), area, (float)count, sides);
    if (samples_u16(sum, PLANE_OPEN, 0))
        merge_sides(samples_u16(sum, PLANE_OPEN, 0), samples_u16(more, PLANE_OPEN, 0), area,
                    (float)count, sides);
}

/* Where a pixel has a second set, that is what it brings. */
static void add_lens_more(struct samples *sum, const struct samples *more, const uint8_t *sides)
{
    const size_t area = (size_t)sum->layout.width_px * (size_t)sum->layout.height_px;
    for (uint32_t c = 0; c < 4; c++)
        memcpy(samples_f32(sum, PLANE_LENS_MORE, c), samples_f32(more, PLANE_LENS_MORE, c),
               area * sizeof(float));
    if (samples_u16(sum, PLANE_LENS_COVERAGE, 0))
        merge_sides(samples_u16(sum, PLANE_LENS_COVERAGE, 0),
                    samples_u16(more, PLANE_LENS_COVERAGE, 0), area, (float)sum->layout.lens_strata,
                    sides);
}

void passes_add(struct samples *sum, struct pass_counts sum_counts, const struct samples *more,
                struct pass_counts more_counts)
{
    if (more_counts.paths > 0) add_paths(sum, sum_counts.paths, more, more_counts.paths);
    if (more_counts.bounces > 0) {
        add_bounces(sum, sum_counts.bounces, more, more_counts.bounces);
        add_lobes(sum, sum_counts.bounces, more, more_counts.bounces);
    }
    if (more_counts.lobes) add_second_lobes(sum, sum_counts.bounces, more, more_counts.lobes);
    if (!more_counts.sides) return;
    if (samples_f32(sum, PLANE_LENS_MORE, 0))
        add_lens_more(sum, more, more_counts.sides);
    else
        add_second_set(sum, sum_counts.bounces, more, more_counts.sides);
}
