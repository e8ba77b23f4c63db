#include "server/reconstruct/residual/residual_spikes.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/patch/spike_limits.h"

/* Limits over the light around, and over that of the other half. */
#define TIMES       12.0f
#define TIMES_OTHER 2.0f
#define WINDOW_PX   8

/* The knee of guides, over the light around. */
#define KNEE_TIMES 3.0f

/* Excess is read step by step, over a Gaussian that ends after so many; means over a step before
 * and after leave no trace of the steps. */
#define STEP     5
#define TAPS     8
#define ONE_STEP 0.952344799 /* exp(-x^2 / 2) for x = 2.5 / TAPS */

/* Differences at which features have nothing in common. */
#define TURN_MAX    0.3f  /* square of the way from a normal to another */
#define DEPTH_SHARE 0.06f /* of the depth, beyond what slopes tell */

_Static_assert(RESIDUAL_SPIKES_SPREAD_PX >= STEP * TAPS + STEP / 2 * 2, "the spread's reach");
_Static_assert(RESIDUAL_SPIKES_LIMIT_PX >= 2 * WINDOW_PX, "the limits' reach");
_Static_assert(RESIDUAL_PAD_PX >= WINDOW_PX + SIMD_LANES, "margins");

/* Excess of each component, and the variance of its channels' sum. */
enum { EXCESS = 3 * RESIDUAL_COMPONENTS, PLANES = EXCESS + RESIDUAL_COMPONENTS };

_Static_assert(EXCESS + SPIKE_ARRAYS == 6 * RESIDUAL_COMPONENTS + 1, "planes to borrow");

/* Work on one patch, in planes that the passes have no use for yet. */
struct work {
    const struct residual_features *f;
    struct spike_limits limits;
    float *spread[PLANES], *between[PLANES];
};

/* How much features of pixels i and j have in common, for `way` pixels along a slope. */
static float alike(const struct residual_features *f, const float *slope, size_t i, size_t j,
                   float way)
{
    const size_t n = f->shape.plane;
    const float *x = f->normal, *y = x + n, *z = y + n, *d = f->depth;
    const float a = x[i] - x[j], b = y[i] - y[j], c = z[i] - z[j];
    const float turn = a * a + b * b + c * c, along = slope[i] * way;
    const float off = (d[j] - d[i] - along) / (DEPTH_SHARE * d[i] + fabsf(along) + 1e-30f);
    const float left = 1.0f - turn / TURN_MAX - off * off - f->barred[i] - f->barred[j];
    return left > 0.0f ? left : 0.0f;
}

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
                !last && alike(f, f->slope_x, i, i + 1, 1.0f) > 0.0f ? 1.0f : 0.0f;
            w->limits.link_y[i] =
                below && alike(f, f->slope_y, i, i + s->stride, 1.0f) > 0.0f ? 1.0f : 0.0f;
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

static void split_pixel(const struct work *w, const struct residual_light *l, size_t i,
                        float *const excess[3])
{
    const size_t plane = w->f->shape.plane;
    const float own[2] = {light_of(l->half[0], plane, i), light_of(l->half[1], plane, i)};
    const float share[2] = {w->f->share[i], 1.0f - w->f->share[i]};
    for (int h = 0; h < 2; h++) {
        const float other = TIMES_OTHER * own[1 - h], around = w->limits.limit[i];
        const float limit = other > around ? other : around;
        if (own[h] > limit) split_half(l, h, plane, i, limit / own[h], share[h], excess);
    }
}

/* Returns whether a half may be above its limit. Where there are no halves, both are the mean. */
static bool may_be_spike(const struct work *w, size_t i)
{
    const float share = w->f->share[i], rest = 1.0f - share;
    const float least = share < rest ? share : rest;
    return share > 0.0f && w->limits.light[i] > least * w->limits.limit[i];
}

