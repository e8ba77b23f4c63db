#include "server/reconstruct/lens/lens_axis_aligned.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/simd/gaussian.h"

#define REACH       LENS_AXIS_ALIGNED_REACH_PX
#define REACH_SIGMA 2.5f
#define SIGMA_Y     0.5f /* of the lens, in radii */
#define MU          2.0f
#define BETA_MIN    0.3f /* px; below, the average stands */

/* Arrays of `tall`: the block's columns and those around it. */
struct axis_aligned {
    const struct plan *plan;
    const struct patch *patch;
    struct rect wide, inner; /* wide: all that is read */
    float *average[3], *between[3], *beta;
    void *memory;
};

static size_t index_of(const struct axis_aligned *a, int32_t x, int32_t y)
{
    return (size_t)(y - a->wide.y0) * (size_t)rect_width(a->wide) + (size_t)(x - a->wide.x0);
}

static int create(struct axis_aligned *a)
{
    const size_t area = (size_t)rect_area(a->wide);
    float **const planes[] = {&a->average[0], &a->average[1], &a->average[2], &a->between[0],
                              &a->between[1], &a->between[2], &a->beta};
    const size_t count = sizeof planes / sizeof *planes;
    float *at = a->memory = scratch_take(a->patch->scratch, count * area * sizeof *at);
    if (!at) return ERR_MEMORY;
    memset(at, 0, count * area * sizeof *at);
    for (size_t k = 0; k < count; k++) *planes[k] = at + k * area;
    return 0;
}

/* Slopes to both sides of the focus: the one nearer to it counts. */
static void load_row(struct axis_aligned *a, int32_t y)
{
    const uint32_t n = a->plan->lens_strata_per_axis * a->plan->lens_strata_per_axis;
    const size_t area = (size_t)rect_area(a->patch->rect), width = (size_t)rect_width(a->wide);
    const size_t from = patch_pixel(a->patch, a->wide.x0, y), to = index_of(a, a->wide.x0, y);
    const float factor = SIGMA_Y / MU * cbrtf(9.0f / (float)n) * a->plan->mu;
    const float most = (float)REACH / REACH_SIGMA;
    for (size_t x = 0; x < width; x++) {
        float least = fabsf(a->patch->lens_slope[from + x]);
        for (uint32_t j = 1; j < n; j++) {
            const float size = fabsf(a->patch->lens_slope[j * area + from + x]);
            least = size < least ? size : least;
        }
        a->beta[to + x] = least * factor < most ? least * factor : most;
        if (a->beta[to + x] < BETA_MIN) a->beta[to + x] = 0.0f;
    }
    for (uint32_t j = 0; j < n; j++)
        for (uint32_t c = 0; c < 3; c++) {
            const float *in = a->patch->lens_radiance + (j * 3 + c) * area + from;
            for (size_t x = 0; x < width; x++) a->average[c][to + x] += in[x];
        }
    for (uint32_t c = 0; c < 3; c++)
        for (size_t x = 0; x < width; x++) a->average[c][to + x] /= (float)n;
}

/* The Gaussian around pixel i, from `before` pixels before it to `after` behind, `step` apart. */
static void blur(const struct axis_aligned *a, size_t i, ptrdiff_t step, int32_t before,
                 int32_t after, float *const in[3], float out[3])
{
    const float beta = a->beta[i];
    float sum[3] = {in[0][i], in[1][i], in[2][i]}, weights = 1.0f;
    const int32_t reach = (int32_t)ceilf(REACH_SIGMA * beta);
    for (int32_t k = 1; k <= reach; k++) {
        const float w = gaussian_exp_minus(0.5f * (float)(k * k) / (beta * beta)); /* beta > 0 */
        for (int side = 0; side < 2; side++) {
            if (k > (side ? after : before)) continue;
            const size_t q = (size_t)((ptrdiff_t)i + (side ? k : -k) * step);
            for (int c = 0; c < 3; c++) sum[c] += w * in[c][q];
            weights += w;
        }
    }
    for (int c = 0; c < 3; c++) out[c] = sum[c] / weights;
}

static void blur_rows(struct axis_aligned *a)
{
    for (int32_t y = a->wide.y0; y < a->wide.y1; y++)
        for (int32_t x = a->inner.x0; x < a->inner.x1; x++) {
            const size_t i = index_of(a, x, y);
            float result[3];
            blur(a, i, 1, x - a->wide.x0, a->wide.x1 - 1 - x, a->average, result);
            for (int c = 0; c < 3; c++) a->between[c][i] = result[c];
        }
}

static void blur_columns(struct axis_aligned *a, float *const out[3], float *width_px,
                         struct lens_statistics *statistics)
{
    for (int32_t y = a->inner.y0; y < a->inner.y1; y++)
        for (int32_t x = a->inner.x0; x < a->inner.x1; x++) {
            const size_t i = index_of(a, x, y), to = patch_pixel(a->patch, x, y);
            float result[3];
            blur(a, i, rect_width(a->wide), y - a->wide.y0, a->wide.y1 - 1 - y, a->between, result);
            for (int c = 0; c < 3; c++) out[c][to] = result[c];
            if (width_px) width_px[to] = a->beta[i];
            statistics->pixels_filtered += a->beta[i] > 0.0f ? 1 : 0;
            statistics->pixels_skipped += a->beta[i] > 0.0f ? 0 : 1;
        }
}

int lens_axis_aligned(const struct plan *plan, const struct patch *patch, struct rect inner,
                      float *const out[3], float *width_px, struct lens_statistics *statistics)
{
    struct axis_aligned a = {.plan = plan, .patch = patch, .inner = inner};
    a.wide = rect_intersect(rect_grow(inner, REACH), patch->rect);
    const int error = create(&a);
    if (error) return error;
    for (int32_t y = a.wide.y0; y < a.wide.y1; y++) load_row(&a, y);
    blur_rows(&a);
    blur_columns(&a, out, width_px, statistics);
    scratch_give(patch->scratch, a.memory);
    return 0;
}
