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
    for (uint32_t c = 0; c < 3 && samples_f32(sum, PLANE_PATH_M2, c); c++)
        merge_spread(samples_f32(sum, PLANE_PATH_M2, c), samples_f32(more, PLANE_PATH_M2, c),
                     samples_f32(sum, PLANE_PATH_RADIANCE, c),
                     samples_f32(more, PLANE_PATH_RADIANCE, c), area, sum_spp, more_spp);
}

static void add(float *to, const float *from, size_t area)
{
    for (size_t i = 0; i < area; i++) to[i] += from[i];
}

/* What two means weigh. */
struct weights {
    float own, more;
    const uint8_t *strata_map; /* squared `more` of each pixel; NULL: all have the same */
};

#define RUN 64 /* pixels whose halves are numbers at a time */

/* to = the mean of to and from, weighted; finite halves stay finite. */
static void merge_means(uint16_t *to, const uint16_t *from, size_t area, const struct weights *w)
{
    float a[RUN], b[RUN], more[RUN];
    for (size_t done = 0; done < area; done += RUN) {
        const size_t n = area - done < RUN ? area - done : RUN;
        half_to_floats(to + done, a, n);
        half_to_floats(from + done, b, n);
        for (size_t i = 0; i < n; i++)
            more[i] = w->strata_map
                          ? (float)w->strata_map[done + i] * (float)w->strata_map[done + i]
                          : w->more;
        for (size_t i = 0; i < n; i++) a[i] += more[i] / (w->own + more[i]) * (b[i] - a[i]);
        half_from_floats(a, to + done, n);
    }
}

/* Positive halves are ordered like their bits, and nearer ones count; 0 stands for no rays, where
 * both have none. */
static void take_nearer(uint16_t *to, const uint16_t *from, size_t area)
{
    for (size_t i = 0; i < area; i++) to[i] = from[i] < to[i] ? from[i] : to[i];
}

/* Two passes of a tile. */
struct addition {
    struct samples *sum;
    const struct samples *more;
    struct pass_counts sum_counts, more_counts;
    size_t area;
};

/* Computes the weights of component c of a plane. Returns false if `more` has none of its rays. */
static bool weigh(const struct addition *a, enum samples_merge merge, uint32_t c, struct weights *w)
{
    const uint32_t own = a->sum_counts.bounces, more = a->more_counts.bounces;
    switch (merge) {
    case SAMPLES_MEAN:
        *w = (struct weights){(float)own, (float)more, a->more_counts.strata_map};
        break;
    case SAMPLES_MEAN_LOBES:
        *w = (struct weights){(float)own, (float)more, a->more_counts.lobes};
        break;
    case SAMPLES_MEAN_LENS:
        *w = (struct weights){(float)a->sum->layout.lens_strata, 0.0f, a->more_counts.strata_map};
        break;
    default: /* the mean over even rays, then over odd ones, of which there may be one less */
        *w = (struct weights){(float)(c < 3 ? own - own / 2 : own / 2), 0.5f * (float)more, NULL};
    }
    return w->more > 0.0f || w->strata_map;
}

static void merge_component(const struct addition *a, enum samples_merge merge, uint32_t c,
                            void *to, const void *from)
{
    struct weights weights;
    switch (merge) {
    case SAMPLES_FIRST:
    case SAMPLES_SPREAD:
        break;
    case SAMPLES_SUM:
        if (a->more_counts.paths > 0) add(to, from, a->area);
        break;
    case SAMPLES_NEAREST:
        if (a->more_counts.bounces > 0) take_nearer(to, from, a->area);
        break;
    case SAMPLES_LATEST:
        if (a->more_counts.strata_map) memcpy(to, from, a->area * sizeof(float));
        break;
    default:
        if (weigh(a, merge, c, &weights)) merge_means(to, from, a->area, &weights);
    }
}

void passes_add(struct samples *sum, struct pass_counts sum_counts, const struct samples *more,
                struct pass_counts more_counts)
{
    const size_t area = (size_t)sum->layout.width_px * (size_t)sum->layout.height_px;
    const struct addition a = {sum, more, sum_counts, more_counts, area};
    const uint64_t planes = sum->layout.planes & more->layout.planes;
    if (more_counts.paths > 0) /* needs the radiance of before */
        merge_spreads(sum, sum_counts.paths, more, more_counts.paths, area);
    for (uint32_t p = 0; p < PLANE_ID_COUNT; p++)
        for (uint32_t c = 0; planes >> p & 1u && c < sum->layout.components[p]; c++)
            merge_component(&a, samples_plane(p)->merge, c, samples_component(sum, p, c),
                            samples_component(more, p, c));
}
