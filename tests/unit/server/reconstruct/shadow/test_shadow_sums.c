/* What the shadow filters' kernels beside the walks stand for (shadow_kernels.h;
 * docs/reconstruction.md, from Receiver coordinates to Axis-aligned shadows), added up pixel by
 * pixel and number by number, in double: fields as odd as they get, of every number of strata. */
#include <math.h>
#include <string.h>

#include "tests/kernel/field_surface.h"
#include "tests/kernel/kernel_field.h"
#include "tests/unit/unit.h"

#define TOLERANCE  1e-5 /* of a pixel's greatest number */
#define WINDOW_PX  2    /* of sum_slopes, to each side */
#define CELL_NODES (2 * SHADOW_STRATA_MAX + 2)
#define SIMD_MAX   (SHADOW_STRATA_MAX + 4)

/* The sets of kernels that run here; returns how many. */
static int sets(const struct shadow_kernels *out[3])
{
    int count = 0;
    out[count++] = &shadow_kernels_sse42;
    out[count++] = KERNELS_BEST(shadow_kernels);
    if (out[1] == &shadow_kernels_avx512) out[count++] = &shadow_kernels_avx2;
    return count;
}

/* -- projections -- */

/* weight(g + j) (1 + gamma y_j) of node j, 0 from r on; g in phases of a node. */
static double node_weight(const struct shadow_field *f, int axis, size_t pixel, double g, size_t j)
{
    const struct shadow_pixels *p = f->pixels;
    const size_t row = (size_t)p->weights[axis][pixel] * (SHADOW_PHASES + 1);
    const size_t phase = (size_t)(g * SHADOW_PHASES);
    const double rest = g * SHADOW_PHASES - (double)phase;
    const float *below = f->weights + (row + phase) * f->window + j;
    const double above = rest > 0.0 ? (double)below[f->window] : 0.0;
    const double y = 1.0 - 2.0 * (g + (double)j) / f->scale;
    if (j >= f->scale) return 0.0;
    return ((1.0 - rest) * (double)below[0] + rest * above) *
           (1.0 + (double)p->gamma[axis][pixel] * y);
}

/* Where stratum a begins, rounded as it is there: the node, and how far it lies from the sample. */
static size_t stratum_node(const struct shadow_field *f, size_t a, float jitter, double *g)
{
    const float at = ((float)a + jitter) * ((float)f->scale / (float)f->strata);
    *g = (double)(ceilf(at) - at);
    return (size_t)ceilf(at);
}

/* Of one pixel all nodes, `lanes` numbers each. */
static void columns_of(const struct shadow_field *f, size_t pixel, float jitter,
                       const uint32_t *seen, double out[CELL_NODES * SIMD_MAX])
{
    memset(out, 0, CELL_NODES * SIMD_MAX * sizeof *out);
    for (size_t a = 0; a < f->strata; a++) {
        double g;
        const size_t first = stratum_node(f, a, jitter, &g);
        for (size_t j = 0; j < f->scale; j++)
            for (size_t b = 0; b <= f->strata; b++)
                if (seen[a] >> b & 1u)
                    out[(first + j) * f->lanes + b] += node_weight(f, 0, pixel, g, j);
    }
}

static double worst_columns(const struct shadow_kernels *kernels, const struct kernel_field *k)
{
    struct shadow_field f = k->field;
    const size_t each = shadow_nodes(&f) * f.lanes;
    double worst = 0.0, right[CELL_NODES * SIMD_MAX];
    f.pixels = &k->shown;
    f.columns = field_memory(k->slots * each * sizeof *f.columns);
    for (size_t i = 0; i < k->slots * each; i++) f.columns[i] = NAN; /* what was there is nothing */
    kernels->project_columns(&f, k->pixels + 1, k->count, k->jitter[0] + 1, k->seen + 1);
    for (uint32_t i = 0; i < k->count; i++) {
        const size_t pixel = k->pixels[1 + i], slot = (size_t)k->shown.slot[pixel];
        columns_of(&f, pixel, k->jitter[0][1 + i], k->seen + 1 + i * f.strata, right);
        worst = fmax(worst, field_error(right, f.columns + slot * each, each));
    }
    free(f.columns);
    return worst;
}

static double worst_rows(const struct shadow_kernels *kernels, const struct kernel_field *k)
{
    struct shadow_field f = k->field;
    const size_t nodes = shadow_nodes(&f), each = 2 * nodes;
    double worst = 0.0;
    f.pixels = &k->shown;
    f.rows = field_memory(k->slots * each * sizeof *f.rows);
    for (size_t i = 0; i < k->slots * each; i++) f.rows[i] = NAN;
    kernels->project_rows(&f, k->pixels + 1, k->count, k->cells + 1);
    for (uint32_t i = 0; i < k->count; i++) {
        double right[2 * CELL_NODES] = {0};
        const size_t pixel = k->pixels[1 + i], slot = (size_t)k->shown.slot[pixel];
        const float *cells = k->cells + 1 + (size_t)i * 4 * f.scale;
        for (size_t n = 0; n < (size_t)4 * f.scale * f.scale; n++) {
            const size_t c = n / (2 * f.scale), j = n / 2 % f.scale, which = n % 2;
            const double g = c % 2 == 0 ? 6.0 / SHADOW_PHASES : 2.0 / SHADOW_PHASES;
            right[2 * (c / 2 + 1 + j) + which] +=
                node_weight(&f, 1, pixel, g, j) * (double)cells[2 * c + which];
        }
        worst = fmax(worst, field_error(right, f.rows + slot * each, each));
    }
    free(f.rows);
    return worst;
}

