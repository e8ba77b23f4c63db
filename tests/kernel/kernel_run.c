#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/kernel/kernel_field.h"

size_t field_output(const struct kernel_field *k, enum kernel kernel, uint32_t count)
{
    const size_t nodes = shadow_nodes(&k->field);
    switch (kernel) {
    case KERNEL_MARK_WALKS:
        return (size_t)k->field.width * (size_t)k->field.height;
    case KERNEL_PROJECT_COLUMNS:
        return k->slots * nodes * k->field.lanes;
    case KERNEL_PROJECT_ROWS:
        return k->slots * nodes * 2;
    case KERNEL_WALK_COLUMNS:
        return (size_t)count * 4 * k->field.scale;
    case KERNEL_WALK_ROWS:
        return (size_t)count * 2;
    case KERNEL_SUM_SLOPES:
        return (size_t)count * 3;
    case KERNEL_PLACE_RECEIVERS:
    case KERNEL_SHEAR_RECEIVERS:
        return (size_t)count * FIELD_PIXEL;
    default:
        return count;
    }
}

/* Marks of both axes, as numbers. */
static void field_mark(const struct shadow_field *f, const struct shadow_kernels *kernels,
                       const uint32_t *pixels, uint32_t count, float *out)
{
    const size_t area = (size_t)f->width * (size_t)f->height;
    uint8_t *marks = field_memory(2 * area);
    for (uint32_t axis = 0; axis < 2; axis++)
        kernels->mark_walks(f, axis, pixels, count, marks + axis * area);
    for (size_t i = 0; i < area; i++) out[i] = (float)(marks[i] + 2 * marks[area + i]);
    free(marks);
}

/* All numbers of pixel i. */
static float *field_print(const struct shadow_pixels *p, size_t stride, size_t i, float *out)
{
    for (size_t k = 0; k < FIELD_FLOATS; k++) *out++ = p->point[0][k * stride + i];
    for (size_t k = 0; k < FIELD_PIXEL - FIELD_FLOATS; k++) *out++ = (float)p->slot[k * stride + i];
    return out;
}

/* Receivers of the inputs, from the second number on, to the planes from there on. */
static void field_place(const struct kernel_field *k, const struct shadow_kernels *kernels,
                        uint32_t count, float *out)
{
    for (int i = 0; i < 3; i++) {
        memcpy(k->placed.point[i] + 1, k->point[i] + 1, count * sizeof *k->point[i]);
        memcpy(k->placed.normal[i] + 1, k->normal[i] + 1, count * sizeof *k->normal[i]);
    }
    kernels->place_receivers(&k->light, count, k->depth + 1, 1, &k->placed);
    for (uint32_t i = 0; i < count; i++) out = field_print(&k->placed, field_stride(k), 1 + i, out);
}

/* Those of the field, with 1/slope from 0 on. */
static void field_shear(const struct kernel_field *k, const struct shadow_kernels *kernels,
                        const uint32_t *pixels, uint32_t count, float *out)
{
    const struct wedge_shear shear = {&k->light, 1.0f, 3.5f, 0.6f};
    kernels->shear_receivers(&shear, pixels, count, k->most, k->least, &k->sheared);
    for (uint32_t i = 0; i < count; i++)
        out = field_print(&k->sheared, field_stride(k), pixels[i], out);
}

/* Row by row, from number `first` of the listed pixels on: one run to the end of its row at most.
 */
static void field_blur(const struct kernel_field *k, const struct shadow_kernels *kernels,
                       int32_t step, const uint32_t *pixels, uint32_t count, float *out)
{
    float *const *p = k->planes;
    const struct shadow_blur planes = {
        .pixels = &k->shown, .seen = p[0], .refusal = p[1], .falloff = p[2], .reach = k->reach};
    const uint32_t width = (uint32_t)k->field.width;
    for (uint32_t i = 0, run; i < count; i += run) {
        for (run = 1; i + run < count && pixels[i + run] / width == pixels[i] / width; run++) {
        }
        const uint32_t span = pixels[i + run - 1] - pixels[i] + 1;
        float *row = field_memory((span + 1) * sizeof *row);
        kernels->blur(&planes, step, pixels[i], span, row);
        for (uint32_t j = 0; j < run; j++) out[i + j] = row[pixels[i + j] - pixels[i]];
        free(row);
    }
}

static void field_edges(const struct kernel_field *k, const struct shadow_kernels *kernels,
                        const uint32_t *pixels, uint32_t count, float *out)
{
    const struct edge_field edges = {.light = &k->light,
                                     .width = k->field.width,
                                     .scale = 1.0f,
                                     .pixels = &k->shown,
                                     .seen = k->planes[0],
                                     .jitter = {k->jitter[0], k->jitter[1]},
                                     .bits = k->bits,
                                     .stride = (size_t)k->field.width * (size_t)k->field.height};
    kernels->filter_edges(&edges, pixels, k->sigma_px + 1, count, out);
}

