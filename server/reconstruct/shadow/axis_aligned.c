#include "server/reconstruct/shadow/axis_aligned.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/shadow/strata.h"

#define WIDTHS          3.0f /* k */
#define REFUSED_BY_NONE 3e38f
#define FALLOFF_MAX     1e30f
#define SPACING_MIN     0.5f  /* of a pixel's size, between neighbours, whatever follows */
#define SPACING_SHARE   0.95f /* of the first step's; a walk's last may be shorter */

/* Returns the least distance between neighbouring pixels, in pixel sizes. A point on the next
 * pixel's ray is no nearer than that ray. Rays (a, b, 1) that are da apart, seen from the distance
 * of 1, are da sqrt(1 + b^2) / (1 + a^2 + b^2) apart, which is da cos^2 or more. */
static float spacing(const struct surface_view *view, const struct shadow_pixels *p, size_t i)
{
    const float *f = view->camera->forward;
    const float x = p->point[0][i], y = p->point[1][i], z = p->point[2][i];
    const float along = x * f[0] + y * f[1] + z * f[2], squared = x * x + y * y + z * z;
    const float least = view->orthographic ? 1.0f : along * along / squared; /* it has a depth */
    return least * SPACING_SHARE > SPACING_MIN ? least * SPACING_SHARE : SPACING_MIN;
}

/* The planes of struct shadow_blur while they are filled, and that of the first pass's result. */
struct axis_aligned {
    const struct receiver_light *light;
    const struct patch *patch;
    const struct shadow_kernels *kernels;
    const struct receivers *receivers;
    float scale; /* m(N) mu */
    float *seen, *refusal, *falloff, *blurred;
    int32_t *reach;
    void *memory;
};

#define PLANES 5

static int create_planes(struct axis_aligned *a)
{
    const size_t area = (size_t)rect_area(a->receivers->rect), stride = area + SHADOW_PLANE_PAD;
    float *memory = a->memory = scratch_take(a->patch->scratch, PLANES * stride * sizeof *memory);
    if (!memory) return ERR_MEMORY;
    float **const planes[PLANES - 1] = {&a->seen, &a->refusal, &a->falloff, &a->blurred};
    for (size_t k = 0; k < PLANES; k++, memory += stride) {
        memset(memory + area, 0, SHADOW_PLANE_PAD * sizeof *memory);
        if (k < PLANES - 1)
            *planes[k] = memory;
        else
            a->reach = (int32_t *)(void *)memory;
    }
    return 0;
}

/* Sets the pixel's width, beta = (m mu / k) max(sigma_y / kappa_max, px), and what follows. */
static void set_width(const struct axis_aligned *a, size_t i, float kappa_max)
{
    const struct receiver_light *light = a->light;
    const struct shadow_pixels *pixels = &a->receivers->pixels;
    const float pixel = receiver_pixel(pixels, i);
    const float sigma_y =
        light->sigma_y[0] < light->sigma_y[1] ? light->sigma_y[0] : light->sigma_y[1];
    const float penumbra = sigma_y / (kappa_max > 1e-6f ? kappa_max : 1e-6f);
    const float beta = a->scale / WIDTHS * (penumbra > pixel ? penumbra : pixel);
    const float falloff = 0.5f / beta / beta;
    const float taps = ceilf(3.0f * beta / (spacing(&light->view, pixels, i) * pixel));
    a->refusal[i] = penumbra * penumbra;
    a->falloff[i] = falloff < FALLOFF_MAX ? falloff : FALLOFF_MAX;
    a->reach[i] = taps < AXIS_ALIGNED_REACH_PX ? (int32_t)taps : AXIS_ALIGNED_REACH_PX;
}

/* Loads the values of pixels without wedge. */
static void load(const struct axis_aligned *a)
{
    const size_t area = (size_t)rect_area(a->receivers->rect);
    for (size_t i = 0; i < area; i++) {
        a->seen[i] = 1.0f;
        a->refusal[i] = REFUSED_BY_NONE;
        a->falloff[i] = 0.0f;
        a->reach[i] = 0;
    }
}

/* Own values and widths of up to STRATA_RUN pixels of a row of the patch. */
static void load_run(const struct axis_aligned *a, const struct wedges *wedges, int32_t x,
                     int32_t y, uint32_t count)
{
    const size_t at = patch_pixel(a->patch, x, y), to = receivers_pixel(a->receivers, x, y);
    float own[STRATA_RUN];
    bool occluded = false;
    for (uint32_t i = 0; i < count; i++) {
        occluded = occluded || wedge_is_occluded(a->light, a->patch, at + i);
        if (wedges->most[to + i] >= 0.0f) set_width(a, to + i, wedges->most[to + i]);
    }
    if (!occluded) return;
    strata_estimate(a->light, a->patch, a->kernels, x, y, count, own);
    for (uint32_t i = 0; i < count; i++)
        if (wedge_is_occluded(a->light, a->patch, at + i)) a->seen[to + i] = own[i];
}

/* Loads all rows that are read for `inner`. */
static void load_rows(const struct axis_aligned *a, const struct wedges *wedges, struct rect inner)
{
    const struct rect read = rect_grow(inner, AXIS_ALIGNED_REACH_PX);
    const struct rect seen =
        rect_intersect(rect_intersect(a->receivers->rect, a->patch->rect), read);
    for (int32_t y = seen.y0; y < seen.y1; y++) {
        for (int32_t x = seen.x0; x < seen.x1; x += STRATA_RUN) {
            const int32_t left = seen.x1 - x;
            load_run(a, wedges, x, y, (uint32_t)(left < STRATA_RUN ? left : STRATA_RUN));
        }
    }
}

/* Runs one pass over `rect`, from plane to plane. */
static void blur(const struct axis_aligned *a, int32_t step, struct rect rect, const float *from,
                 float *to)
{
    const struct shadow_blur planes = {.pixels = &a->receivers->pixels,
                                       .seen = from,
                                       .refusal = a->refusal,
                                       .falloff = a->falloff,
                                       .reach = a->reach};
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = receivers_pixel(a->receivers, rect.x0, y);
        a->kernels->blur(&planes, step, first, (uint32_t)rect_width(rect), to + first);
    }
}

/* beta in pixels of a receiver with a wedge. */
static float width_px(const struct axis_aligned *a, size_t i)
{
    return sqrtf(0.5f / a->falloff[i]) / receiver_pixel(&a->receivers->pixels, i);
}

int axis_aligned_filter(const struct receiver_light *light, const struct patch *patch,
                        const struct wedges *wedges, const struct shadow_kernels *kernels,
                        const struct receivers *receivers, struct rect inner,
                        const uint32_t *pixels, uint32_t count, float *seen, float *width)
{
    struct axis_aligned a = {.light = light,
                             .patch = patch,
                             .kernels = kernels,
                             .receivers = receivers,
                             .scale = wedge_scale(light->plan, light->strata)};
    struct rect tall = inner;
    if (create_planes(&a)) return ERR_MEMORY;
    load(&a);
    load_rows(&a, wedges, inner);
    tall.y0 -= AXIS_ALIGNED_REACH_PX;
    tall.y1 += AXIS_ALIGNED_REACH_PX;
    blur(&a, 1, tall, a.seen, a.blurred);
    blur(&a, rect_width(receivers->rect), inner, a.blurred, a.seen);
    for (uint32_t k = 0; k < count; k++) {
        seen[k] = a.seen[pixels[k]];
        width[k] = width_px(&a, pixels[k]);
    }
    scratch_give(patch->scratch, a.memory);
    return 0;
}
