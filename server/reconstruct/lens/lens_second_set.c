#include "server/reconstruct/lens/lens_second_set.h"

#include <math.h>
#include <string.h>

#define PI            3.14159265f
#define LEVEL_MIN     (2 * (127 - 64)) /* two a power of two: squares from 2^-64 on */
#define CENTRE_WEIGHT 2.0f
#define SQUARE_MAX    1e30f /* so that sums are finite */
#define LEVEL_PX      1     /* around a pixel, whose errors say whether it gets a second set */
/* Around a pixel, whose errors say how much of its second set there is in the picture. Of fewer
 * pixels bright ones would seem to err more, and be taken for less than they are. */
#define MIX_PX 3

/* Squared errors of a rectangle's pixels, as their own samples tell: of the first set, and of the
 * mean of the second, in doubles, since they come of differences. */
struct errors {
    const struct plan *plan;
    const struct patch *patch;
    struct rect rect;
    float *square;
    double *second;
    void *memory; /* owned */
};

/* Returns the squared error of pixel i of the patch. */
static float square_of(const struct plan *plan, const struct patch *patch, size_t i)
{
    const size_t area = (size_t)rect_area(patch->rect);
    const uint32_t n = plan->lens_strata_per_axis * plan->lens_strata_per_axis;
    float all = 0.0f, mean[3] = {0}, sum = 0.0f;
    for (uint32_t j = 0; j < n; j++) {
        const float s = patch->lens_slope[j * area + i], weight = 1.0f / (1.0f + PI * s * s);
        all += weight;
        for (uint32_t c = 0; c < 3; c++)
            mean[c] += weight * patch->lens_radiance[(j * 3 + c) * area + i];
    }
    for (int c = 0; c < 3; c++) mean[c] = all > 0.0f ? mean[c] / all : 0.0f;
    for (uint32_t j = 0; j < n; j++) {
        const float s = patch->lens_slope[j * area + i], weight = 1.0f / (1.0f + PI * s * s);
        for (uint32_t c = 0; c < 3; c++) {
            const float d =
                plan->radiance_scale * (patch->lens_radiance[(j * 3 + c) * area + i] - mean[c]);
            sum += weight * d * d;
        }
    }
    return n > 1 ? fminf(sum / (float)(n * (n - 1)), SQUARE_MAX) : 0.0f;
}

/* The squared error of a second set's mean. */
static double second_square(const struct plan *plan, const struct patch *p, size_t i)
{
    const size_t area = (size_t)rect_area(p->rect);
    const double scale = (double)plan->radiance_scale,
                 root = (double)p->lens_second_set[3 * area + i];
    const double paths = (double)p->lens_paths[i];
    double variance = root * root;
    if (!(paths > 1.0)) return 0.0;
    for (size_t c = 0; c < 3; c++)
        variance -=
            (double)p->lens_second_set[c * area + i] * (double)p->lens_second_set[c * area + i];
    return variance > 0.0 ? scale * scale * variance / (paths - 1.0) : 0.0;
}

/* Estimates errors over `inner` and some pixels around. If the patch has second sets, only pixels
 * with one count. */
static int errors_create(const struct plan *plan, const struct patch *patch, struct rect inner,
                         int32_t around_px, struct errors *out)
{
    *out = (struct errors){.plan = plan, .patch = patch};
    out->rect = rect_intersect(rect_grow(inner, around_px), patch->rect);
    const size_t area = (size_t)rect_area(out->rect);
    const bool both = patch->lens_paths != NULL;
    out->memory = scratch_take(patch->scratch, area * (sizeof(float) + both * sizeof(double)));
    if (!out->memory) return ERR_MEMORY;
    out->second = out->memory;
    out->square = (float *)(void *)(out->second + both * area);
    size_t k = 0;
    for (int32_t y = out->rect.y0; y < out->rect.y1; y++) {
        const size_t first = patch_pixel(patch, out->rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(out->rect); i++, k++) {
            const bool counts = !both || patch->lens_paths[i] > 0.0f;
            out->square[k] = counts ? square_of(plan, patch, i) : 0.0f;
            if (both) out->second[k] = second_square(plan, patch, i);
        }
    }
    return 0;
}