/* -- means -- */

/* The mean around a pixel, taps `step` apart. */
static double mean_of(const struct shadow_blur *b, int32_t step, size_t pixel)
{
    double sum = 0.0, weights = 0.0;
    for (int32_t k = -b->reach[pixel]; k <= b->reach[pixel]; k++) {
        const size_t q = (size_t)((ptrdiff_t)pixel + (ptrdiff_t)k * step);
        float squared;
        if (!field_same_surface(b->pixels, pixel, q, &squared)) continue;
        const float exponent = squared * b->falloff[pixel];
        if (!(exponent <= SHADOW_AXIS_CUT && squared <= b->refusal[q])) continue;
        sum += exp(-(double)exponent) * (double)b->seen[q];
        weights += exp(-(double)exponent);
    }
    return b->reach[pixel] > 0 && weights > 0.0 ? sum / weights : (double)b->seen[pixel];
}

static double worst_means(const struct shadow_kernels *kernels, const struct kernel_field *k,
                          bool along_y)
{
    const struct shadow_blur b = {.pixels = &k->shown,
                                  .seen = k->planes[0],
                                  .refusal = k->planes[1],
                                  .falloff = k->planes[2],
                                  .reach = k->reach};
    const int32_t width = k->field.width, step = along_y ? width : 1;
    const uint32_t inner = (uint32_t)(width - 2 * SHADOW_REACH_PX);
    float *out = field_memory(inner * sizeof *out);
    double worst = 0.0;
    for (int32_t y = SHADOW_REACH_PX; y < k->field.height - SHADOW_REACH_PX; y++) {
        const size_t first = (size_t)y * (size_t)width + SHADOW_REACH_PX;
        kernels->blur(&b, step, first, inner, out);
        for (uint32_t i = 0; i < inner; i++) {
            const double right = mean_of(&b, step, first + i);
            worst = fmax(worst, field_error(&right, out + i, 1));
        }
    }
    free(out);
    return worst;
}

/* -- slopes -- */

static void slopes_of(const struct kernel_field *k, size_t pixel, double out[3])
{
    memset(out, 0, 3 * sizeof *out);
    for (int32_t n = 0; n < (2 * WINDOW_PX + 1) * (2 * WINDOW_PX + 1); n++) {
        const int32_t dx = n % (2 * WINDOW_PX + 1) - WINDOW_PX;
        const int32_t dy = n / (2 * WINDOW_PX + 1) - WINDOW_PX;
        const size_t q = (size_t)((ptrdiff_t)pixel + (ptrdiff_t)dy * k->field.width + dx);
        float squared;
        if (!field_same_surface(&k->shown, pixel, q, &squared) || !(k->a[q] >= 0.0f)) continue;
        out[0] += 1.0;
        out[1] += (double)k->a[q];
        out[2] += (double)k->b[q];
    }
}

static double worst_slopes(const struct shadow_kernels *kernels, const struct kernel_field *k)
{
    struct shadow_field f = k->field;
    float *out = field_memory((size_t)k->count * 3 * sizeof *out);
    double worst = 0.0;
    f.pixels = &k->shown;
    kernels->sum_slopes(&f, k->pixels + 1, k->count, k->a, k->b, out);
    for (uint32_t i = 0; i < k->count; i++) {
        double right[3];
        slopes_of(k, k->pixels[1 + i], right);
        worst = fmax(worst, field_error(right, out + (size_t)3 * i, 3));
    }
    free(out);
    return worst;
}

/* -- all of them -- */

/* By every set, over fields of all numbers of strata; some slopes are no numbers, and count for
 * nothing. */
static double worst_of(double (*worst_by)(const struct shadow_kernels *,
                                          const struct kernel_field *))
{
    const struct shadow_kernels *kernels[3];
    const int count = sets(kernels);
    double worst = 0.0;
    for (uint32_t l = 1; l <= SHADOW_STRATA_MAX; l++) {
        struct kernel_field k;
        field_init(&k, l, 17, 13, 200 + l, true);
        for (size_t i = 0; i < (size_t)k.field.width * (size_t)k.field.height; i += 37)
            k.a[i] = NAN;
        for (int n = 0; n < count; n++) worst = fmax(worst, worst_by(kernels[n], &k));
        field_fini(&k);
    }
    print_message("off by %.2g\n", worst);
    return worst;
}

static double worst_means_x(const struct shadow_kernels *kernels, const struct kernel_field *k)
{
    return worst_means(kernels, k, false);
}

static double worst_means_y(const struct shadow_kernels *kernels, const struct kernel_field *k)
{
    return worst_means(kernels, k, true);
}

TEST(columns_add_up)
{
    assert_true(worst_of(worst_columns) < TOLERANCE);
}

TEST(rows_add_up)
{
    assert_true(worst_of(worst_rows) < TOLERANCE);
}

TEST(means_along_x)
{
    assert_true(worst_of(worst_means_x) < TOLERANCE);
}

TEST(means_along_y)
{
    assert_true(worst_of(worst_means_y) < TOLERANCE);
}

TEST(slopes_add_up)
{
    assert_true(worst_of(worst_slopes) < TOLERANCE);
}
