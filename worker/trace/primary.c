#include "worker/trace/primary.h"

#include <math.h>

static void perspective_rays(const struct plan_camera *c, const float a[LANES],
                             const float b[LANES], struct RTCRay16 *r)
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

static void orthographic_rays(const struct plan_camera *c, const float a[LANES],
                              const float b[LANES], struct RTCRay16 *r)
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

void primary_rays(const struct plan *plan, const float px[LANES], const float py[LANES],
                  struct RTCRayHit16 *rays)
{
    const struct plan_camera *c = &plan->camera;
    float width = (float)plan->width_px, height = (float)plan->height_px;
    _Alignas(LANES_ALIGN) float a[LANES], b[LANES];
    for (int i = 0; i < LANES; i++) {
        a[i] = (2.0f * px[i] / width - 1.0f) * c->half_width;
        b[i] = (1.0f - 2.0f * py[i] / height) * c->half_height;
        rays->ray.tnear[i] = 0.0f;
        rays->ray.tfar[i] = INFINITY;
    }
    if (c->type == CAMERA_ORTHOGRAPHIC)
        orthographic_rays(c, a, b, &rays->ray);
    else
        perspective_rays(c, a, b, &rays->ray);
}

static void trace(struct queries *q, const struct plan *plan, const struct block *b,
                  const float px[LANES], const float py[LANES], struct RTCRayHit16 *rays,
                  struct surface *out)
{
    struct lanes_mask valid = b->inside;
    primary_rays(plan, px, py, rays);
    queries_sanitise(q, &valid, &rays->ray);
    queries_closest(q, QUERY_CAMERA, &valid, rays);
    hit_resolve(q, &valid, rays, out);
}

void primary_trace(struct queries *q, const struct plan *plan, const struct block *b,
                   struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float px[LANES], py[LANES];
    for (int i = 0; i < LANES; i++) {
        px[i] = (float)b->x_px[i] + 0.5f;
        py[i] = (float)b->y_px[i] + 0.5f;
    }
    trace(q, plan, b, px, py, rays, out);
}

void primary_trace_sub(struct queries *q, const struct plan *plan, const struct block *b,
                       uint32_t k, struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float px[LANES], py[LANES];
    for (int i = 0; i < LANES; i++) {
        float at[2];
        pattern_pixel(&plan->pattern, b->x_px[i], b->y_px[i], k, plan->sub_samples, at);
        px[i] = (float)b->x_px[i] + at[0];
        py[i] = (float)b->y_px[i] + at[1];
    }
    trace(q, plan, b, px, py, rays, out);
}
