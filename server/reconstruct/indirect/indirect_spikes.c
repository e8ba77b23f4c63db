#include "server/reconstruct/indirect/indirect_spikes.h"

#include <math.h>

#include "server/reconstruct/indirect/indirect_pass.h"

/* Times the light around at 16 samples a pixel and fewer; the cube root of more as many times. */
#define TIMES         4.0f
#define TIMES_SAMPLES 16.0f

/* Half a window's side over beta: as many pixels as a Gaussian's weights come to, squared. */
#define WINDOW_BETAS 1.77f
#define WINDOW_MAX   12.0f

/* What is taken out is spread over a Gaussian that ends after so many steps. A step of S pixels is
 * odd; means over S pixels before and after it leave no trace of the steps. */
#define TAPS       8
#define STEP_MIN   5
#define STEP_MAX   9
#define STEP_BETAS 0.6f /* of the filter's widest: the Gaussian has twice its width */

static float times_of(const struct indirect_rule *rule)
{
    const float ratio = rule->samples / TIMES_SAMPLES;
    return TIMES * indirect_root(ratio > 1.0f ? ratio : 1.0f, 3);
}

static int32_t window_px(const struct indirect_rule *rule)
{
    return (int32_t)fminf(ceilf(WINDOW_BETAS * rule->most_px), WINDOW_MAX);
}

static int32_t step_px(const struct indirect_rule *rule)
{
    const int32_t px = (int32_t)(STEP_BETAS * fminf(rule->most_px, 64.0f)) | 1;
    return px < STEP_MIN ? STEP_MIN : px < STEP_MAX ? px : STEP_MAX;
}

static int32_t spread_px(const struct indirect_rule *rule)
{
    const int32_t step = step_px(rule);
    return TAPS * step + step / 2 * 2;
}

int32_t indirect_spikes_reach(const struct indirect_rule *rule)
{
    const float side = 2.0f * (float)window_px(rule) + 1.0f;
    if (!(rule->samples > 0.0f) || side * side <= times_of(rule)) return 0;
    return spread_px(rule) + spike_limits_reach(window_px(rule));
}

uint32_t indirect_spikes_spares(uint32_t count)
{
    return SPIKE_ARRAYS + 2 * count;
}

/* What spikes of channel c have too much; `count` arrays on, what is between the passes. */
static float *excess(const struct indirect_spikes *s, uint32_t c)
{
    return indirect_neighbourhood_spare(s->around, s->first + SPIKE_ARRAYS + c);
}

static struct spike_limits limits_of(const struct indirect_spikes *s)
{
    const struct indirect_neighbourhood *a = s->around;
    struct spike_limits l = {
        .rect = a->rect, .origin = a->origin, .stride = (size_t)a->field.stride};
    float *arrays[SPIKE_ARRAYS];
    for (uint32_t k = 0; k < SPIKE_ARRAYS; k++)
        arrays[k] = indirect_neighbourhood_spare(a, s->first + k);
    spike_limits_take(&l, arrays);
    return l;
}

/* -- split -- */

/* Links pixels i and i + step of a row. */
static void link_row(const struct indirect_neighbourhood *a, size_t first, size_t count,
                     size_t step, float *link)
{
    const struct indirect_field *f = &a->field;
    for (size_t i = first; i < first + count; i++) {
        const size_t j = i + step;
        const float alike = f->normal[0][i] * f->normal[0][j] + f->normal[1][i] * f->normal[1][j] +
                            f->normal[2][i] * f->normal[2][j];
        link[i] = f->object[i] == f->object[j] && alike >= INDIRECT_COS ? 1.0f : 0.0f;
    }
}

