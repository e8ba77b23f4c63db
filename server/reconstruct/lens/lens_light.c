#include "server/reconstruct/lens/lens_light.h"

#include <math.h>

#include "proto/lens_slope.h"

/* Slopes from which samples keep their own light, and up to which they do not, px. */
#define SLOPE_MAX  8.0f
#define SLOPE_FULL 6.0f

/* The filter of layers reads cells that far beyond a slope. */
#define CELLS_PX 6

/* Samples whose slopes differ by less show one surface, px. */
#define SLOPE_SAME 0.5f

int32_t lens_light_reach_px(const struct plan *plan)
{
    const bool both = plan_lens_has_paths(plan) && plan->residual_filter != RESIDUAL_FILTER_NONE;
    return both ? (int32_t)SLOPE_MAX + CELLS_PX : 0;
}

/* A pixel's samples. */
struct pixel {
    const float *slope;
    float *light; /* of all samples, channel after channel */
    size_t area;  /* from one to the next */
    uint32_t count;
    float sky; /* slope of those that meet no surface; NAN: all do */
};

static struct pixel pixel_of(const struct plan *plan, struct patch *patch, size_t i, float sky)
{
    const bool met = patch->path_coverage[i] >= patch->paths.spp[i];
    return (struct pixel){patch->lens_slope + i, patch->lens_radiance + i,
                          (size_t)rect_area(patch->rect),
                          plan->lens_strata_per_axis * plan->lens_strata_per_axis, met ? NAN : sky};
}

static float slope_of(const struct pixel *p, uint32_t sample)
{
    return p->slope[sample * p->area];
}

static float *light_of(const struct pixel *p, uint32_t sample, uint32_t channel)
{
    return p->light + (sample * 3 + channel) * p->area;
}

/* What samples that meet a surface have in common: their number and slopes, the mean of their
 * light, and what the filter makes of that. */
struct shared {
    float count, low, high;
    float mean[3], goal[3];
};

static void add_slope(float slope, struct shared *s)
{
    s->count += 1.0f;
    s->low = slope < s->low ? slope : s->low;
    s->high = slope > s->high ? slope : s->high;
}

/* `found` is the pixel's filtered light, of which that of other samples is a part. */
static void share(const struct pixel *p, const float found[3], struct shared *s)
{
    float rest[3] = {0.0f, 0.0f, 0.0f};
    *s = (struct shared){.low = INFINITY, .high = -INFINITY};
    for (uint32_t j = 0; j < p->count; j++) {
        const bool met = slope_of(p, j) != p->sky;
        if (met) add_slope(slope_of(p, j), s);
        for (uint32_t c = 0; c < 3; c++) *(met ? &s->mean[c] : &rest[c]) += *light_of(p, j, c);
    }
    for (int c = 0; c < 3 && s->count > 0.0f; c++) {
        const float goal = ((float)p->count * found[c] - rest[c]) / s->count;
        s->mean[c] /= s->count;
        s->goal[c] = goal > 0.0f ? goal : 0.0f;
    }
}

/* How much of the filter's light a sample takes. */
static float taken(float slope)
{
    const float left = (SLOPE_MAX - fabsf(slope)) / (SLOPE_MAX - SLOPE_FULL);
    return left > 1.0f ? 1.0f : (left > 0.0f ? left : 0.0f);
}

/* Of several surfaces each sample keeps its part of the mean: dimmed by a factor, so that no light
 * is negative, or brightened by the same amount, since black has none to scale. */
static float goal_of(const struct shared *s, float light, int c)
{
    if (s->high - s->low < SLOPE_SAME) return s->goal[c];
    if (s->goal[c] < s->mean[c]) return light * (s->goal[c] / s->mean[c]);
    return light + (s->goal[c] - s->mean[c]);
}

static void give(const struct pixel *p, const struct shared *s)
{
    for (uint32_t j = 0; j < p->count; j++) {
        const float slope = slope_of(p, j), part = taken(slope);
        if (slope == p->sky || part == 0.0f) continue;
        for (uint32_t c = 0; c < 3; c++) {
            float *light = light_of(p, j, c);
            const float goal = goal_of(s, *light, (int)c);
            *light = part < 1.0f ? *light + part * (goal - *light) : goal;
        }
    }
}

int lens_light_filter(const struct plan *plan, struct patch *patch, struct rect block,
                      struct residual_statistics *statistics)
{
    const struct rect wide =
        rect_intersect(rect_grow(block, lens_light_reach_px(plan)), patch->rect);
    const float sky = lens_slope_sky(lens_sloper_of(plan));
    struct residual_picture picture;
    const int error = residual_filter(patch, wide, NULL, &picture, statistics);
    if (error) return error;
    for (int32_t y = wide.y0; y < wide.y1; y++)
        for (int32_t x = wide.x0; x < wide.x1; x++) {
            const size_t at = residual_picture_at(&picture, x, y);
            const float found[3] = {picture.radiance[0][at], picture.radiance[1][at],
                                    picture.radiance[2][at]};
            const struct pixel p = pixel_of(plan, patch, patch_pixel(patch, x, y), sky);
            struct shared shared;
            share(&p, found, &shared);
            give(&p, &shared);
        }
    residual_picture_fini(&picture);
    return 0;
}