static bool split_component(const struct work *w, const struct residual_light *l,
                            float *const excess[3])
{
    const struct residual_shape *s = &w->f->shape;
    bool any = false;
    find_light(w, l);
    spike_limits_find(&w->limits, w->limits.rect, WINDOW_PX, TIMES);
    for (int32_t y = 0; y < s->height; y++) {
        const size_t first = residual_at(s, 0, y);
        for (size_t i = first; i < first + (size_t)s->width; i++) {
            if (!may_be_spike(w, i)) continue;
            split_pixel(w, l, i, excess);
            any = true;
        }
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

static bool split(const struct work *w, struct residual_field *field)
{
    bool any = false;
    link_rows(w);
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        const bool found = split_component(w, &field->light[c], w->spread + 3 * c);
        if (field->light[c].knee) find_knee(w, &field->light[c]);
        if (!found) continue;
        for (int h = 0; h < 2; h++) residual_pad(&w->f->shape, field->light[c].half[h], 3);
        any = true;
    }
    return any;
}

/* -- spread -- */

/* A line of receivers. */
struct line {
    const struct work *w;
    const float *slope;
    ptrdiff_t step;      /* of TAPS to each side: STEP pixels along x or y */
    int32_t first, last; /* taps that there are */
    float gauss[TAPS + 1];
};

static bool any_near(const struct line *l, size_t p)
{
    for (int32_t t = l->first; t <= l->last; t++) {
        const float *there = l->w->limits.light + (ptrdiff_t)p + t * l->step;
        float sum = 0.0f;
        for (int i = 0; i < SIMD_LANES; i++) sum += there[i];
        if (sum > 0.0f) return true;
    }
    return false;
}

/* Weights of tap t of the receivers from p on. */
static void weigh(const struct line *l, size_t p, int32_t t, float weight[SIMD_LANES])
{
    const float gauss = l->gauss[t < 0 ? -t : t];
    const size_t q = (size_t)((ptrdiff_t)p + t * l->step);
    for (size_t i = 0; i < SIMD_LANES; i++) {
        const float same = alike(l->w->f, l->slope, p + i, q + i, (float)(t * STEP));
        weight[i] = gauss * same * same;
    }
}

/* Means of all planes over the receivers from p on and their taps. */
static void mean_lanes(const struct line *l, size_t p, float *const in[PLANES],
                       float *const out[PLANES])
{
    float sum[PLANES][SIMD_LANES], total[SIMD_LANES], weight[SIMD_LANES], square[SIMD_LANES];
    for (int i = 0; i < SIMD_LANES; i++) total[i] = 1.0f;
    for (size_t k = 0; k < PLANES; k++) memcpy(sum[k], in[k] + p, sizeof sum[k]);
    for (int32_t t = l->first; t <= l->last; t++) {
        if (t == 0) continue;
        weigh(l, p, t, weight);
        for (int i = 0; i < SIMD_LANES; i++) total[i] += weight[i];
        for (int i = 0; i < SIMD_LANES; i++) square[i] = weight[i] * weight[i];
        for (size_t k = 0; k < PLANES; k++) {
            const float *there = in[k] + (ptrdiff_t)p + t * l->step;
            const float *by = k < EXCESS ? weight : square;
            for (int i = 0; i < SIMD_LANES; i++) sum[k][i] += by[i] * there[i];
        }
    }
    for (int i = 0; i < SIMD_LANES; i++) square[i] = total[i] * total[i];
    for (size_t k = 0; k < PLANES; k++)
        for (size_t i = 0; i < SIMD_LANES; i++)
            out[k][p + i] = sum[k][i] / (k < EXCESS ? total[i] : square[i]);
}

static void find_present(const struct work *w, struct rect r, float *const in[PLANES])
{
    const struct residual_shape *s = &w->f->shape;
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t first = residual_at(s, r.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(r); i++) {
            float sum = 0.0f;
            for (size_t k = 0; k < EXCESS; k++) sum += fabsf(in[k][i]);
            w->limits.light[i] = sum;
        }
    }
}

/* ONE_STEP to the square of steps; the C library's powers have other bits on other CPUs. */
static void fill_gauss(float gauss[TAPS + 1])
{
    double at = 1.0, ratio = ONE_STEP;
    for (int32_t t = 0; t <= TAPS; t++) {
        gauss[t] = (float)at;
        at *= ratio;
        ratio *= ONE_STEP * ONE_STEP;
    }
}

static int32_t taps_within(int32_t px)
{
    return px / STEP < TAPS ? px / STEP : TAPS;
}

