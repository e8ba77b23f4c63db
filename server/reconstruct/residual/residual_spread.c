#include "server/reconstruct/residual/residual_spread.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/residual/residual_spread_kernels.h"

/* Means over BASE x BASE linked pixels, then over such means, each time from farther away. */
#define BASE   5
#define LEVELS RESIDUAL_SPREAD_LEVELS
#define TAPS   RESIDUAL_SPREAD_TAPS

#define AROUND RESIDUAL_SPREAD_AROUND

static const struct residual_spread_level levels[LEVELS] = {{.step_px = 0, .lower = 1.0f},
                                                            {5, {6, 4, 1}, 0.2734f, 0.2734f},
                                                            {10, {6, 4, 1}, 0.2734f, 0.4516f},
                                                            {15, {2, 1, 0}, 0.375f, 0.7263f}};

/* What a lobe shows is the same within so many times its roughness, as an angle of view. */
#define LOBE_WIDTH 2.0f

#define CHANNELS RESIDUAL_SPREAD_CHANNELS
#define VARIANCE RESIDUAL_SPREAD_VARIANCE

struct spread {
    const struct residual_features *f;
    const struct spike_limits *limits;
    float lobe_px2; /* square of the pixels that a lobe of roughness 1 shows alike; 0: of all */
    bool lobes;     /* lobes' directions count, too */
    float *mean[LEVELS][CHANNELS], *between[CHANNELS];
    float *few; /* variance of the widest mean over that of a single pixel */
};

_Static_assert(RESIDUAL_SPREAD_PLANES == CHANNELS * (LEVELS + 1) - 3, "scratch");
_Static_assert(RESIDUAL_SPREAD_PX >= 2 * (BASE / 2) + AROUND + TAPS * (5 + 10) + 15, "its reach");

/* -- means -- */

/* How many taps to a side count. */
static int32_t taps_of(const struct residual_spread_level *level)
{
    return level->weight[TAPS] > 0.0f ? TAPS : TAPS - 1;
}

static int32_t taps_within(const struct residual_spread_level *level, int32_t px)
{
    return px / level->step_px < taps_of(level) ? px / level->step_px : taps_of(level);
}

static void mean_rows(const struct spread *s, const struct residual_spread_level *level,
                      struct rect r, bool along_x, float *const in[CHANNELS],
                      float *const out[CHANNELS])
{
    const struct residual_spread_kernels *kernels = KERNELS_BEST(residual_spread_kernels);
    const struct residual_shape *shape = &s->f->shape;
    struct residual_spread_line l = {.f = s->f,
                                     .level = level,
                                     .slope = along_x ? s->f->slope_x : s->f->slope_y,
                                     .step =
                                         level->step_px * (along_x ? 1 : (ptrdiff_t)shape->stride),
                                     .lobes = s->lobes,
                                     .lobe_px2 = s->lobe_px2,
                                     .few = s->few};
    for (int32_t y = r.y0; y < r.y1; y++) {
        l.first = along_x ? -taps_of(level) : -taps_within(level, y);
        l.last = along_x ? taps_of(level) : taps_within(level, shape->height - 1 - y);
        kernels->mean_row(&l, residual_at(shape, r.x0, y), (size_t)rect_width(r), in, out);
    }
}

/* How far a level's taps are. */
static int32_t reach_px(int level)
{
    return taps_of(&levels[level]) * levels[level].step_px;
}

/* Spikes come by chance, so that each adds its square to the variance of a mean. */
static void begin(const struct spread *s, float *const excess[3])
{
    const struct rect r = s->limits->rect;
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t first = residual_at(&s->f->shape, r.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(r); i++) {
            float sum = 0.0f;
            for (size_t c = 0; c < 3; c++) sum += fabsf(excess[c][i]);
            if (sum > RESIDUAL_GUIDE_MAX) sum = RESIDUAL_GUIDE_MAX;
            s->mean[0][VARIANCE][i] = sum / (BASE * BASE) * sum;
        }
    }
}