static void errors_fini(struct errors *e)
{
    scratch_give(e->patch->scratch, e->memory);
}

static size_t errors_at(const struct errors *e, int32_t x, int32_t y)
{
    return (size_t)(y - e->rect.y0) * (size_t)rect_width(e->rect) + (size_t)(x - e->rect.x0);
}

static struct rect around(const struct errors *e, int32_t x, int32_t y, int32_t around_px)
{
    return rect_intersect(rect_grow((struct rect){x, y, x + 1, y + 1}, around_px), e->rect);
}

/* Means over few pixels: of few samples errors are hardly known. */
static float smooth(const struct errors *e, int32_t x, int32_t y)
{
    const struct rect r = around(e, x, y, LEVEL_PX);
    float sum = (CENTRE_WEIGHT - 1.0f) * e->square[errors_at(e, x, y)];
    for (int32_t v = r.y0; v < r.y1; v++)
        for (int32_t u = r.x0; u < r.x1; u++) sum += e->square[errors_at(e, u, v)];
    return sum / ((float)rect_area(r) + CENTRE_WEIGHT - 1.0f);
}

/* Exponent and first digit of a number. */
static uint8_t level_of(float square)
{
    uint32_t bits;
    memcpy(&bits, &square, sizeof bits);
    const int32_t level = (int32_t)(bits >> 22) - LEVEL_MIN;
    if (!(square > 0.0f)) return 0;
    return (uint8_t)(level < 1 ? 1 : level > UINT8_MAX ? UINT8_MAX : level);
}

int lens_second_set_levels(const struct plan *plan, const struct patch *patch, struct rect inner,
                           uint8_t *levels)
{
    struct errors e;
    struct patch first = *patch; /* before second sets, of all pixels */
    first.lens_paths = NULL;
    const int error = errors_create(plan, &first, inner, LEVEL_PX, &e);
    if (error) return error;
    for (int32_t y = inner.y0; y < inner.y1; y++)
        for (int32_t x = inner.x0; x < inner.x1; x++) *levels++ = level_of(smooth(&e, x, y));
    errors_fini(&e);
    return 0;
}

/* Returns the share of the second set's mean in the picture. */
static float share_of(const struct errors *e, int32_t x, int32_t y)
{
    const struct rect r = around(e, x, y, MIX_PX);
    const size_t width = (size_t)rect_width(r);
    double first = 0.0, second = 0.0;
    for (int32_t v = r.y0; v < r.y1; v++) {
        const size_t at = errors_at(e, r.x0, v);
        for (size_t k = at; k < at + width; k++) {
            first += (double)e->square[k]; /* both 0 without a second set */
            second += e->second[k];
        }
    }
    return first > 0.0 ? (float)(first / (first + second)) : 0.0f;
}

int lens_second_set_mix(const struct plan *plan, const struct patch *patch, struct rect inner,
                        float *const out[3])
{
    const size_t area = (size_t)rect_area(patch->rect);
    bool any = false;
    for (int32_t y = inner.y0; y < inner.y1 && !any; y++)
        for (int32_t x = inner.x0; x < inner.x1 && !any; x++)
            any = patch->lens_paths[patch_pixel(patch, x, y)] > 0.0f;
    if (!any) return 0;
    struct errors e;
    const int error = errors_create(plan, patch, inner, MIX_PX, &e);
    if (error) return error;
    for (int32_t y = inner.y0; y < inner.y1; y++)
        for (int32_t x = inner.x0; x < inner.x1; x++) {
            const size_t i = patch_pixel(patch, x, y);
            if (!(patch->lens_paths[i] > 0.0f)) continue;
            const float share = share_of(&e, x, y);
            for (size_t c = 0; c < 3; c++)
                out[c][i] += share * (patch->lens_second_set[c * area + i] - out[c][i]);
        }
    errors_fini(&e);
    return 0;
}
