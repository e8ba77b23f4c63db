#include "server/compare/display_transform.h"

#include <math.h>
#include <stdlib.h>

static double clip(double v)
{
    return v > 0.0 ? fmin(v, 1.0) : 0.0; /* NaN, too */
}

static double filmic_of(double v)
{
    const double x = fmax(v, 0.0) * 0.6;
    /* Both grow beyond all doubles only where the quotient has long been above one. */
    return x > 1e6 ? 1.0 : x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

static float displayed(double v, double scale, const struct display_transform *view)
{
    const double linear = clip(view->filmic ? filmic_of(v * scale) : v * scale);
    const double encoded =
        linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (float)pow(encoded, 1 / view->gamma);
}

static int allocate(int32_t width, int32_t height, struct display_pair *out)
{
    const size_t area = (size_t)width * (size_t)height;
    float *next = calloc(area, 6 * sizeof *next + sizeof *out->counts);
    *out = (struct display_pair){.width_px = width, .height_px = height, .memory = next};
    if (!next) return ERR_MEMORY;
    for (int c = 0; c < 3; c++, next += 2 * area) {
        out->reference[c] = next;
        out->test[c] = next + area;
    }
    out->counts = (uint8_t *)next;
    return 0;
}

static bool is_finite(const struct plane *const rgb[3], int32_t x, int32_t y)
{
    for (int c = 0; c < 3; c++)
        if (!isfinite(*plane_at(rgb[c], x, y))) return false;
    return true;
}

static void fill(const struct plane *const r[3], const struct plane *const t[3],
                 const struct display_transform *view, struct display_pair *out)
{
    const double scale = exp2(view->exposure_ev);
    size_t i = 0;
    for (int32_t y = 0; y < out->height_px; y++)
        for (int32_t x = 0; x < out->width_px; x++, i++) {
            if (!is_finite(r, x, y) || !is_finite(t, x, y)) continue;
            out->counts[i] = 1;
            out->count++;
            for (int c = 0; c < 3; c++) {
                out->reference[c][i] = displayed((double)*plane_at(r[c], x, y), scale, view);
                out->test[c][i] = displayed((double)*plane_at(t[c], x, y), scale, view);
            }
        }
}

int display_pair_create(const struct image *reference, const struct image *test, const char *layer,
                        const struct display_transform *view, struct display_pair *out,
                        struct fault *fault)
{
    const struct plane *r[3], *t[3];
    *out = (struct display_pair){.memory = NULL};
    if (reference->width_px != test->width_px || reference->height_px != test->height_px)
        return fault_set(fault, ERR_MISMATCH, "", "sizes differ: %d x %d and %d x %d",
                         reference->width_px, reference->height_px, test->width_px,
                         test->height_px);
    if (!image_layer_planes(reference, layer, r))
        return fault_set(fault, ERR_NOT_FOUND, "", "the reference has no layer \"%s\"", layer);
    if (!image_layer_planes(test, layer, t))
        return fault_set(fault, ERR_NOT_FOUND, "", "the test image has no layer \"%s\"", layer);
    if (allocate(reference->width_px, reference->height_px, out) != 0)
        return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    fill(r, t, view, out);
    return 0;
}

void display_pair_fini(struct display_pair *pair)
{
    free(pair->memory);
    *pair = (struct display_pair){.memory = NULL};
}
