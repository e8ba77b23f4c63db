#include "server/reconstruct/patch/spike_limits.h"

#include <string.h>

void spike_limits_take(struct spike_limits *s, float *const arrays[SPIKE_ARRAYS])
{
    float **const all[SPIKE_ARRAYS] = {&s->light, &s->shown,   &s->link_x, &s->link_y,
                                       &s->limit, &s->bounded, &s->along,  &s->along_count,
                                       &s->sum,   &s->count};
    for (int k = 0; k < SPIKE_ARRAYS; k++) *all[k] = arrays[k];
}

/* Sums over the pixels of a line that are linked with each of the receivers. */
struct line_sums {
    float open[SIMD_LANES], sum[SIMD_LANES], count[SIMD_LANES];
};

/* A line's input. link[i] tells of pixels i and i + step. */
struct line {
    const float *in, *counts, *link;
    ptrdiff_t step;
};

/* Adds `reach` pixels to one side of those from p on. */
static void add_side(const struct line *l, size_t p, bool backward, int32_t reach,
                     struct line_sums *s)
{
    for (int i = 0; i < SIMD_LANES; i++) s->open[i] = 1.0f;
    for (int32_t k = 1; k <= reach; k++) {
        const ptrdiff_t way = backward ? -k * l->step : k * l->step;
        const ptrdiff_t at = (ptrdiff_t)p + way, joint = backward ? at : at - l->step;
        const float *in = l->in + at, *counts = l->counts + at, *link = l->link + joint;
        for (int i = 0; i < SIMD_LANES; i++) {
            s->open[i] *= link[i];
            s->sum[i] += s->open[i] * in[i];
            s->count[i] += s->open[i] * counts[i];
        }
    }
}

static void sum_line(const struct line *l, size_t first, int32_t width, int32_t before,
                     int32_t after, float *out, float *out_counts)
{
    struct line_sums s;
    for (size_t p = first; p < first + (size_t)width; p += SIMD_LANES) {
        memcpy(s.sum, l->in + p, sizeof s.sum);
        memcpy(s.count, l->counts + p, sizeof s.count);
        add_side(l, p, true, before, &s);
        add_side(l, p, false, after, &s);
        memcpy(out + p, s.sum, sizeof s.sum);
        memcpy(out_counts + p, s.count, sizeof s.count);
    }
}

static int32_t at_max(int32_t v, int32_t most)
{
    return v < most ? v : most;
}

/* Sums windows of `in` along x, then along y. */
static void sum_windows(const struct spike_limits *s, const float *in, struct rect rect,
                        int32_t reach)
{
    const struct line across = {in, s->shown, s->link_x, 1};
    const struct line down = {s->along, s->along_count, s->link_y, (ptrdiff_t)s->stride};
    const struct rect read = rect_intersect(rect_grow(rect, reach), s->rect);
    const int32_t width = rect_width(rect);
    for (int32_t y = read.y0; y < read.y1; y++)
        sum_line(&across, spike_limits_at(s, rect.x0, y), width, reach, reach, s->along,
                 s->along_count);
    for (int32_t y = rect.y0; y < rect.y1; y++)
        sum_line(&down, spike_limits_at(s, rect.x0, y), width, at_max(reach, y - s->rect.y0),
                 at_max(reach, s->rect.y1 - 1 - y), s->sum, s->count);
}

static void bound_rows(const struct spike_limits *s, struct rect rect, bool limited)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = spike_limits_at(s, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            s->bounded[i] = limited && s->light[i] > s->limit[i] ? s->limit[i] : s->light[i];
    }
}

static void limit_rows(const struct spike_limits *s, struct rect rect, float times)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = spike_limits_at(s, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            s->limit[i] = s->count[i] > 0.0f ? times * s->sum[i] / s->count[i] : 0.0f;
    }
}

void spike_limits_find(const struct spike_limits *s, struct rect rect, int32_t reach_px,
                       float times)
{
    for (int step = 1; step >= 0; step--) {
        const struct rect to = rect_intersect(rect_grow(rect, step * reach_px), s->rect);
        bound_rows(s, rect_intersect(rect_grow(to, reach_px), s->rect), step == 0);
        sum_windows(s, s->bounded, to, reach_px);
        limit_rows(s, to, times);
    }
}

void spike_limits_smooth(const struct spike_limits *s, struct rect rect, int32_t reach_px,
                         float *light)
{
    sum_windows(s, light, rect, reach_px);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = spike_limits_at(s, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            light[i] = s->count[i] > 0.0f ? s->sum[i] / s->count[i] : 0.0f;
    }
}
