#include "server/reconstruct/residual/residual_lone.h"

#include <math.h>

/* What stands out by so many standard deviations of its noise is drawn in by half. What lobes show
 * has details of a pixel. */
static const float deviations[RESIDUAL_COMPONENTS] = {2.5f, 2.5f, 1.0f};

/* Pixels of a row that are worked on at a time. */
#define RUN_PX 256

/* The planes of one channel of a component. */
struct channel {
    const struct residual_features *f;
    const float *light;         /* after the last pass */
    const float *mean, *half_b; /* before it: of both halves, and of half b */
    float *out;
    float deviations;
};

/* A run of pixels and one on each side. Those that are not filtered count for nothing. */
struct run {
    float low[RUN_PX + 2], high[RUN_PX + 2]; /* light, or what no other light is above or below */
    float deviation[RUN_PX + 2], count[RUN_PX + 2];
};

/* Reads `count` pixels from i on. The deviation is that of the mean which the second pass left:
 * half b is off by `share` (b - a), and where the mean has the variance v, b - a has v / (share (1
 * - share)). */
static void read_run(const struct channel *c, size_t i, size_t count, struct run *restrict r)
{
    const float *restrict barred = c->f->barred + i, *restrict share = c->f->share + i;
    const float *restrict light = c->light + i, *restrict mean = c->mean + i;
    const float *restrict half_b = c->half_b + i;
    for (size_t x = 0; x < count; x++) {
        const int on = (barred[x] == 0.0f) & (share[x] > 0.0f);
        const float off = half_b[x] - mean[x], part = on ? share[x] : 1.0f;
        r->low[x] = on ? light[x] : INFINITY;
        r->high[x] = on ? light[x] : -INFINITY;
        r->deviation[x] = (off > 0.0f ? off : -off) * sqrtf((1.0f - part) / part);
        r->count[x] = on ? 1.0f : 0.0f;
    }
}

static inline float least(float a, float b)
{
    return a < b ? a : b;
}

static inline float most(float a, float b)
{
    return a > b ? a : b;
}

/* Returns what is left of the pixel at x + 1 of the middle run. */
static inline float drawn_in(const struct run *a, const struct run *b, const struct run *d,
                             size_t x, float light, float times)
{
    const size_t y = x + 1, z = x + 2;
    const float low = least(least(least(a->low[x], a->low[y]), least(a->low[z], b->low[x])),
                            least(least(b->low[z], d->low[x]), least(d->low[y], d->low[z])));
    const float high = most(most(most(a->high[x], a->high[y]), most(a->high[z], b->high[x])),
                            most(most(b->high[z], d->high[x]), most(d->high[y], d->high[z])));
    const float count = a->count[x] + a->count[y] + a->count[z] + b->count[x] + b->count[y] +
                        b->count[z] + d->count[x] + d->count[y] + d->count[z];
    const float sum = a->deviation[x] + a->deviation[y] + a->deviation[z] + b->deviation[x] +
                      b->deviation[y] + b->deviation[z] + d->deviation[x] + d->deviation[y] +
                      d->deviation[z];
    const float inside = most(least(light, high), low);
    const float out = light - inside;
    const float ratio = out / (times * most(b->deviation[y], sum / count)), square = ratio * ratio;
    const float left = light - out * (1.0f / (1.0f + square * square));
    return (count > 1.0f) & (b->count[y] > 0.0f) & (out != 0.0f) & (square < INFINITY) ? left
                                                                                       : light;
}

static void draw_run(const struct channel *c, size_t first, size_t count, size_t height)
{
    struct run runs[3];
    const size_t stride = c->f->shape.stride;
    read_run(c, first - stride - 1, count + 2, &runs[0]);
    read_run(c, first - 1, count + 2, &runs[1]);
    for (size_t y = 0; y < height; y++, first += stride) {
        const struct run *a = &runs[y % 3], *b = &runs[(y + 1) % 3], *d = &runs[(y + 2) % 3];
        read_run(c, first + stride - 1, count + 2, &runs[(y + 2) % 3]);
        for (size_t x = 0; x < count; x++)
            c->out[first + x] = drawn_in(a, b, d, x, c->light[first + x], c->deviations);
    }
}

void residual_lone_draw_in(struct residual_field *field, struct rect area)
{
    const struct residual_shape *s = &field->features.shape;
    const size_t width = (size_t)rect_width(area), height = (size_t)rect_height(area);
    for (int k = 0; k < RESIDUAL_COMPONENTS; k++) {
        struct residual_light *l = &field->light[k];
        float *const light = l->half[0];
        for (size_t c = 0; c < 3; c++) {
            const size_t at = c * s->plane, first = residual_at(s, area.x0, area.y0);
            const struct channel channel = {&field->features,    light + at,
                                            l->filtered[0] + at, l->half[1] + at,
                                            l->filtered[1] + at, deviations[k]};
            for (size_t x = 0; x < width; x += RUN_PX)
                draw_run(&channel, first + x, width - x < RUN_PX ? width - x : RUN_PX, height);
        }
        l->half[0] = l->filtered[1];
        l->filtered[1] = light;
    }
}