void field_run(const struct kernel_field *k, const struct shadow_kernels *kernels,
               enum kernel kernel, uint32_t first, uint32_t count, float *out)
{
    struct shadow_field f = k->field;
    f.pixels = &k->shown;
    const uint32_t *pixels = k->pixels + 1 + first;
    const float *const point[3] = {k->point[0] + 1, k->point[1] + 1, k->point[2] + 1};
    const float *const normal[3] = {k->normal[0] + 1, k->normal[1] + 1, k->normal[2] + 1};
    const float *const jitter[2] = {k->jitter[0] + 1, k->jitter[1] + 1};
    switch (kernel) {
    case KERNEL_UNOCCLUDED:
        kernels->unoccluded(&k->light.rectangle, count, point, normal, out);
        break;
    case KERNEL_PLACE_RECEIVERS:
        field_place(k, kernels, count, out);
        break;
    case KERNEL_SHEAR_RECEIVERS:
        field_shear(k, kernels, pixels, count, out);
        break;
    case KERNEL_MARK_WALKS:
        field_mark(&f, kernels, pixels, count, out);
        break;
    case KERNEL_PROJECT_COLUMNS:
        f.columns = out;
        kernels->project_columns(&f, pixels, count, k->jitter[0] + 1, k->seen + 1);
        break;
    case KERNEL_WALK_COLUMNS:
        kernels->walk_columns(&f, pixels, count, out);
        break;
    case KERNEL_PROJECT_ROWS:
        f.rows = out;
        kernels->project_rows(&f, pixels, count, k->cells + 1);
        break;
    case KERNEL_WALK_ROWS:
        kernels->walk_rows(&f, pixels, count, out);
        break;
    case KERNEL_BLUR_X:
        field_blur(k, kernels, 1, pixels, count, out);
        break;
    case KERNEL_BLUR_Y:
        field_blur(k, kernels, f.width, pixels, count, out);
        break;
    case KERNEL_ESTIMATE:
        kernels->estimate(&k->light.rectangle, f.strata, count, point, normal, jitter, k->bits + 1,
                          (size_t)f.width * (size_t)f.height, out);
        break;
    case KERNEL_FILTER_EDGES:
        field_edges(k, kernels, pixels, count, out);
        break;
    default:
        kernels->sum_slopes(&f, pixels, count, k->a, k->b, out);
        break;
    }
}

/* Greatest difference from the reference, over its greatest number or `least`; infinite where bits
 * differ in what is not finite. */
static float field_difference_over(const float *a, const float *b, size_t count, float least)
{
    float most = 0.0f, size = least;
    for (size_t i = 0; i < count; i++) {
        if (isfinite(a[i])) size = fmaxf(size, fabsf(a[i]));
        if (memcmp(&a[i], &b[i], sizeof a[i]) == 0 && isfinite(a[i])) continue;
        if (!isfinite(a[i]) || !isfinite(b[i])) return INFINITY;
        most = fmaxf(most, fmaxf(fabsf(a[i] - b[i]), 1e-37f)); /* -0 is not 0 */
    }
    return most / size;
}

float field_rounding(enum kernel kernel)
{
    switch (kernel) {
    case KERNEL_PLACE_RECEIVERS:
    case KERNEL_SHEAR_RECEIVERS:
    case KERNEL_MARK_WALKS:
        return 0.0f;
    case KERNEL_FILTER_EDGES:
        return 2e-5f;
    default:
        return REFERENCE_ROUNDING;
    }
}

float field_difference(const float *a, const float *b, size_t count)
{
    return field_difference_over(a, b, count, 1e-30f);
}

float field_compare(const struct kernel_field *k, const struct shadow_kernels *tested,
                    enum kernel kernel, uint32_t first, uint32_t count)
{
    const size_t size = field_output(k, kernel, count);
    const bool aligned = kernel == KERNEL_PROJECT_COLUMNS || kernel == KERNEL_PROJECT_ROWS;
    float *a = field_memory((size + 1) * sizeof *a), *b = field_memory((size + 1) * sizeof *b);
    const size_t start = aligned ? 0 : 1;
    field_run(k, &shadow_kernels_reference, kernel, first, count, a + start);
    field_run(k, tested, kernel, first, count, b + start);
    /* fields in which all receivers see the light from its side have nothing but rounding */
    const float least = kernel == KERNEL_UNOCCLUDED ? 0.05f : 1e-30f;
    const float difference = field_difference_over(a, b, size + start, least);
    free(a);
    free(b);
    return difference;
}
