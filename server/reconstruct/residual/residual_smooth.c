#include "server/reconstruct/residual/residual_smooth.h"

#include <math.h>
#include <string.h>

/* Nearness that is off the line between its neighbours by this share of it is half noise. */
#define BEND_HALF 0.005f

/* In the direction where it is least, edges have less noise than this among the pixels around; with
 * so much more all is noise. */
#define EDGE_SHARE 0.5f
#define SURE_SHARE 0.2f

#define RADIUS 2

enum { SIDE = 2 * RADIUS + 1, DIRECTIONS = 4, FEATURES = 11 };

/* Work on the patch's pixels, as planes of the features' shape. */
struct smoothing {
    struct residual_features *f;
    float *noise;  /* DIRECTIONS planes: how much of a pixel's nearness is noise, 0 to 1 */
    float *rows;   /* the same, over RADIUS pixels to both sides */
    float *weight; /* how much its features are smoothed, 0 to 1 */
    float *smooth; /* FEATURES planes, where the weight is above 0 */
};

static float noise_at(const float *z, ptrdiff_t i, ptrdiff_t step)
{
    const float off = fabsf(z[i + step] + z[i - step] - 2.0f * z[i]);
    return off / (off + BEND_HALF * z[i] + 1e-30f);
}

/* Pixels beside the background have no such nearness, nor have those at the patch's border. */
static void find_noise(const struct smoothing *s, int32_t y)
{
    const struct residual_shape *shape = &s->f->shape;
    const ptrdiff_t down = (ptrdiff_t)shape->stride;
    const ptrdiff_t steps[DIRECTIONS] = {1, down, down + 1, down - 1};
    const float *z = s->f->nearness, *barred = s->f->barred;
    const ptrdiff_t first = (ptrdiff_t)residual_at(shape, 0, y);
    for (ptrdiff_t i = first; i < first + shape->width; i++) {
        float bars = 0.0f;
        for (ptrdiff_t k = i - down; k <= i + down; k += down)
            bars += barred[k - 1] + barred[k] + barred[k + 1];
        for (size_t d = 0; d < DIRECTIONS; d++)
            s->noise[d * shape->plane + (size_t)i] = bars > 0.0f ? 0.0f : noise_at(z, i, steps[d]);
    }
}

static void sum_row(const struct smoothing *s, int32_t y)
{
    for (size_t d = 0; d < DIRECTIONS; d++) {
        const size_t first = residual_at(&s->f->shape, 0, y) + d * s->f->shape.plane;
        const float *noise = s->noise + first;
        float *rows = s->rows + first;
        for (ptrdiff_t x = 0; x < s->f->shape.width; x++)
            rows[x] = noise[x - 2] + noise[x - 1] + noise[x] + noise[x + 1] + noise[x + 2];
    }
}

static float sum_column(const float *rows, ptrdiff_t down)
{
    float sum = 0.0f;
    for (ptrdiff_t k = -RADIUS; k <= RADIUS; k++) sum += rows[k * down];
    return sum;
}

static void find_weights(const struct smoothing *s, int32_t y)
{
    const struct residual_shape *shape = &s->f->shape;
    const size_t first = residual_at(shape, 0, y);
    const ptrdiff_t down = (ptrdiff_t)shape->stride;
    for (size_t i = first; i < first + (size_t)shape->width; i++) {
        float least = sum_column(s->rows + i, down);
        for (size_t d = 1; d < DIRECTIONS; d++)
            least = fminf(least, sum_column(s->rows + d * shape->plane + i, down));
        const float share = (least / (SIDE * SIDE) - EDGE_SHARE) / SURE_SHARE;
        const float weight = share > 0.0f ? (share < 1.0f ? share : 1.0f) : 0.0f;
        s->weight[i] = s->f->barred[i] > 0.0f ? 0.0f : weight;
    }
}

static void list_features(const struct residual_features *f, float *of[FEATURES])
{
    const size_t plane = f->shape.plane;
    for (size_t c = 0; c < 3; c++) {
        of[c] = f->normal + c * plane;
        of[3 + c] = f->albedo + c * plane;
        of[6 + c] = f->tint + c * plane;
    }
    of[9] = f->nearness;
    of[10] = f->alpha;
}

/* Pixel i becomes a mean of those around, as far as both are noisy. */
static void smooth_pixel(const struct smoothing *s, ptrdiff_t i, float *const of[FEATURES])
{
    float weight[SIDE * SIDE], sum = 0.0f;
    ptrdiff_t at[SIDE * SIDE];
    for (int k = 0; k < SIDE * SIDE; k++) {
        at[k] = i + (k / SIDE - RADIUS) * (ptrdiff_t)s->f->shape.stride + k % SIDE - RADIUS;
        weight[k] = s->weight[at[k]];
        sum += weight[k];
    }
    for (size_t n = 0; n < FEATURES; n++) {
        float mean = 0.0f;
        for (int k = 0; k < SIDE * SIDE; k++) mean += weight[k] * of[n][at[k]];
        s->smooth[n * s->f->shape.plane + (size_t)i] =
            of[n][i] + s->weight[i] * (mean / sum - of[n][i]);
    }
}

/* Either finds smooth features of all pixels or puts them in place. */
static void smooth_row(const struct smoothing *s, int32_t y, float *const of[FEATURES], bool put)
{
    const struct residual_shape *shape = &s->f->shape;
    const ptrdiff_t first = (ptrdiff_t)residual_at(shape, 0, y);
    for (ptrdiff_t i = first; i < first + shape->width; i++) {
        if (!(s->weight[i] > 0.0f)) continue;
        if (!put) smooth_pixel(s, i, of);
        for (size_t n = 0; n < FEATURES && put; n++)
            of[n][i] = s->smooth[n * shape->plane + (size_t)i];
    }
}

_Static_assert(2 * DIRECTIONS + 1 + FEATURES == RESIDUAL_SMOOTH_PLANES, "planes to work in");

void residual_smooth(struct residual_features *f, float *work)
{
    const size_t plane = f->shape.plane;
    const int32_t height = f->shape.height;
    float *of[FEATURES];
    const struct smoothing s = {f, work, work + DIRECTIONS * plane, work + 2 * DIRECTIONS * plane,
                                work + (2 * DIRECTIONS + 1) * plane};
    memset(work, 0, (2 * DIRECTIONS + 1) * plane * sizeof *work);
    list_features(f, of);
    for (int32_t y = 0; y < height; y++) find_noise(&s, y);
    for (int32_t y = 0; y < height; y++) sum_row(&s, y);
    for (int32_t y = 0; y < height; y++) find_weights(&s, y);
    for (int32_t y = 0; y < height; y++) smooth_row(&s, y, of, false);
    for (int32_t y = 0; y < height; y++) smooth_row(&s, y, of, true);
}
