#include "server/reconstruct/residual/residual_spread.h"

#include <math.h>
#include <string.h>

/* Means over BASE x BASE linked pixels, then over such means, each time from farther away. */
#define BASE   5
#define LEVELS 4
#define TAPS   2 /* on each side */

/* Pixels to each side that tell what one does not know for itself. */
#define AROUND 2

static const struct level {
    int32_t step_px;
    float weight[TAPS + 1]; /* of the pixel and of those on each side */
    float squares;          /* sum of squared weights over the square of their sum */
    float lower;            /* variances along an axis, over those before, where all taps count */
} levels[LEVELS] = {{.step_px = 0, .lower = 1.0f},
                    {5, {6, 4, 1}, 0.2734f, 0.2734f},
                    {10, {6, 4, 1}, 0.2734f, 0.4516f},
                    {15, {2, 1, 0}, 0.375f, 0.7263f}};

/* So many equal spikes and fewer say nothing: their light may be that of the whole picture. */
#define SPIKES_MIN 2.0f

/* How far the square of a difference between levels must be above its variance to be no chance. */
#define NO_CHANCE 4.0f

/* What a lobe shows is the same within so many times its roughness, as an angle of view. */
#define LOBE_WIDTH 2.0f

/* Light of three channels, and the variance of their sum. */
enum { CHANNELS = 4, VARIANCE = 3 };

struct spread {
    const struct residual_features *f;
    const struct spike_limits *limits;
    float lobe_px2; /* square of the pixels that a lobe of roughness 1 shows alike; 0: of all */
    bool lobes;     /* lobes' directions count, too */
    float *mean[LEVELS][CHANNELS], *between[CHANNELS];
    float *known[3]; /* of the widest mean, what is known of it */
    float *few;      /* variance of the widest mean over that of a single pixel */
};

_Static_assert(RESIDUAL_SPREAD_PLANES == CHANNELS * (LEVELS + 1) - 3, "scratch");
_Static_assert(RESIDUAL_SPREAD_PX >= 2 * (BASE / 2) + AROUND + TAPS * (5 + 10) + 15, "its reach");

/* -- means -- */

/* A line of receivers. */
struct line {
    const struct spread *s;
    const struct level *level;
    const float *slope;
    ptrdiff_t step;
    int32_t first, last; /* taps that there are */
};

static bool any_near(const struct line *l, size_t p)
{
    for (int32_t t = l->first; t <= l->last; t++) {
        const float *there = l->s->limits->light + (ptrdiff_t)p + t * l->step;
        float sum = 0.0f;
        for (int i = 0; i < SIMD_LANES; i++) sum += there[i];
        if (sum > 0.0f) return true;
    }
    return false;
}

struct sums {
    float of[CHANNELS][SIMD_LANES], total[SIMD_LANES], squares[SIMD_LANES];
};

/* How much smooth lobes of pixels i and j differ in what they show, `way` pixels apart. */
static float apart(const struct spread *s, size_t i, size_t j, float way)
{
    const struct residual_features *f = s->f;
    const size_t n = f->shape.plane;
    const float *x = f->normal, *y = x + n, *z = y + n;
    const float a = x[i] - x[j], b = y[i] - y[j], c = z[i] - z[j];
    const float width2 = s->lobe_px2 * f->alpha[i] * f->alpha[j] + 1.0f;
    const float far = s->lobe_px2 > 0.0f ? way * way / width2 : 0.0f;
    return f->gloss[i] * f->gloss[j] * (a * a + b * b + c * c) + far;
}

static float weigh(const struct line *l, size_t i, size_t j, float way)
{
    float same = residual_alike(l->s->f, l->slope, i, j, way);
    if (l->s->lobes) same = fmaxf(same - apart(l->s, i, j, way), 0.0f);
    return same * same;
}