/* The pixels that base means are over. */
static void count_linked(const struct spread *s, struct rect r)
{
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t first = residual_at(&s->f->shape, r.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(r); i++)
            s->few[i] = s->limits->count[i] > 1.0f ? 1.0f / s->limits->count[i] : 1.0f;
    }
}

static void find_means(const struct spread *s, struct rect area)
{
    const struct rect all = s->limits->rect;
    struct rect to[LEVELS];
    to[LEVELS - 1] = area;
    for (int k = LEVELS - 1; k > 0; k--)
        to[k - 1] = rect_intersect(rect_grow(to[k], reach_px(k)), all);
    for (size_t k = 0; k < CHANNELS; k++)
        spike_limits_smooth(s->limits, to[0], BASE / 2, s->mean[0][k]);
    count_linked(s, to[0]);
    for (int k = 1; k < LEVELS; k++) {
        const struct rect tall = {to[k].x0, to[k - 1].y0, to[k].x1, to[k - 1].y1};
        mean_rows(s, &levels[k], tall, true, s->mean[k - 1], s->between);
        mean_rows(s, &levels[k], to[k], false, s->between, s->mean[k]);
    }
}

/* -- what is known -- */

static struct residual_spread_means means_of(const struct spread *s)
{
    const struct spike_limits *l = s->limits;
    struct residual_spread_means m = {.few = s->few,
                                      .shown = l->shown,
                                      .known = {l->bounded, l->along, l->along_count},
                                      .weight = s->between[0],
                                      .variance = s->between[1],
                                      .stride = s->f->shape.stride};
    memcpy(m.of, s->mean, sizeof m.of);
    for (size_t k = 0; k < LEVELS; k++) m.lower2[k] = levels[k].lower * levels[k].lower;
    return m;
}

/* Beside the picture nothing is shown, and nothing known. */
static void decide_all(const struct spread *s, struct rect area, float *const excess[3])
{
    const struct residual_spread_kernels *kernels = KERNELS_BEST(residual_spread_kernels);
    const struct residual_spread_means m = means_of(s);
    const struct rect all = rect_grow(area, AROUND);
    for (int32_t y = all.y0; y < all.y1; y++)
        kernels->know_row(&m, residual_at(&s->f->shape, all.x0, y), (size_t)rect_width(all));
    for (int32_t y = area.y0; y < area.y1; y++)
        kernels->decide_row(&m, residual_at(&s->f->shape, area.x0, y), (size_t)rect_width(area),
                            excess);
}

static void hand_out(struct spread *s, float *const scratch[RESIDUAL_SPREAD_PLANES],
                     float *const excess[3])
{
    for (size_t c = 0; c < 3; c++) s->mean[0][c] = excess[c];
    s->mean[0][VARIANCE] = *scratch++;
    for (size_t k = 0; k < CHANNELS; k++) s->between[k] = *scratch++;
    for (size_t k = CHANNELS; k < LEVELS * CHANNELS; k++)
        s->mean[k / CHANNELS][k % CHANNELS] = *scratch++;
}

void residual_spread(const struct residual_features *f, enum residual_component component,
                     const struct spike_limits *limits, struct rect area,
                     float *const scratch[RESIDUAL_SPREAD_PLANES], float *const excess[3])
{
    const float lobe_px = f->pixel_rad > 0.0f ? LOBE_WIDTH / f->pixel_rad : 0.0f;
    struct spread s = {.f = f,
                       .limits = limits,
                       .lobe_px2 = lobe_px * lobe_px,
                       .lobes = component == RESIDUAL_REST,
                       .few = limits->sum};
    const struct rect wide = rect_intersect(rect_grow(area, BASE / 2), limits->rect);
    hand_out(&s, scratch, excess);
    begin(&s, excess);
    find_means(&s, rect_intersect(rect_grow(wide, AROUND), limits->rect));
    decide_all(&s, wide, excess);
    for (size_t c = 0; c < 3; c++) spike_limits_smooth(limits, area, BASE / 2, excess[c]);
}
