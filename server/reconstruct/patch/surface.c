#include "server/reconstruct/patch/surface.h"

#include <math.h>

void surface_points(const struct surface_view *view, int32_t x, int32_t y, uint32_t count,
                    const float *restrict depth, float *restrict px, float *restrict py,
                    float *restrict pz)
{
    const float *r = view->camera->right, *u = view->camera->up, *f = view->camera->forward;
    const float b = view->b_start + view->b_step * ((float)y + 0.5f);
    const float flat = view->orthographic ? 1.0f : 0.0f;
    for (uint32_t i = 0; i < count; i++) {
        const float a = view->a_start + view->a_step * ((float)(x + (int32_t)i) + 0.5f);
        /* 1 + a^2 + b^2 is at least 1 */
        const float along = flat > 0.0f ? depth[i] : depth[i] / sqrtf(1.0f + a * a + b * b);
        const float across = flat > 0.0f ? 1.0f : along;
        px[i] = across * (a * r[0] + b * u[0]) + along * f[0];
        py[i] = across * (a * r[1] + b * u[1]) + along * f[1];
        pz[i] = across * (a * r[2] + b * u[2]) + along * f[2];
    }
}

static void pixel_position(const struct patch *patch, size_t i, float *px, float *py)
{
    size_t width = (size_t)rect_width(patch->rect);
    *px = (float)(patch->rect.x0 + (int32_t)(i % width));
    *py = (float)(patch->rect.y0 + (int32_t)(i / width));
}

bool surface_of_pixel(const struct surface_view *view, const struct patch *patch, size_t i,
                      struct shown_surface *out)
{
    float *const *n = patch->normal;
    out->distance = patch->depth[i];
    if (!(out->distance > 0.0f)) return false;
    float px, py;
    pixel_position(patch, i, &px, &py);
    shown_surface_init(view, px + 0.5f, py + 0.5f, out->distance,
                       (const float[3]){n[0][i], n[1][i], n[2][i]},
                       patch->id ? surface_sub_id(patch->id[i]) : 0, out);
    return true;
}

bool surface_of_sub(const struct surface_view *view, const struct patch *patch, size_t i,
                    uint32_t k, const float offset[2], struct shown_surface *out)
{
    float *const *n = patch->sub_normal[k];
    out->distance = patch->sub_depth[k][i];
    if (!(out->distance > 0.0f)) return false;
    float px, py;
    pixel_position(patch, i, &px, &py);
    shown_surface_init(view, px + offset[0], py + offset[1], out->distance,
                       (const float[3]){n[0][i], n[1][i], n[2][i]},
                       patch->sub_id[k] ? patch->sub_id[k][i] : 0, out);
    return true;
}

bool surface_surely_same(const struct surface_view *view, const struct patch *patch, size_t i,
                         uint32_t k, struct surface_facing *facing)
{
    const float own = patch->depth[i], sub = patch->sub_depth[k][i];
    if (!(own > 0.0f) || !(sub > 0.0f)) return false;
    if (patch->id && patch->sub_id[k] && surface_sub_id(patch->id[i]) != patch->sub_id[k][i])
        return false;
    float *const *n = patch->normal, *const *m = patch->sub_normal[k];
    float cosine = n[0][i] * m[0][i] + n[1][i] * m[1][i] + n[2][i] * m[2][i];
    if (cosine < SURFACE_COS_FULL) return false;
    const enum surface_nearness near = surface_near(view, own, sub);
    if (near != SURFACE_NEAR_IF_FACING) return near == SURFACE_NEAR;
    if (!facing->known) {
        struct shown_surface pixel;
        surface_of_pixel(view, patch, i, &pixel);
        surface_face(view, &pixel, facing);
    }
    return surface_near_facing(view, own, sub, facing);
}
