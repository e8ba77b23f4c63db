#include "server/reconstruct/residual/residual_spikes.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/residual/residual_spread.h"

/* Limits over the light around, and over that of the other half. */
#define TIMES       12.0f
#define TIMES_OTHER 2.0f
#define WINDOW_PX   8

/* The knee of guides, over the light around. */
#define KNEE_TIMES 3.0f

_Static_assert(RESIDUAL_SPIKES_LIMIT_PX >= 3 * WINDOW_PX, "the limits' reach");
_Static_assert(RESIDUAL_PAD_PX >= WINDOW_PX + SIMD_LANES, "margins");

_Static_assert(SPIKE_ARRAYS + RESIDUAL_SPREAD_PLANES == 9 * RESIDUAL_COMPONENTS, "to borrow");

/* Work on one patch, in planes that the passes have no use for yet. */
struct work {
    const struct residual_features *f;
    struct spike_limits limits;
    float *scratch[RESIDUAL_SPREAD_PLANES];
};

static void link_rows(const struct work *w)
{
    const struct residual_features *f = w->f;
    const struct residual_shape *s = &f->shape;
    for (int32_t y = 0; y < s->height; y++) {
        const size_t first = residual_at(s, 0, y);
        for (size_t i = first; i < first + (size_t)s->width; i++) {
            const bool last = i + 1 == first + (size_t)s->width, below = y + 1 < s->height;
            w->limits.shown[i] = f->barred[i] > 0.0f ? 0.0f : 1.0f;
            w->limits.link_x[i] =
                !last && residual_alike(f, f->slope_x, i, i + 1, 1.0f) > 0.0f ? 1.0f : 0.0f;
            w->limits.link_y[i] =
                below && residual_alike(f, f->slope_y, i, i + s->stride, 1.0f) > 0.0f ? 1.0f : 0.0f;
        }
    }
}

static float light_of(const float *rgb, size_t plane, size_t i)
{
    return fabsf(rgb[i]) + fabsf(rgb[plane + i]) + fabsf(rgb[2 * plane + i]);
}

static void find_light(const struct work *w, const struct residual_light *l)
{
    const struct residual_shape *s = &w->f->shape;
    for (int32_t y = 0; y < s->height; y++) {
        const size_t first = residual_at(s, 0, y);
        for (size_t i = first; i < first + (size_t)s->width; i++) {
            const float a = light_of(l->half[0], s->plane, i),
                        b = light_of(l->half[1], s->plane, i);
            w->limits.light[i] = b + w->f->share[i] * (a - b);
        }
    }
}

/* Takes out what half h of pixel i has above its limit; `share` of the samples are in it. */
static void split_half(const struct residual_light *l, int h, size_t plane, size_t i, float kept,
                       float share, float *const excess[3])
{
    for (size_t c = 0; c < 3; c++) {
        float *half = l->half[h] + c * plane + i;
        const float all = *half;
        *half = all * kept;
        excess[c][i] += share * (all - *half);
    }
}

/* Of pixels around that have a half above the limit, so few in which the other is, too, are chance;
 * so many show narrow light. */
#define CHANCE_MOST 0.1f
#define LIGHT_LEAST 0.3f

static void light_of_halves(const struct work *w, const struct residual_light *l, size_t i,
                            float own[2])
{
    for (int h = 0; h < 2; h++) own[h] = light_of(l->half[h], w->f->shape.plane, i);
}

/* Finds how often both halves are above the limit and how often one is, over windows: as `bounded`
 * and `light` of the limits. Returns whether there is one. */
static bool find_agreement(const struct work *w, const struct residual_light *l)
{
    const struct spike_limits *s = &w->limits;
    bool any = false;
    for (int32_t y = s->rect.y0; y < s->rect.y1; y++) {
        const size_t first = spike_limits_at(s, s->rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(s->rect); i++) {
            float own[2];
            light_of_halves(w, l, i, own);
            const float most = own[0] > own[1] ? own[0] : own[1], least = own[0] + own[1] - most;
            const bool halves = w->f->share[i] > 0.0f;
            s->light[i] = halves && most > s->limit[i] ? most - s->limit[i] : 0.0f;
            s->bounded[i] = halves && least > s->limit[i] ? least - s->limit[i] : 0.0f;
            any |= s->light[i] > 0.0f;
        }
    }
    if (!any) return false;
    spike_limits_smooth(s, s->rect, WINDOW_PX, s->light);
    spike_limits_smooth(s, s->rect, WINDOW_PX, s->bounded);
    return true;
}

/* How far the other half's word counts. */
static float trust(const struct spike_limits *s, size_t i)
{
    const float share = s->bounded[i] / (s->light[i] + 1e-30f);
    const float t = (share - CHANCE_MOST) / (LIGHT_LEAST - CHANCE_MOST);
    return t > 0.0f ? (t < 1.0f ? t : 1.0f) : 0.0f;
}

