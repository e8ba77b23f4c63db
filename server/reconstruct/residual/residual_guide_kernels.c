/* Every loop goes over columns that know nothing of each other: all instruction sets compute the
 * same bits. */
#include "server/reconstruct/residual/residual_guide_kernels.h"

#include <math.h>
#include <string.h>

/* What is below is no noise but rounding. */
#define LIGHT_MIN 1e-30f

/* Pixels of a row that are worked on at a time where rows are long. */
#define RUN_PX 256

/* What pixels beside count in smoothed guides, along each axis: as by a Gaussian of half a pixel.
 */
#define SMOOTH_SIDE 0.1065f

static void sum_channels(const float *restrict rgb, size_t plane, size_t count, float *restrict out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = residual_guide(rgb[i], rgb[plane + i], rgb[2 * plane + i]);
}

/* Bends a guide: far above its knee it grows as light's fourth root. A highlight may be a million
 * times as bright as what is beside it, which its least weight would drown. */
static void bend(const float *restrict knee, size_t count, float *restrict guide)
{
    for (size_t i = 0; i < count; i++) {
        const float root = sqrtf(1.0f + fabsf(guide[i]) / (knee[i] + LIGHT_MIN));
        guide[i] /= root * sqrtf(root);
    }
}

/* Half the mean of squared differences over 3 x 3 pixels: the variance of one half's guide. */
static void find_variances(const float *restrict a, const float *restrict b, size_t stride,
                           size_t count, float factor, float *restrict out)
{
    float columns[RUN_PX + 2];
    for (size_t i = 0; i < count + 2; i++) {
        const float d0 = a[i - 1 - stride] - b[i - 1 - stride], d1 = a[i - 1] - b[i - 1],
                    d2 = a[i - 1 + stride] - b[i - 1 + stride];
        columns[i] = d0 * d0 + d1 * d1 + d2 * d2;
    }
    for (size_t i = 0; i < count; i++)
        out[i] = (columns[i] + columns[i + 1] + columns[i + 2]) * factor;
}

static void mix(const float *restrict share, float *restrict a, const float *restrict b,
                size_t count)
{
    for (size_t i = 0; i < count; i++) a[i] = b[i] + share[i] * (a[i] - b[i]);
}

static void find_guides(const struct residual_shape *s, struct rect area,
                        const struct residual_light *light)
{
    const size_t count = (size_t)rect_width(area);
    for (int32_t y = area.y0; y < area.y1; y++)
        for (int h = 0; h < 2; h++) {
            const size_t at = residual_at(s, area.x0, y);
            sum_channels(light->half[h] + at, s->plane, count, light->guide[h] + at);
            if (light->knee) bend(light->knee + at, count, light->guide[h] + at);
        }
}

static inline float smooth(float before, float here, float after)
{
    return here + SMOOTH_SIDE * (before - 2.0f * here + after);
}

static void smooth_row(float *restrict row, size_t count)
{
    float from[RUN_PX + 2] = {row[-1]};
    for (size_t x = 0; x < count; x += RUN_PX) {
        const size_t run = count - x < RUN_PX ? count - x : RUN_PX;
        memcpy(from + 1, row + x, (run + 1) * sizeof *row);
        for (size_t i = 0; i < run; i++) row[x + i] = smooth(from[i], from[i + 1], from[i + 2]);
        from[0] = from[run];
    }
}

static void smooth_columns(float *restrict first, size_t stride, size_t count, int32_t height)
{
    float before[RUN_PX];
    memcpy(before, first - stride, count * sizeof *first);
    for (int32_t y = 0; y < height; y++, first += stride)
        for (size_t i = 0; i < count; i++) {
            const float here = first[i];
            first[i] = smooth(before[i], here, first[stride + i]);
            before[i] = here;
        }
}

/* Smooths over 3 x 3 pixels. There are guides one pixel farther to all sides. */
static void smooth_guide(const struct residual_shape *s, struct rect area, float *guide)
{
    const size_t count = (size_t)rect_width(area), first = residual_at(s, area.x0, area.y0);
    for (int32_t y = area.y0 - 1; y < area.y1 + 1; y++)
        smooth_row(guide + residual_at(s, area.x0, y), count);
    for (size_t x = 0; x < count; x += RUN_PX)
        smooth_columns(guide + first + x, s->stride, count - x < RUN_PX ? count - x : RUN_PX,
                       rect_height(area));
}

static void kernel_find(const struct residual_pass *pass, const struct residual_field *field,
                        enum residual_component component, struct rect area)
{
    const struct residual_features *f = &field->features;
    const struct residual_light *light = &field->light[component];
    const struct residual_shape *s = &f->shape;
    const enum residual_kind kind = pass->kind;
    const size_t count = (size_t)rect_width(area);
    const float factor = kind == RESIDUAL_CROSS ? 1.0f / 18.0f : 1.0f / 36.0f;
    const struct rect around = rect_grow(area, 1);
    find_guides(s, pass->smooth[component] ? rect_grow(around, 1) : around, light);
    for (int h = 0; h < 2 && pass->smooth[component]; h++) smooth_guide(s, around, light->guide[h]);
    for (int32_t y = area.y0; y < area.y1; y++) {
        const size_t at = residual_at(s, area.x0, y);
        for (size_t x = 0; x < count; x += RUN_PX)
            find_variances(light->guide[0] + at + x, light->guide[1] + at + x, s->stride,
                           count - x < RUN_PX ? count - x : RUN_PX, factor,
                           light->variance + at + x);
    }
    if (kind == RESIDUAL_CROSS) return;
    for (int32_t y = area.y0; y < area.y1; y++) {
        const size_t at = residual_at(s, area.x0, y);
        mix(f->share + at, light->guide[0] + at, light->guide[1] + at, count);
        for (size_t c = 0; c < 3 && kind == RESIDUAL_MEAN; c++)
            mix(f->share + at, light->half[0] + c * s->plane + at,
                light->half[1] + c * s->plane + at, count);
    }
}

const struct residual_guide_kernels KERNELS(residual_guide_kernels) = {.find = kernel_find};
