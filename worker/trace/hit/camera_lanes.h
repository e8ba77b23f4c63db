#pragma once
/* hit_kernels' place_subs and camera_rays. The second is plan_camera_ray (proto/plan.c) in sixteen
 * lanes. */
#include <math.h>

#include "proto/plan.h"
#include "worker/trace/hit/block.h"
#include "worker/trace/hit/queries.h"

static void kernel_place_subs(const struct pattern_pixels *restrict pattern,
                              const struct block *restrict b, uint32_t k, float *restrict px,
                              float *restrict py)
{
    const struct pattern_pixels p = *pattern;
    for (int i = 0; i < LANES; i++) {
        px[i] = (float)b->x_px[i] + pattern_pixels_at(&p, b->x_px[i], b->y_px[i], k, 0);
        py[i] = (float)b->y_px[i] + pattern_pixels_at(&p, b->x_px[i], b->y_px[i], k, 1);
    }
}

static void perspective_rays(const struct plan_camera *c, const float *restrict a,
                             const float *restrict b, struct RTCRay16 *restrict r)
{
    for (int i = 0; i < LANES; i++) {
        float x = c->forward[0] + a[i] * c->right[0] + b[i] * c->up[0];
        float y = c->forward[1] + a[i] * c->right[1] + b[i] * c->up[1];
        float z = c->forward[2] + a[i] * c->right[2] + b[i] * c->up[2];
        /* At least the length of forward, about 1: right and up are orthogonal to it. */
        float scale = 1.0f / sqrtf(x * x + y * y + z * z);
        r->org_x[i] = c->eye[0];
        r->org_y[i] = c->eye[1];
        r->org_z[i] = c->eye[2];
        r->dir_x[i] = x * scale;
        r->dir_y[i] = y * scale;
        r->dir_z[i] = z * scale;
    }
}

static void orthographic_rays(const struct plan_camera *c, const float *restrict a,
                              const float *restrict b, struct RTCRay16 *restrict r)
{
    for (int i = 0; i < LANES; i++) {
        r->org_x[i] = c->eye[0] + a[i] * c->right[0] + b[i] * c->up[0];
        r->org_y[i] = c->eye[1] + a[i] * c->right[1] + b[i] * c->up[1];
        r->org_z[i] = c->eye[2] + a[i] * c->right[2] + b[i] * c->up[2];
        r->dir_x[i] = c->forward[0];
        r->dir_y[i] = c->forward[1];
        r->dir_z[i] = c->forward[2];
    }
}

static void camera_rays_through(const struct plan_camera *c, const float *a, const float *b,
                                struct RTCRay16 *rays)
{
    for (int i = 0; i < LANES; i++) {
        rays->tnear[i] = 0.0f;
        rays->tfar[i] = INFINITY;
    }
    if (c->type == CAMERA_ORTHOGRAPHIC)
        orthographic_rays(c, a, b, rays);
    else
        perspective_rays(c, a, b, rays);
}

static void kernel_camera_rays(const struct plan *plan, const float *px, const float *py,
                               struct RTCRay16 *rays)
{
    const struct plan_camera *c = &plan->camera;
    float width = (float)plan->width_px, height = (float)plan->height_px;
    _Alignas(LANES_ALIGN) float a[LANES], b[LANES];
    for (int i = 0; i < LANES; i++) {
        a[i] = (2.0f * px[i] / width - 1.0f - c->centre_x) * c->half_width;
        b[i] = (1.0f - 2.0f * py[i] / height - c->centre_y) * c->half_height;
    }
    camera_rays_through(c, a, b, rays);
}
