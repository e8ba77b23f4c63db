#include "server/reconstruct/residual/residual_window.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/residual/residual_fetch.h"

/* Half the sides of the neighbourhoods whose means are compared. */
static const int32_t radii[] = {1, RESIDUAL_WINDOW_REACH_PX - 2};
enum { RADII = sizeof radii / sizeof radii[0] };

/* Squares of the difference of means over its variance: light counts in full up to the first, and
 * for nothing from the second on. */
#define ALIKE2 2.0f
#define OTHER2 6.0f

/* Numbers of the patch's pixels, row by row. */
struct work {
    const struct patch *patch;
    struct residual_field *field;
    size_t area;
    struct residual_fetched fetched;
    float *apart[2], *variance[2]; /* of a component's halves: differences of guides, and their
                                      variances */
    float *rows, *sums[2];         /* over boxes, of both of a half */
    float *worst;                  /* the largest over boxes of the squared difference */
    float *weight[2][RESIDUAL_COMPONENTS]; /* of all that has joined a half; the pixel's own is 1 */
    float *squares[2]; /* sums over frames: of squared shares, and of those times their taps */
    float (*joined[2])[RESIDUAL_HISTORY_LIGHT];
};

enum {
    FLOATS = 5 + RESIDUAL_COMPONENTS + 8 + 2 * RESIDUAL_COMPONENTS + 4 * RESIDUAL_HISTORY_LIGHT
};

static float *take(float **next, size_t count)
{
    float *at = *next;
    *next += count;
    return at;
}

static void *work_create(const struct patch *patch, struct residual_field *field, struct work *w)
{
    const size_t area = (size_t)rect_area(patch->rect);
    float *next = scratch_take(patch->scratch, FLOATS * area * sizeof *next);
    void *const memory = next;
    *w = (struct work){.patch = patch, .field = field, .area = area};
    if (!next) return NULL;
    w->fetched.share = take(&next, area);
    w->fetched.rest = take(&next, area);
    w->fetched.taps = take(&next, area);
    for (int k = 0; k < 2; k++) {
        w->squares[k] = take(&next, area);
        memset(w->squares[k], 0, area * sizeof *w->squares[k]);
    }
    for (int h = 0; h < 2; h++) {
        w->fetched.half[h] =
            (float(*)[RESIDUAL_HISTORY_LIGHT])(void *)take(&next, RESIDUAL_HISTORY_LIGHT * area);
        w->joined[h] =
            (float(*)[RESIDUAL_HISTORY_LIGHT])(void *)take(&next, RESIDUAL_HISTORY_LIGHT * area);
        memset(w->joined[h], 0, area * sizeof *w->joined[h]);
        w->sums[h] = take(&next, area);
        w->apart[h] = take(&next, area);
        w->variance[h] = take(&next, area);
        for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
            w->weight[h][c] = take(&next, area);
            memset(w->weight[h][c], 0, area * sizeof *w->weight[h][c]);
        }
    }
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) w->fetched.noise[c] = take(&next, area);
    w->rows = take(&next, area);
    w->worst = take(&next, area);
    return memory;
}

/* -- the test of means -- */

/* Sums over boxes, which end with the patch, in one order wherever that lies. */
static void sum_boxes(const struct work *w, const float *in, int32_t radius, float *out)
{
    const int32_t width = rect_width(w->patch->rect), height = rect_height(w->patch->rect);
    memset(w->rows, 0, w->area * sizeof *w->rows);
    memset(out, 0, w->area * sizeof *out);
    for (int32_t y = 0; y < height; y++) {
        const float *from = in + (size_t)y * (size_t)width;
        float *to = w->rows + (size_t)y * (size_t)width;
        for (int32_t step = -radius; step <= radius; step++) {
            const int32_t first = step < 0 ? -step : 0, end = step > 0 ? width - step : width;
            for (int32_t x = first; x < end; x++) to[x] += from[x + step];
        }
    }
    for (int32_t y = 0; y < height; y++) {
        float *to = out + (size_t)y * (size_t)width;
        for (int32_t v = y - radius; v <= y + radius; v++) {
            if (v < 0 || v >= height) continue;
            const float *from = w->rows + (size_t)v * (size_t)width;
            for (int32_t x = 0; x < width; x++) to[x] += from[x];
        }
    }
}

/* How the guides of a pixel's halves differ, and by how much chance makes them. */
static void compare_pixel(const struct work *w, int c, size_t i, size_t at)
{
    const struct residual_features *f = &w->field->features;
    const size_t plane = f->shape.plane;
    const float share = w->fetched.share[i];
    float own[2];
    for (int h = 0; h < 2; h++) {
        const float *light = w->field->light[c].half[h] + at;
        const float *past = w->fetched.half[h][i] + 3 * (size_t)c;
        own[h] = residual_guide(light[0], light[plane], light[2 * plane]);
        w->apart[h][i] = share * (residual_guide(past[0], past[1], past[2]) - own[h]);
    }
    const float d = own[0] - own[1], noise = share * share * (d * d + w->fetched.noise[c][i]);
    w->variance[0][i] = (1.0f - f->share[at]) * noise;
    w->variance[1][i] = f->share[at] * noise;
}

