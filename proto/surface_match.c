#include "proto/surface_match.h"

#include <math.h>

/* Even a far corner of the neighbourhood counts where it is the only match. */
#define TENT_MIN 0.05f

void surface_view_init(struct surface_view *view, const struct plan *plan)
{
    const struct plan_camera *c = &plan->camera;
    view->camera = c;
    view->orthographic = c->type == CAMERA_ORTHOGRAPHIC;
    view->a_step = 2.0f * c->half_width / (float)plan->width_px;
    view->b_step = -2.0f * c->half_height / (float)plan->height_px;
    view->a_start = -(1.0f + c->centre_x) * c->half_width;
    view->b_start = (1.0f - c->centre_y) * c->half_height;
    view->pixel_size = plan_pixel_size(plan, 1.0f);
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Computes the point at `distance` along the ray through pixel position (px, py). */
static void place_point(const struct surface_view *view, float px, float py, float distance,
                        float out[3])
{
    float a = view->a_start + view->a_step * px, b = view->b_start + view->b_step * py;
    /* 1 + a^2 + b^2 is at least 1. */
    float along = view->orthographic ? distance : distance / sqrtf(1.0f + a * a + b * b);
    float across = view->orthographic ? 1.0f : along;
    out[0] = a * across;
    out[1] = b * across;
    out[2] = along;
}

void shown_surface_init(const struct surface_view *view, float px, float py, float distance,
                        const float normal[3], uint32_t id, struct shown_surface *out)
{
    out->distance = distance;
    place_point(view, px, py, distance, out->point);
    out->normal[0] = dot(normal, view->camera->right);
    out->normal[1] = dot(normal, view->camera->up);
    out->normal[2] = dot(normal, view->camera->forward);
    out->id = id;
}

/* Computes how far the sub-sample is off the pixel's tangent plane, and how far it may be. */
static void plane_distance(const struct surface_view *view, const struct shown_surface *sub,
                           const struct shown_surface *pixel, float cosine, float *off,
                           float *allowed)
{
    const float d[3] = {sub->point[0] - pixel->point[0], sub->point[1] - pixel->point[1],
                        sub->point[2] - pixel->point[2]};
    float sine = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f)); /* rounding may pass 1 */
    *off = fabsf(dot(d, pixel->normal));
    /* Points are within SURFACE_DISTANCE_MAX of the eye: squares are finite. */
    *allowed = surface_pixel_size(view, fmaxf(sub->distance, pixel->distance)) * SURFACE_PLANE_PX +
               sqrtf(dot(d, d)) * (sine + SURFACE_SLACK);
}

float surface_match(const struct surface_view *view, const struct shown_surface *sub,
                    const struct shown_surface *pixel)
{
    float cosine = dot(sub->normal, pixel->normal);
    if (cosine <= SURFACE_COS_NONE) return 0.0f;
    float off, allowed;
    plane_distance(view, sub, pixel, cosine, &off, &allowed);
    if (off >= SURFACE_FADE * allowed) return 0.0f;
    float id = sub->id == pixel->id ? 1.0f : SURFACE_OTHER_ID;
    float turn = (cosine - SURFACE_COS_NONE) / (SURFACE_COS_FULL - SURFACE_COS_NONE);
    /* 0 <= off < 1.5 allowed, so allowed > 0. */
    float near = (SURFACE_FADE - off / allowed) / (SURFACE_FADE - 1.0f);
    return id * fminf(turn, 1.0f) * fminf(near, 1.0f);
}

float surface_mismatch(const struct surface_view *view, const struct shown_surface *sub,
                       const struct shown_surface *pixel)
{
    float cosine = dot(sub->normal, pixel->normal), off, allowed;
    plane_distance(view, sub, pixel, cosine, &off, &allowed);
    float far = allowed > 0.0f ? fminf(off / allowed, 1e6f) : 0.0f;
    return far + 8.0f * (1.0f - cosine) + (sub->id == pixel->id ? 0.0f : 4.0f);
}

void surface_face(const struct surface_view *view, const struct shown_surface *pixel,
                  struct surface_facing *facing)
{
    /* The point's distance from the eye is the depth, which is above 0. */
    const float cosine =
        view->orthographic ? pixel->normal[2] : dot(pixel->point, pixel->normal) / pixel->distance;
    const float chord = view->orthographic ? 0.0f : view->pixel_size;
    facing->known = true;
    facing->along = fabsf(cosine);
    facing->across = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f)) + chord;
}

bool surface_near_facing(const struct surface_view *view, float pixel, float sub,
                         const struct surface_facing *facing)
{
    return surface_corner(view, sub) * facing->across + fabsf(sub - pixel) * facing->along <=
           surface_allowed(view, pixel, sub);
}

static float tent(float offset, int32_t step)
{
    return fmaxf(1.5f - fabsf(offset - 0.5f - (float)step), TENT_MIN);
}

float surface_share(const float offset[2], int32_t column, int32_t row)
{
    return tent(offset[0], column) * tent(offset[1], row) * 0.125f;
}