static void load_row(const struct indirect_spikes *s, const struct spike_limits *l, int32_t y)
{
    const struct indirect_neighbourhood *a = s->around;
    const size_t width = (size_t)rect_width(a->rect), first = spike_limits_at(l, a->rect.x0, y);
    for (size_t i = first; i < first + width; i++) {
        l->light[i] = s->channel[0][i] + s->channel[1][i] + s->channel[2][i];
        l->shown[i] = a->pixel[i] > 0.0f ? 1.0f : 0.0f;
    }
    link_row(a, first, width - 1, 1, l->link_x);
    if (y + 1 < a->rect.y1) link_row(a, first, width, l->stride, l->link_y);
}

static void split_pixel(struct indirect_spikes *s, size_t i, float kept)
{
    for (uint32_t c = 0; c < s->count; c++) {
        const float all = s->channel[c][i];
        s->channel[c][i] = all * kept;
        excess(s, c)[i] = all - s->channel[c][i];
    }
    s->any = true;
}

void indirect_spikes_split(const struct indirect_rule *rule, struct indirect_spikes *s)
{
    const struct indirect_neighbourhood *a = s->around;
    const struct rect rect = rect_intersect(rect_grow(s->rect, spread_px(rule)), a->rect);
    struct spike_limits l = limits_of(s);
    s->any = false;
    for (int32_t y = a->rect.y0; y < a->rect.y1; y++) load_row(s, &l, y);
    spike_limits_find(&l, rect, window_px(rule), times_of(rule));
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = spike_limits_at(&l, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            if (l.light[i] > l.limit[i]) split_pixel(s, i, l.limit[i] / l.light[i]);
    }
}

/* -- spread -- */

static void set_width(const struct indirect_spikes *s, const struct indirect_rule *rule,
                      float *beta)
{
    const struct indirect_neighbourhood *a = s->around;
    const struct indirect_rule wide = {.off_px = rule->off_px};
    const float px = (float)(TAPS * step_px(rule)) / 2.5f;
    for (size_t i = 0; i < a->area; i++) beta[i] = px * a->pixel[i];
    indirect_set_widths(&wide, s->around, a->rect, beta, 1.0f);
}

static void run_steps(const struct indirect_spikes *s, int32_t step, struct rect rect, bool along_x,
                      const float *const *in, float *const *out)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        struct indirect_run run =
            indirect_neighbourhood_run(s->around, rect, y, along_x, TAPS * step);
        run.step *= step;
        run.before /= step;
        run.after /= step;
        s->kernels->mean(&s->around->field, &run, s->count, in, out);
    }
}

static void smooth(const struct indirect_spikes *s, const struct spike_limits *l, struct rect rect,
                   int32_t reach_px)
{
    for (uint32_t c = 0; c < s->count; c++) spike_limits_smooth(l, rect, reach_px, excess(s, c));
}

static void spread(const struct indirect_rule *rule, const struct indirect_spikes *s)
{
    const struct indirect_neighbourhood *a = s->around;
    const struct spike_limits l = limits_of(s);
    const int32_t step = step_px(rule), reach = TAPS * step;
    const struct rect inner = rect_intersect(rect_grow(s->rect, step / 2), a->rect);
    float *between[INDIRECT_SPIKES_MAX], *taken[INDIRECT_SPIKES_MAX];
    for (uint32_t c = 0; c < s->count; c++) {
        taken[c] = excess(s, c);
        between[c] = excess(s, s->count + c);
    }
    smooth(s, &l, rect_intersect(rect_grow(inner, reach), a->rect), step / 2);
    set_width(s, rule, l.limit);
    run_steps(s, step, indirect_pass_tall(a, inner, reach), true, (const float *const *)taken,
              between);
    run_steps(s, step, inner, false, (const float *const *)between, taken);
    smooth(s, &l, s->rect, step / 2);
}

void indirect_spikes_spread(const struct indirect_rule *rule, const struct indirect_spikes *s)
{
    const struct rect r = s->rect;
    if (!s->any) return;
    spread(rule, s);
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t first = indirect_neighbourhood_index(s->around, r.x0, y);
        for (uint32_t c = 0; c < s->count; c++)
            for (size_t i = first; i < first + (size_t)rect_width(r); i++)
                s->channel[c][i] += excess(s, c)[i];
    }
}