static size_t place_of(const struct work *w, int32_t x, int32_t y)
{
    const struct rect r = w->patch->rect;
    return residual_at(&w->field->features.shape, x - r.x0, y - r.y0);
}

static void compare(const struct work *w, int c)
{
    const struct rect r = w->patch->rect;
    size_t i = 0;
    for (int h = 0; h < 2; h++) {
        memset(w->apart[h], 0, w->area * sizeof *w->apart[h]);
        memset(w->variance[h], 0, w->area * sizeof *w->variance[h]);
    }
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++, i++)
            if (w->fetched.share[i] > 0.0f) compare_pixel(w, c, i, place_of(w, x, y));
}

/* Finds the largest difference of a half over all boxes around each pixel. */
static void judge(const struct work *w, int half)
{
    memset(w->worst, 0, w->area * sizeof *w->worst);
    for (int k = 0; k < RADII; k++) {
        sum_boxes(w, w->apart[half], radii[k], w->sums[0]);
        sum_boxes(w, w->variance[half], radii[k], w->sums[1]);
        for (size_t i = 0; i < w->area; i++) {
            const float d2 = w->sums[0][i] * w->sums[0][i], v = w->sums[1][i];
            /* Light without noise is the same or another. */
            const float now = d2 < OTHER2 * v ? d2 / v : d2 > 0.0f ? OTHER2 : 0.0f;
            if (now > w->worst[i]) w->worst[i] = now;
        }
    }
}

/* -- joining -- */

/* What the other half has said decides. Its noise knows nothing of this half's, so that a mean that
 * is off by chance is not kept from those that would correct it. */
static void join(const struct work *w, int c, int half)
{
    const float *share = c == RESIDUAL_REST ? w->fetched.rest : w->fetched.share;
    for (size_t i = 0; i < w->area; i++) {
        const float alike = (OTHER2 - w->worst[i]) / (OTHER2 - ALIKE2);
        const float weight = share[i] * (alike < 1.0f ? alike : 1.0f);
        if (!(weight > 0.0f)) continue;
        w->weight[half][c][i] += weight;
        for (size_t k = 3 * (size_t)c; k < 3 * (size_t)c + 3; k++)
            w->joined[half][i][k] += weight * w->fetched.half[half][i][k];
    }
}

/* Returns the way to a frame of the window. */
static struct residual_way way_to(const struct residual_window *window, enum motion_side side,
                                  uint32_t number)
{
    struct residual_way way = {.steps = number + 1,
                               .view = window->view,
                               .side = side,
                               .plans = {window->plan},
                               .motions = {window->motion}};
    for (uint32_t k = 0; k <= number; k++) {
        way.plans[k + 1] = &window->frames[side][k]->plan;
        way.motions[k + 1] = window->frames[side][k]->motion;
    }
    return way;
}

enum { MASKS = MOTION_SIDES * LIMIT_TEMPORAL_FRAMES };
static size_t mask_of(enum motion_side side, uint32_t number)
{
    return (size_t)side * LIMIT_TEMPORAL_FRAMES + number;
}

static void join_frame(const struct work *w, enum motion_side side, uint32_t number)
{
    const struct residual_window *window = w->patch->window;
    const struct residual_way way = way_to(window, side, number);
    residual_fetch(window->frames[side][number], &way, w->patch, &w->field->features,
                   w->field->still + mask_of(side, number) * w->area, &w->fetched);
    for (size_t i = 0; i < w->area; i++) {
        const float square = w->fetched.share[i] * w->fetched.share[i];
        w->squares[0][i] += square;
        w->squares[1][i] += square * w->fetched.taps[i];
    }
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        compare(w, c);
        for (int half = 0; half < 2; half++) {
            judge(w, 1 - half);
            join(w, c, half);
        }
    }
}

/* -- features -- */

/* Sums over frames; those of means over samples that meet a surface are weighted by their share. */
struct features_sum {
    float frames, seen, normal[3], tint[3], albedo[3], nearness, alpha;
};

static void add_features(const struct residual_past *q, struct features_sum *sum)
{
    sum->frames += 1.0f;
    sum->seen += q->seen;
    for (int c = 0; c < 3; c++) {
        sum->normal[c] += q->seen * q->mean_normal[c];
        sum->tint[c] += q->seen * q->tint[c];
        sum->albedo[c] += q->albedo[c];
    }
    sum->nearness += q->seen * q->nearness;
    sum->alpha += q->seen * q->alpha;
}