static void add_tap(const struct line *l, size_t p, int32_t t, float *const in[CHANNELS],
                    struct sums *sums)
{
    const float most = l->level->weight[t < 0 ? -t : t], way = (float)(t * l->level->step_px);
    const size_t q = (size_t)((ptrdiff_t)p + t * l->step);
    float weight[SIMD_LANES];
    for (size_t i = 0; i < SIMD_LANES; i++) weight[i] = most * weigh(l, p + i, q + i, way);
    for (size_t i = 0; i < SIMD_LANES; i++) {
        sums->total[i] += weight[i];
        sums->squares[i] += weight[i] * weight[i];
    }
    for (size_t k = 0; k < CHANNELS; k++)
        for (size_t i = 0; i < SIMD_LANES; i++) sums->of[k][i] += weight[i] * in[k][q + i];
}

/* Means over the receivers from p on and their taps. Taps have spikes in common, so that variances
 * fall to `lower` where all count, and by less where fewer do. */
static void mean_lanes(const struct line *l, size_t p, float *const in[CHANNELS],
                       float *const out[CHANNELS])
{
    const float own = l->level->weight[0];
    struct sums sums;
    const float lower = (1.0f - l->level->lower) / (1.0f - l->level->squares);
    for (size_t i = 0; i < SIMD_LANES; i++) {
        sums.total[i] = own;
        sums.squares[i] = own * own;
    }
    for (size_t k = 0; k < CHANNELS; k++)
        for (size_t i = 0; i < SIMD_LANES; i++) sums.of[k][i] = own * in[k][p + i];
    for (int32_t t = l->first; t <= l->last; t++)
        if (t != 0) add_tap(l, p, t, in, &sums);
    for (size_t k = 0; k < CHANNELS; k++)
        for (size_t i = 0; i < SIMD_LANES; i++) out[k][p + i] = sums.of[k][i] / sums.total[i];
    for (size_t i = 0; i < SIMD_LANES; i++) {
        const float share = sums.squares[i] / (sums.total[i] * sums.total[i]);
        const float left = 1.0f - (1.0f - share) * lower;
        l->s->few[p + i] *= out[VARIANCE][p + i] > 0.0f ? left : l->level->lower;
        out[VARIANCE][p + i] *= left;
    }
}

static void clear_lanes(const struct line *l, size_t p, float *const out[CHANNELS])
{
    for (size_t k = 0; k < CHANNELS; k++) memset(out[k] + p, 0, SIMD_LANES * sizeof(float));
    for (size_t i = 0; i < SIMD_LANES; i++) l->s->few[p + i] *= l->level->lower;
}

static void find_present(const struct spread *s, struct rect r, float *const in[CHANNELS])
{
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t first = residual_at(&s->f->shape, r.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(r); i++)
            s->limits->light[i] = in[VARIANCE][i];
    }
}

static int32_t taps_within(int32_t px, int32_t step_px)
{
    return px / step_px < TAPS ? px / step_px : TAPS;
}

static void mean_rows(const struct spread *s, const struct level *level, struct rect r,
                      bool along_x, float *const in[CHANNELS], float *const out[CHANNELS])
{
    const struct residual_shape *shape = &s->f->shape;
    struct line l = {.s = s,
                     .level = level,
                     .slope = along_x ? s->f->slope_x : s->f->slope_y,
                     .step = level->step_px * (along_x ? 1 : (ptrdiff_t)shape->stride)};
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t first = residual_at(shape, r.x0, y);
        l.first = along_x ? -TAPS : -taps_within(y, level->step_px);
        l.last = along_x ? TAPS : taps_within(shape->height - 1 - y, level->step_px);
        for (size_t p = first; p < first + (size_t)rect_width(r); p += SIMD_LANES)
            if (any_near(&l, p))
                mean_lanes(&l, p, in, out);
            else
                clear_lanes(&l, p, out);
    }
}

/* How far a level's taps are. */
static int32_t reach_px(int level)
{
    return (levels[level].weight[TAPS] > 0.0f ? TAPS : TAPS - 1) * levels[level].step_px;
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
        find_present(s, to[k - 1], s->mean[k - 1]);
        mean_rows(s, &levels[k], tall, true, s->mean[k - 1], s->between);
        find_present(s, tall, s->between);
        mean_rows(s, &levels[k], to[k], false, s->between, s->mean[k]);
    }
}