static bool split_pixel(const struct work *w, const struct residual_light *l, size_t i,
                        float *const excess[3])
{
    float own[2];
    const float share[2] = {w->f->share[i], 1.0f - w->f->share[i]}, around = w->limits.limit[i];
    bool any = false;
    light_of_halves(w, l, i, own);
    if (!(share[0] > 0.0f) || !(own[0] > around || own[1] > around)) return false;
    const float times = TIMES_OTHER * trust(&w->limits, i);
    for (int h = 0; h < 2; h++) {
        const float other = times * own[1 - h], limit = other > around ? other : around;
        if (!(own[h] > limit)) continue;
        split_half(l, h, w->f->shape.plane, i, limit / own[h], share[h], excess);
        any = true;
    }
    return any;
}

static bool split_component(const struct work *w, const struct residual_light *l,
                            float *const excess[3])
{
    const struct residual_shape *s = &w->f->shape;
    bool any = false;
    for (int32_t y = 0; y < s->height; y++) {
        const size_t first = residual_at(s, 0, y);
        for (size_t i = first; i < first + (size_t)s->width; i++)
            any |= split_pixel(w, l, i, excess);
    }
    return any;
}

static void find_knee(const struct work *w, const struct residual_light *l)
{
    const struct residual_shape *s = &w->f->shape;
    for (int32_t y = 0; y < s->height; y++) {
        const size_t first = residual_at(s, 0, y);
        for (size_t i = first; i < first + (size_t)s->width; i++)
            l->knee[i] = KNEE_TIMES / TIMES * w->limits.limit[i];
    }
    residual_pad(s, l->knee, 1);
}

/* Most fields have no spikes, and need no memory for them. */
static int take_excess(const struct residual_field *field, struct residual_spikes *out)
{
    const size_t count = 3 * RESIDUAL_COMPONENTS * field->features.shape.plane;
    if (out->memory) return 0;
    out->memory = scratch_take(field->scratch, count * sizeof *out->memory);
    if (!out->memory) return ERR_MEMORY;
    memset(out->memory, 0, count * sizeof *out->memory);
    return 0;
}

/* Takes the component's spikes out, and spreads what they have beyond their limits. */
static int split(const struct work *w, const struct residual_field *field,
                 enum residual_component c, struct rect area, struct residual_spikes *out)
{
    const struct residual_light *light = &field->light[c];
    const size_t plane = w->f->shape.plane;
    find_light(w, light);
    spike_limits_find(&w->limits, w->limits.rect, WINDOW_PX, TIMES);
    if (light->knee) find_knee(w, light);
    if (!find_agreement(w, light)) return 0;
    if (take_excess(field, out)) return ERR_MEMORY;
    float *const first = out->memory + 3 * c * plane;
    float *const excess[3] = {first, first + plane, first + 2 * plane};
    if (!split_component(w, light, excess)) return 0;
    for (int h = 0; h < 2; h++) residual_pad(&w->f->shape, light->half[h], 3);
    residual_spread(w->f, c, &w->limits, area, w->scratch, excess);
    out->excess = out->memory;
    return 0;
}

/* Planes that the passes have no use for yet, all zero. */
static void borrow(const struct residual_field *field, struct work *w)
{
    const struct residual_shape *s = &field->features.shape;
    float *free[SPIKE_ARRAYS + RESIDUAL_SPREAD_PLANES];
    size_t count = 0;
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        const struct residual_light *light = &field->light[c];
        for (int h = 0; h < 2; h++) {
            for (size_t k = 0; k < 3; k++) free[count++] = light->filtered[h] + k * s->plane;
            free[count++] = light->guide[h];
        }
        free[count++] = light->variance;
    }
    for (size_t k = 0; k < count; k++) memset(free[k], 0, s->plane * sizeof(float));
    spike_limits_take(&w->limits, free);
    memcpy(w->scratch, free + SPIKE_ARRAYS, sizeof w->scratch);
}

int residual_spikes_take(struct residual_field *field, struct rect area,
                         struct residual_spikes *out)
{
    const struct residual_shape *s = &field->features.shape;
    int error = 0;
    *out = (struct residual_spikes){.scratch = field->scratch};
    struct work w = {
        .f = &field->features,
        .limits = {.rect = {0, 0, s->width, s->height}, .origin = s->origin, .stride = s->stride}};
    borrow(field, &w);
    link_rows(&w);
    for (enum residual_component c = 0; c < RESIDUAL_COMPONENTS && !error; c++)
        error = split(&w, field, c, area, out);
    return error;
}

void residual_spikes_fini(struct residual_spikes *s)
{
    scratch_give(s->scratch, s->memory);
    *s = (struct residual_spikes){NULL};
}
