#include "server/reconstruct/patch/spike_limits.h"

#include "server/reconstruct/patch/spike_limits_kernels.h"

void spike_limits_take(struct spike_limits *s, float *const arrays[SPIKE_ARRAYS])
{
    float **const all[SPIKE_ARRAYS] = {&s->light, &s->shown,   &s->link_x, &s->link_y,
                                       &s->limit, &s->bounded, &s->along,  &s->along_count,
                                       &s->sum,   &s->count};
    for (int k = 0; k < SPIKE_ARRAYS; k++) *all[k] = arrays[k];
}

static int32_t at_max(int32_t v, int32_t most)
{
    return v < most ? v : most;
}

/* Sums windows of `in` along x, then along y. */
static void sum_windows(const struct spike_limits *s, const float *in, struct rect rect,
                        int32_t reach)
{
    const struct spike_limits_kernels *kernels = KERNELS_BEST(spike_limits_kernels);
    const struct spike_limits_line across = {in, s->shown, s->link_x, 1, reach, reach};
    struct spike_limits_line down = {
        .in = s->along, .counts = s->along_count, .link = s->link_y, .step = (ptrdiff_t)s->stride};
    const struct rect read = rect_intersect(rect_grow(rect, reach), s->rect);
    const size_t width = (size_t)rect_width(rect);
    for (int32_t y = read.y0; y < read.y1; y++)
        kernels->sum_line(&across, spike_limits_at(s, rect.x0, y), width, s->along, s->along_count);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        down.before = at_max(reach, y - s->rect.y0);
        down.after = at_max(reach, s->rect.y1 - 1 - y);
        kernels->sum_line(&down, spike_limits_at(s, rect.x0, y), width, s->sum, s->count);
    }
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
