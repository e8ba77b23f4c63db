#include "server/reconstruct/residual/residual_single.h"

#include <math.h>

/* Surfaces whose features differ by so much, squared, lend each other less (fall_off). */
#define NORMAL_WEIGHT 10.0f
#define ALBEDO_WEIGHT 5.0f
#define NEARNESS_STEP 0.02f

static const int32_t beside[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

static float difference2(const float *planes, size_t plane, size_t p, size_t q)
{
    float sum = 0.0f;
    for (size_t c = 0; c < 3; c++) {
        const float d = planes[c * plane + p] - planes[c * plane + q];
        sum += d * d;
    }
    return sum;
}

/* Falls about as exp(-x), without the C library's: bytes must not depend on the CPU. */
static float fall_off(float x)
{
    return 1.0f / (1.0f + x * (1.0f + x * (0.5f + x * (1.0f / 6.0f + x * (1.0f / 24.0f)))));
}

/* Returns how far pixel q, beside p, shows what p does. */
static float likeness(const struct residual_features *f, size_t p, size_t q, const int32_t way[2])
{
    const float near = f->nearness[p];
    const float along = (float)way[0] * f->slope_x[p] + (float)way[1] * f->slope_y[p];
    const float step =
        (f->nearness[q] - near - along) / (NEARNESS_STEP * near + fabsf(along) + 1e-30f);
    if (f->barred[q] > 0.0f) return 0.0f;
    return fall_off(NORMAL_WEIGHT * difference2(f->normal, f->shape.plane, p, q) +
                    ALBEDO_WEIGHT * difference2(f->albedo, f->shape.plane, p, q) + step * step);
}

/* Sets the half that pixel p has not, of all components; its own sample is in half `own`. */
static bool lend(struct residual_field *field, int32_t x, int32_t y, int own)
{
    const struct residual_shape *s = &field->features.shape;
    const size_t p = residual_at(s, x, y);
    float weights[4], sum = 0.0f;
    size_t at[4];
    for (int k = 0; k < 4; k++) {
        const int32_t qx = x + beside[k][0], qy = y + beside[k][1];
        const bool inside = qx >= 0 && qy >= 0 && qx < s->width && qy < s->height;
        at[k] = inside ? residual_at(s, qx, qy) : p;
        weights[k] = inside ? likeness(&field->features, p, at[k], beside[k]) : 0.0f;
        sum += weights[k];
    }
    if (!(sum > 0.0f)) return false;
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        struct residual_light *l = &field->light[c];
        for (size_t i = 0; i < 3; i++) {
            float lent = 0.0f;
            for (int k = 0; k < 4; k++) lent += weights[k] * l->half[1 - own][i * s->plane + at[k]];
            l->filtered[1 - own][i * s->plane + p] = lent / sum;
        }
    }
    return true;
}

/* Returns whether the pixel has one sample, which both of its halves are so far. */
static bool is_single(const struct patch *patch, const struct residual_field *field, int32_t x,
                      int32_t y)
{
    const size_t i = patch_pixel(patch, patch->rect.x0 + x, patch->rect.y0 + y);
    return patch->paths.spp[i] == 1.0f &&
           !(field->features.barred[residual_at(&field->features.shape, x, y)] > 0.0f);
}

static int color_of(const struct patch *patch, int32_t x, int32_t y)
{
    return (patch->rect.x0 + x + patch->rect.y0 + y) & 1;
}

/* Lent light is kept apart until all is lent. */
void residual_single_lend(const struct patch *patch, struct residual_field *field)
{
    const struct residual_shape *s = &field->features.shape;
    bool any = false;
    for (int32_t y = 0; y < s->height; y++)
        for (int32_t x = 0; x < s->width; x++) {
            const size_t p = residual_at(s, x, y);
            if (!is_single(patch, field, x, y) || !lend(field, x, y, color_of(patch, x, y)))
                continue;
            field->features.share[p] = 0.5f;
            any = true;
        }
    for (int32_t y = 0; any && y < s->height; y++)
        for (int32_t x = 0; x < s->width; x++) {
            const size_t p = residual_at(s, x, y);
            const int other = 1 - color_of(patch, x, y);
            if (!is_single(patch, field, x, y) || !(field->features.share[p] > 0.0f)) continue;
            for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
                for (size_t i = 0; i < 3; i++)
                    field->light[c].half[other][i * s->plane + p] =
                        field->light[c].filtered[other][i * s->plane + p];
        }
    residual_pad(s, field->features.share, 1);
}