static void join_pixel(const struct patch *patch, int32_t x, int32_t y, size_t at,
                       struct features_sum *sum, struct residual_features *f)
{
    const size_t i = patch_pixel(patch, x, y), plane = f->shape.plane;
    struct residual_past own = {.seen = patch->path_coverage[i] / patch->paths.spp[i],
                                .nearness = f->nearness[at],
                                .alpha = f->alpha[at]};
    for (size_t c = 0; c < 3; c++) {
        own.mean_normal[c] = f->normal[c * plane + at];
        own.tint[c] = f->tint[c * plane + at];
        own.albedo[c] = f->albedo[c * plane + at];
    }
    add_features(&own, sum);
    if (!(sum->seen > 0.0f)) return;
    for (size_t c = 0; c < 3; c++) {
        f->normal[c * plane + at] = sum->normal[c] / sum->seen;
        f->tint[c * plane + at] = sum->tint[c] / sum->seen;
        f->albedo[c * plane + at] = sum->albedo[c] / sum->frames;
    }
    f->nearness[at] = sum->nearness / sum->seen;
    f->alpha[at] = sum->alpha / sum->seen;
    f->barred[at] = 0.0f;
}

/* Adds up what all frames have of a pixel in which nothing has moved, and joins it. */
static void join_still(const struct patch *patch, const uint8_t *still, int32_t x, int32_t y,
                       struct residual_features *f)
{
    const struct residual_window *window = patch->window;
    const size_t area = (size_t)rect_area(patch->rect), i = patch_pixel(patch, x, y);
    struct features_sum sum = {.frames = 0.0f};
    for (int side = 0; side < MOTION_SIDES; side++)
        for (uint32_t k = 0; k < window->count[side]; k++) {
            const struct residual_history *from = window->frames[side][k];
            const struct residual_past *q = residual_history_at(from, window->view, x, y);
            if (still[mask_of((enum motion_side)side, k) * area + i] && q->id > 0)
                add_features(q, &sum);
        }
    if (sum.frames > 0.0f)
        join_pixel(patch, x, y, residual_at(&f->shape, x - patch->rect.x0, y - patch->rect.y0),
                   &sum, f);
}

int residual_window_join_features(const struct patch *patch, struct residual_field *field)
{
    const struct residual_window *window = patch->window;
    const struct rect r = patch->rect;
    const size_t area = (size_t)rect_area(r), plane = field->features.shape.plane;
    field->joining =
        scratch_take(field->scratch, 5 * plane * sizeof *field->joined + (MASKS + 1) * area);
    if (!field->joining) return ERR_MEMORY;
    field->joined = field->joining;
    field->own = field->joined + 3 * plane;
    field->spread = field->own + plane;
    field->still = (uint8_t *)(field->spread + plane);
    for (int side = 0; side < MOTION_SIDES; side++)
        for (uint32_t k = 0; k < window->count[side]; k++) {
            const struct residual_way way = way_to(window, (enum motion_side)side, k);
            residual_find_still(window->frames[side][k], &way, patch, field->still + MASKS * area,
                                field->still + mask_of((enum motion_side)side, k) * area);
        }
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++)
            join_still(patch, field->still, x, y, &field->features);
    return 0;
}

/* -- means -- */

/* Sums become means. */
static void finish_pixel(const struct work *w, size_t i, size_t at)
{
    struct residual_field *f = w->field;
    const size_t plane = f->features.shape.plane;
    const float a = f->features.share[at];
    float most = 0.0f, mean[RESIDUAL_HISTORY_LIGHT];
    for (size_t k = 0; k < RESIDUAL_HISTORY_LIGHT; k++) {
        float light[2], part = 0.0f;
        for (int h = 0; h < 2; h++) {
            float *own = f->light[k / 3].half[h] + k % 3 * plane + at;
            const float weight = w->weight[h][k / 3][i];
            if (weight > 0.0f) *own = (*own + w->joined[h][i][k]) / (1.0f + weight);
            light[h] = *own;
            part += 0.5f / (1.0f + weight);
        }
        most = part > most ? part : most;
        mean[k] = a * light[0] + (1.0f - a) * light[1];
    }
    f->own[at] = most;
    f->spread[at] = sqrtf((1.0f + w->squares[0][i]) / (1.0f + w->squares[1][i]));
    for (size_t c = 0; c < 3; c++)
        f->joined[c * plane + at] = f->features.albedo[c * plane + at] * (mean[c] + mean[3 + c]) +
                                    f->features.tint[c * plane + at] * mean[6 + c];
}

int residual_window_join(const struct patch *patch, struct residual_field *field)
{
    struct work w;
    const struct residual_window *window = patch->window;
    const struct rect r = patch->rect;
    void *memory = work_create(patch, field, &w);
    if (!memory) return ERR_MEMORY;
    for (uint32_t number = 0; number < LIMIT_TEMPORAL_FRAMES; number++)
        for (int side = 0; side < MOTION_SIDES; side++)
            if (number < window->count[side]) join_frame(&w, (enum motion_side)side, number);
    size_t i = 0;
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++, i++) finish_pixel(&w, i, place_of(&w, x, y));
    scratch_give(patch->scratch, memory);
    return 0;
}
