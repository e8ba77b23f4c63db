#include "server/reconstruct/surface.h"

#include <math.h>

/* No point of a pixel is farther from its centre, in pixels; and a little for rounding. */
#define CORNER_PX 0.71f
#define ROUNDING  0.999f

void surface_view_init(struct surface_view *view, const struct plan *plan)
{
    const struct plan_camera *c = &plan->camera;
    view->camera = c;
    view->orthographic = c->type == CAMERA_ORTHOGRAPHIC;
    view->a_step = 2.0f * c->half_width / (float)plan->width_px;
    view->b_step = -2.0f * c->half_height / (float)plan->height_px;
    view->a_start = -c->half_width;
    view->b_start = c->half_height;
    view->pixel_size = plan_pixel_size(plan, 1.0f);
}

float surface_pixel_size(const struct surface_view *view, float distance)
{
    return view->orthographic ? view->pixel_size : view->pixel_size * distance;
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The point at `distance` along the ray through pixel position (px, py). */
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

static void turn_normal(const struct surface_view *view, float *const normal[3], size_t i,
                        float out[3])
{
    const float n[3] = {normal[0][i], normal[1][i], normal[2][i]};
    out[0] = dot(n, view->camera->right);
    out[1] = dot(n, view->camera->up);
    out[2] = dot(n, view->camera->forward);
}

static void pixel_position(const struct patch *patch, size_t i, float *px, float *py)
{
    size_t width = (size_t)rect_width(patch->rect);
    *px = (float)(patch->rect.x0 + (int32_t)(i % width));
    *py = (float)(patch->rect.y0 + (int32_t)(i / width));
}

/* A pixel's id as a sub-sample's plane has it: 0 is no surface there, so low bits of 0 read 0xffff.
 */
static uint32_t sub_id(uint32_t id)
{
    uint32_t low = id & 0xffffu;
    return low != 0 ? low : 0xffffu;
}

bool surface_of_pixel(const struct surface_view *view, const struct patch *patch, size_t i,
                      struct surface *out)
{
    out->distance = patch->depth[i];
    if (!(out->distance > 0.0f)) return false;
    float px, py;
    pixel_position(patch, i, &px, &py);
    place_point(view, px + 0.5f, py + 0.5f, out->distance, out->point);
    turn_normal(view, patch->normal, i, out->normal);
    out->id = patch->id ? sub_id(patch->id[i]) : 0;
    return true;
}

bool surface_of_sub(const struct surface_view *view, const struct patch *patch, size_t i,
                    uint32_t k, const float offset[2], struct surface *out)
{
    out->distance = patch->sub_depth[k][i];
    if (!(out->distance > 0.0f)) return false;
    float px, py;
    pixel_position(patch, i, &px, &py);
    place_point(view, px + offset[0], py + offset[1], out->distance, out->point);
    turn_normal(view, patch->sub_normal[k], i, out->normal);
    out->id = patch->sub_id[k] ? patch->sub_id[k][i] : 0;
    return true;
}

/* How far the sub-sample is off the pixel's tangent plane, and how far it may be. */
static void plane_distance(const struct surface_view *view, const struct surface *sub,
                           const struct surface *pixel, float cosine, float *off, float *allowed)
{
    const float d[3] = {sub->point[0] - pixel->point[0], sub->point[1] - pixel->point[1],
                        sub->point[2] - pixel->point[2]};
    float sine = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f)); /* rounding may pass 1 */
    *off = fabsf(dot(d, pixel->normal));
    /* Points are within 1e16 of the eye (gather.h): squares are finite. */
    *allowed = surface_pixel_size(view, fmaxf(sub->distance, pixel->distance)) * SURFACE_PLANE_PX +
               sqrtf(dot(d, d)) * (sine + SURFACE_SLACK);
}

float surface_match(const struct surface_view *view, const struct surface *sub,
                    const struct surface *pixel)
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

static void face(const struct surface_view *view, const struct patch *patch, size_t i,
                 struct surface_facing *facing)
{
    struct surface s;
    facing->known = true;
    facing->along = facing->across = 1.0f;
    if (!surface_of_pixel(view, patch, i, &s)) return;
    /* The point's distance from the eye is the depth, which is above 0. */
    float cosine = view->orthographic ? s.normal[2] : dot(s.point, s.normal) / s.distance;
    float chord = view->orthographic ? 0.0f : view->pixel_size;
    facing->along = fabsf(cosine);
    facing->across = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f)) + chord;
}

/* With r and r' the unit rays, x' - x = d'(r' - r) + (d' - d) r. Its part along n is at most
 * d'|r' - r| sin + |d' - d| cos, cos = |r.n|, up to |r' - r| itself in the sine; |r' - r| is at
 * most a corner's pixels. With any cos, both factors are at most 1: asked first. */
bool surface_surely_same(const struct surface_view *view, const struct patch *patch, size_t i,
                         uint32_t k, struct surface_facing *facing)
{
    float own = patch->depth[i], sub = patch->sub_depth[k][i];
    if (!(own > 0.0f) || !(sub > 0.0f)) return false;
    if (patch->id && patch->sub_id[k] && sub_id(patch->id[i]) != patch->sub_id[k][i]) return false;
    float *const *n = patch->normal, *const *m = patch->sub_normal[k];
    float cosine = n[0][i] * m[0][i] + n[1][i] * m[1][i] + n[2][i] * m[2][i];
    if (cosine < SURFACE_COS_FULL) return false;
    float corner = CORNER_PX * surface_pixel_size(view, sub);
    float far = own > sub ? own : sub;
    float allowed = ROUNDING * SURFACE_PLANE_PX * surface_pixel_size(view, far);
    float step = fabsf(sub - own);
    if (corner + step <= allowed) return true;
    if (!facing->known) face(view, patch, i, facing);
    return corner * facing->across + step * facing->along <= allowed;
}

float surface_mismatch(const struct surface_view *view, const struct surface *sub,
                       const struct surface *pixel)
{
    float cosine = dot(sub->normal, pixel->normal), off, allowed;
    plane_distance(view, sub, pixel, cosine, &off, &allowed);
    float far = allowed > 0.0f ? fminf(off / allowed, 1e6f) : 0.0f;
    return far + 8.0f * (1.0f - cosine) + (sub->id == pixel->id ? 0.0f : 4.0f);
}