/* -- what is known -- */

static float sum_of(const float rgb[3])
{
    return fabsf(rgb[0]) + fabsf(rgb[1]) + fabsf(rgb[2]);
}

/* How much of a square is more than `times` its variance. */
static float known_part(float square, float variance, float times)
{
    return square > times * variance ? 1.0f - times * variance / square : 0.0f;
}

static void know(const struct spread *s, size_t i)
{
    float *const *mean = s->mean[LEVELS - 1];
    const float rgb[3] = {mean[0][i], mean[1][i], mean[2][i]}, sum = sum_of(rgb);
    const float part = known_part(sum * sum, mean[VARIANCE][i], SPIKES_MIN);
    for (size_t c = 0; c < 3; c++) s->known[c][i] = part * rgb[c];
}

/* What the pixels around know, whatever they show. Returns its variance if they had as few pixels
 * to know it from as this one: an edge's have hardly any, and take it as it is. */
static float ask_around(const struct spread *s, size_t i, float found[3])
{
    const ptrdiff_t stride = (ptrdiff_t)s->f->shape.stride;
    float sum = 0.0f, variance = 0.0f, few = 0.0f;
    memset(found, 0, 3 * sizeof *found);
    for (ptrdiff_t y = -AROUND; y <= AROUND; y++)
        for (ptrdiff_t x = -AROUND; x <= AROUND; x++) {
            const size_t k = (size_t)((ptrdiff_t)i + y * stride + x);
            if (s->limits->shown[k] == 0.0f) continue;
            const float weight = 1.0f / s->few[k];
            sum += weight;
            few += 1.0f;
            variance += weight * s->mean[LEVELS - 1][VARIANCE][k];
            for (size_t c = 0; c < 3; c++) found[c] += weight * s->known[c][k];
        }
    if (sum == 0.0f) return 0.0f;
    for (size_t c = 0; c < 3; c++) found[c] /= sum;
    return variance / few * s->few[i];
}

/* From the widest mean to the narrowest: each is believed as far as it differs by more than
 * chance. Where a narrow one has no spikes, the wider one tells how uncertain that is. */
static void decide(const struct spread *s, size_t i, float *const excess[3])
{
    float found[3], expected = ask_around(s, i, found);
    for (int k = LEVELS - 1; k >= 0; k--) {
        float off[3];
        for (size_t c = 0; c < 3; c++) off[c] = s->mean[k][c][i] - found[c];
        const float own = s->mean[k][VARIANCE][i], way = sum_of(off);
        const float variance = own > expected ? own : expected;
        const float to = known_part(way * way, variance, NO_CHANCE);
        for (size_t c = 0; c < 3; c++) found[c] += to * off[c];
        expected = variance / (levels[k].lower * levels[k].lower);
    }
    for (size_t c = 0; c < 3; c++) excess[c][i] = found[c];
}

static void decide_all(const struct spread *s, struct rect area, float *const excess[3])
{
    const struct residual_shape *shape = &s->f->shape;
    const struct rect all = rect_intersect(rect_grow(area, AROUND), s->limits->rect);
    for (int32_t y = all.y0; y < all.y1; y++)
        for (int32_t x = all.x0; x < all.x1; x++) know(s, residual_at(shape, x, y));
    for (int32_t y = area.y0; y < area.y1; y++)
        for (int32_t x = area.x0; x < area.x1; x++) decide(s, residual_at(shape, x, y), excess);
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
                       .known = {limits->bounded, limits->along, limits->along_count},
                       .few = limits->sum};
    const struct rect wide = rect_intersect(rect_grow(area, BASE / 2), limits->rect);
    hand_out(&s, scratch, excess);
    begin(&s, excess);
    find_means(&s, rect_intersect(rect_grow(wide, AROUND), limits->rect));
    decide_all(&s, wide, excess);
    for (size_t c = 0; c < 3; c++) spike_limits_smooth(limits, area, BASE / 2, excess[c]);
}