static void mean_rows(const struct work *w, struct rect r, bool along_x, float *const in[PLANES],
                      float *const out[PLANES])
{
    const struct residual_shape *s = &w->f->shape;
    struct line l = {.w = w,
                     .slope = along_x ? w->f->slope_x : w->f->slope_y,
                     .step = STEP * (along_x ? 1 : (ptrdiff_t)s->stride)};
    fill_gauss(l.gauss);
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t first = residual_at(s, r.x0, y);
        l.first = along_x ? -TAPS : -taps_within(y);
        l.last = along_x ? TAPS : taps_within(s->height - 1 - y);
        for (size_t p = first; p < first + (size_t)rect_width(r); p += SIMD_LANES)
            if (any_near(&l, p))
                mean_lanes(&l, p, in, out);
            else
                for (size_t k = 0; k < PLANES; k++)
                    memset(out[k] + p, 0, SIMD_LANES * sizeof(float));
    }
}

static void smooth(const struct work *w, struct rect rect)
{
    for (size_t k = 0; k < PLANES; k++)
        spike_limits_smooth(&w->limits, rect, STEP / 2, w->spread[k]);
}

/* The variance of a mean over a step: spikes come by chance, so that each adds its square. */
static void find_variance(const struct work *w, struct rect r)
{
    const struct residual_shape *s = &w->f->shape;
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t first = residual_at(s, r.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(r); i++)
            for (size_t c = 0; c < RESIDUAL_COMPONENTS; c++) {
                float *const *e = w->spread + 3 * c;
                const float sum = fabsf(e[0][i]) + fabsf(e[1][i]) + fabsf(e[2][i]);
                w->spread[EXCESS + c][i] = sum / (STEP * STEP) * sum;
            }
    }
}

static void spread(const struct work *w, struct rect area)
{
    const struct rect inner = rect_intersect(rect_grow(area, STEP / 2), w->limits.rect);
    const struct rect wide = rect_intersect(rect_grow(inner, STEP * TAPS), w->limits.rect);
    const struct rect tall = {inner.x0, wide.y0, inner.x1, wide.y1};
    find_variance(w, w->limits.rect);
    smooth(w, wide);
    find_present(w, wide, w->spread);
    mean_rows(w, tall, true, w->spread, w->between);
    find_present(w, tall, w->between);
    mean_rows(w, inner, false, w->between, w->spread);
    smooth(w, area);
}

/* Planes of the passes' results, all zero. */
static void borrow(const struct residual_field *field, struct work *w)
{
    const struct residual_shape *s = &field->features.shape;
    float *free[EXCESS + SPIKE_ARRAYS];
    size_t count = 0;
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
        for (int h = 0; h < 2; h++)
            for (size_t k = 0; k < 3; k++)
                free[count++] = field->light[c].filtered[h] + k * s->plane;
    free[count++] = field->light[0].guide[0];
    for (size_t k = 0; k < count; k++) memset(free[k], 0, s->plane * sizeof(float));
    memcpy(w->between, free, EXCESS * sizeof *free);
    spike_limits_take(&w->limits, free + EXCESS);
}

int residual_spikes_take(struct residual_field *field, struct rect area,
                         struct residual_spikes *out)
{
    const struct residual_shape *s = &field->features.shape;
    float *memory =
        scratch_take(field->scratch, (PLANES + RESIDUAL_COMPONENTS) * s->plane * sizeof *memory);
    *out = (struct residual_spikes){.scratch = field->scratch, .memory = memory};
    if (!memory) return ERR_MEMORY;
    struct work w = {
        .f = &field->features,
        .limits = {.rect = {0, 0, s->width, s->height}, .origin = s->origin, .stride = s->stride}};
    memset(memory, 0, (PLANES + RESIDUAL_COMPONENTS) * s->plane * sizeof *memory);
    for (size_t k = 0; k < PLANES; k++) w.spread[k] = memory + k * s->plane;
    for (size_t k = EXCESS; k < PLANES; k++)
        w.between[k] = memory + (k + RESIDUAL_COMPONENTS) * s->plane;
    borrow(field, &w);
    if (!split(&w, field)) return 0;
    spread(&w, area);
    out->excess = memory;
    out->variance = memory + EXCESS * s->plane;
    return 0;
}

void residual_spikes_fini(struct residual_spikes *s)
{
    scratch_give(s->scratch, s->memory);
    *s = (struct residual_spikes){NULL};
}
