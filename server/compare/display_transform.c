#include "server/compare/display_transform.h"

#include <math.h>
#include <stdlib.h>

#include "server/image/view_transform.h"

static float encoded(double v, double gamma)
{
    const double srgb = v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
    return (float)pow(srgb, 1 / gamma);
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

/* Loads up to VIEW_PIXELS pixels of row y from x0 on, and shows them. */
static void show(const struct view_transform *curve, const struct plane *const rgb[3], int32_t x0,
                 int32_t y, struct view_pixels *shown)
{
    for (int32_t i = 0; i < VIEW_PIXELS; i++)
        for (int c = 0; c < 3; c++)
            shown->channel[c][i] =
                x0 + i < rgb[c]->width_px ? (double)*plane_at(rgb[c], x0 + i, y) : 0;
    view_transform_apply(curve, shown);
}

static void fill(const struct plane *const r[3], const struct plane *const t[3],
                 const struct display_transform *view, struct display_pair *out)
{
    const struct view_transform curve = view_transform_of(view->curve, view->exposure_ev);
    struct view_pixels reference, test;
    size_t at = 0;
    for (int32_t y = 0; y < out->height_px; y++)
        for (int32_t x = 0; x < out->width_px; x++, at++) {
            const int32_t i = x % VIEW_PIXELS;
            if (i == 0) {
                show(&curve, r, x, y, &reference);
                show(&curve, t, x, y, &test);
            }
            if (!is_finite(r, x, y) || !is_finite(t, x, y)) continue;
            out->counts[at] = 1;
            out->count++;
            for (int c = 0; c < 3; c++) {
                out->reference[c][at] = encoded(reference.channel[c][i], view->gamma);
                out->test[c][at] = encoded(test.channel[c][i], view->gamma);
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
