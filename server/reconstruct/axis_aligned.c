#include "server/reconstruct/axis_aligned.h"

#include <math.h>

#include "server/reconstruct/strata.h"

#define WIDTHS          3.0f /* k */
#define REFUSED_BY_NONE 3e38f
#define WIDTH_MOST      1e30f
#define SPACING_LEAST   0.5f  /* of a pixel's size, between neighbours, whatever follows */
#define SPACING_SHARE   0.95f /* of the first step's; a walk's last may be shorter */

/* How far apart neighbouring pixels are at least, in pixel sizes: a point on the next pixel's ray
 * is no nearer than that ray. Rays (a, b, 1) that are da apart, seen from the distance of 1, are da
 * sqrt(1 + b^2) / (1 + a^2 + b^2) apart, which is da cos^2 or more. */
static float spacing(const struct surface_view *view, const float point[3])
{
    const float *f = view->camera->forward;
    const float along = point[0] * f[0] + point[1] * f[1] + point[2] * f[2];
    const float squared = point[0] * point[0] + point[1] * point[1] + point[2] * point[2];
    const float least = view->orthographic ? 1.0f : along * along / squared; /* it has a depth */
    return least * SPACING_SHARE > SPACING_LEAST ? least * SPACING_SHARE : SPACING_LEAST;
}

static void set_width(const struct receiver_light *light, float scale, float kappa_most,
                      struct shadow_source *s, struct shadow_target *t)
{
    const float pixel = receiver_pixel(t);
    const float sigma_y =
        light->sigma_y[0] < light->sigma_y[1] ? light->sigma_y[0] : light->sigma_y[1];
    const float penumbra = sigma_y / (kappa_most > 1e-6f ? kappa_most : 1e-6f);
    const float beta = scale / WIDTHS * (penumbra > pixel ? penumbra : pixel);
    const float width = 0.5f / beta / beta,
                taps = ceilf(3.0f * beta / (spacing(&light->view, s->point) * pixel));
    s->refusal = penumbra * penumbra;
    t->width = width < WIDTH_MOST ? width : WIDTH_MOST;
    for (int i = 0; i < 2; i++)
        t->walk[i].reach = taps < AXIS_ALIGNED_REACH_PX ? (int32_t)taps : AXIS_ALIGNED_REACH_PX;
}

/* Widths of all, and own values of those that lie in the patch. */
static void load(const struct receiver_light *light, const struct patch *patch,
                 const struct wedges *wedges, struct receivers *r)
{
    const struct rect seen = rect_intersect(r->rect, patch->rect);
    const size_t width = (size_t)rect_width(r->rect), from_width = (size_t)rect_width(patch->rect);
    const float scale = wedge_scale(light->plan, light->strata);
    for (int32_t y = seen.y0; y < seen.y1; y++) {
        for (int32_t x = seen.x0; x < seen.x1; x++) {
            const size_t i = (size_t)(y - r->rect.y0) * width + (size_t)(x - r->rect.x0);
            const size_t from =
                (size_t)(y - patch->rect.y0) * from_width + (size_t)(x - patch->rect.x0);
            struct shadow_source *s = &r->sources[i];
            if (!receiver_is_lit(s)) continue;
            s->refusal = REFUSED_BY_NONE;
            s->seen =
                wedge_is_occluded(light, patch, from) ? strata_ratio(light, patch, x, y) : 1.0f;
            if (wedges->most[i] >= 0.0f)
                set_width(light, scale, wedges->most[i], s, &r->targets[i]);
        }
    }
}

/* One pass over `rect`: all is read before anything is written. */
static void blur(const struct shadow_kernels *kernels, uint32_t axis, struct rect rect,
                 struct receivers *r, uint32_t *pixels, float *out)
{
    const struct shadow_field field = {.width = rect_width(r->rect),
                                       .height = rect_height(r->rect),
                                       .sources = r->sources,
                                       .targets = r->targets};
    uint32_t count = 0;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t row = (size_t)(y - r->rect.y0) * (size_t)field.width;
        for (int32_t x = rect.x0; x < rect.x1; x++) {
            const size_t i = row + (size_t)(x - r->rect.x0);
            if (r->targets[i].width > 0.0f) pixels[count++] = (uint32_t)i;
        }
    }
    kernels->blur(&field, axis, pixels, count, out);
    for (uint32_t k = 0; k < count; k++) r->sources[pixels[k]].seen = out[k];
}

int axis_aligned_filter(const struct receiver_light *light, const struct patch *patch,
                        const struct wedges *wedges, const struct shadow_kernels *kernels,
                        struct receivers *receivers, struct rect inner)
{
    const size_t area = (size_t)rect_area(receivers->rect);
    struct rect tall = inner;
    uint32_t *pixels = scratch_take(patch->scratch, area * sizeof *pixels);
    float *out = scratch_take(patch->scratch, area * sizeof *out);
    if (pixels && out) {
        load(light, patch, wedges, receivers);
        tall.y0 -= AXIS_ALIGNED_REACH_PX;
        tall.y1 += AXIS_ALIGNED_REACH_PX;
        blur(kernels, 0, tall, receivers, pixels, out);
        blur(kernels, 1, inner, receivers, pixels, out);
    }
    const int error = pixels && out ? 0 : ERR_MEMORY;
    scratch_give(patch->scratch, out);
    scratch_give(patch->scratch, pixels);
    return error;
}

float axis_aligned_width_px(const struct shadow_target *target)
{
    return target->width > 0.0f ? sqrtf(0.5f / target->width) / receiver_pixel(target) : 0.0f;
}
