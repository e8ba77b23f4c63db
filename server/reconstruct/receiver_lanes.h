#pragma once
/* shadow_kernels' place_receivers, and how receivers move on the screen. Formulas of one receiver,
 * and loops over short arrays that the compiler vectorises. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/coverage.h"
#include "server/reconstruct/lanes_inline.h"
#include "server/reconstruct/receiver.h"

#define RECEIVER_LANES     16
#define RECEIVER_PLANE_PX  2.0f
#define RECEIVER_FAR_PX    120.0f
#define RECEIVER_GRAZING   0.02f /* least cosine towards the light that directions are taken at */
#define RECEIVER_GAMMA     0.95f /* a half-side */
#define RECEIVER_FRONT     1e-4f /* of distance and size; nearer the light's plane u means nothing */
#define RECEIVER_STEP_MOST 1e30f

static inline float receiver_along(float x, float y, float z, const float axis[3])
{
    return x * axis[0] + y * axis[1] + z * axis[2];
}

static inline float receiver_clamp(float v, float least, float most)
{
    return v < least ? least : v > most ? most : v;
}

/* What is found of receivers side by side. */
struct receiver_chunk {
    _Alignas(64) float normal[3][RECEIVER_LANES], u[2][RECEIVER_LANES], distance[RECEIVER_LANES];
    float plane_least[RECEIVER_LANES], distance_most2[RECEIVER_LANES], gamma[2][RECEIVER_LANES];
};

/* Lit: the light reaches it, from far enough off the light's plane. */
static inline void receiver_place(const struct receiver_light *light, const float *depth,
                                  const float *const p[3], const float *const n[3], uint32_t count,
                                  struct receiver_chunk *c)
{
    const struct shadow_rectangle *r = &light->rectangle;
    const float *a = r->axis[0], *b = r->axis[1], *centre = r->centre;
    const float half_u = r->half[0], half_v = r->half[1], size = half_u + half_v;
    const float fixed = light->view.orthographic ? light->view.pixel_size : 0.0f;
    const float growing = light->view.orthographic ? 0.0f : light->view.pixel_size;
    for (uint32_t i = 0; i < count; i++) {
        const float nx = n[0][i], ny = n[1][i], nz = n[2][i];
        const float x = centre[0] - p[0][i], y = centre[1] - p[1][i], z = centre[2] - p[2][i];
        const float facing_u = receiver_along(nx, ny, nz, a);
        const float facing_v = receiver_along(nx, ny, nz, b);
        const float aside_u = receiver_along(x, y, z, a), aside_v = receiver_along(x, y, z, b);
        const float distance = sqrtf(x * x + y * y + z * z), towards = x * nx + y * ny + z * nz;
        const float front = -receiver_along(x, y, z, r->normal);
        const float rise = half_u * fabsf(facing_u) + half_v * fabsf(facing_v);
        const int32_t lit = (towards + rise > 0.0f) & (front > RECEIVER_FRONT * (size + distance));
        /* lit: neither is 0 */
        const float inverse_front = 1.0f / front, inverse = 1.0f / distance;
        const float up = towards * inverse, pixel = fixed + growing * depth[i];
        const float inverse_up = up > RECEIVER_GRAZING ? inverse / up : 0.0f;
        const float gamma_u = facing_u * inverse_up - 4.0f * (aside_u * inverse) * inverse;
        const float gamma_v = facing_v * inverse_up - 4.0f * (aside_v * inverse) * inverse;
        const float within_u = receiver_clamp(gamma_u * half_u, -RECEIVER_GAMMA, RECEIVER_GAMMA);
        const float within_v = receiver_clamp(gamma_v * half_v, -RECEIVER_GAMMA, RECEIVER_GAMMA);
        c->normal[0][i] = lit ? nx : 0.0f;
        c->normal[1][i] = lit ? ny : 0.0f;
        c->normal[2][i] = lit ? nz : 0.0f;
        c->u[0][i] = lit ? -aside_u * inverse_front : 0.0f;
        c->u[1][i] = lit ? -aside_v * inverse_front : 0.0f;
        c->distance[i] = lit ? front : 0.0f;
        c->plane_least[i] = lit ? RECEIVER_PLANE_PX * pixel : 0.0f;
        c->distance_most2[i] = lit ? RECEIVER_FAR_PX * pixel * RECEIVER_FAR_PX * pixel : 0.0f;
        c->gamma[0][i] = lit ? within_u : 0.0f;
        c->gamma[1][i] = lit ? within_v : 0.0f;
    }
}

LANES_INLINE void receiver_store(const struct receiver_chunk *c, size_t at, size_t count,
                                 const struct shadow_pixels *out)
{
    const size_t bytes = count * sizeof(float);
    for (int k = 0; k < 3; k++) memcpy(out->normal[k] + at, c->normal[k], bytes);
    for (int k = 0; k < 2; k++) memcpy(out->u[k] + at, c->u[k], bytes);
    memcpy(out->distance + at, c->distance, bytes);
    memcpy(out->plane_least + at, c->plane_least, bytes);
    memcpy(out->distance_most2 + at, c->distance_most2, bytes);
    for (int k = 0; k < 2; k++) memcpy(out->gamma[k] + at, c->gamma[k], bytes);
}

static inline void kernel_place_receivers(const struct receiver_light *light, uint32_t count,
                                          const float *depth, size_t from,
                                          const struct shadow_pixels *out)
{
    const struct receiver_light own = *light; /* no plane that is written could be it */
    struct receiver_chunk c;
    for (uint32_t first = 0; first < count; first += RECEIVER_LANES) {
        const uint32_t left = count - first;
        const size_t at = from + first;
        const float *const p[3] = {out->point[0] + at, out->point[1] + at, out->point[2] + at};
        const float *const n[3] = {out->normal[0] + at, out->normal[1] + at, out->normal[2] + at};
        if (left >= RECEIVER_LANES) {
            receiver_place(&own, depth + first, p, n, RECEIVER_LANES, &c);
            receiver_store(&c, at, RECEIVER_LANES, out);
        } else {
            receiver_place(&own, depth + first, p, n, left, &c);
            receiver_store(&c, at, left, out);
        }
    }
}

/* Constants of receiver_step, side by side so that a loop can keep them. */
struct receiver_stepper {
    float centre[3], axis[3];
    float right[3], up[3], forward[3];
    float perspective; /* 0 if orthographic, else 1 */
    float per_step[2]; /* 1 / (plane coordinates a pixel) */
};

static inline struct receiver_stepper receiver_stepper_of(const struct receiver_light *light,
                                                          int axis)
{
    const struct surface_view *view = &light->view;
    struct receiver_stepper s = {.perspective = view->orthographic ? 0.0f : 1.0f,
                                 .per_step = {1.0f / view->a_step, 1.0f / view->b_step}};
    for (int k = 0; k < 3; k++) {
        s.centre[k] = light->rectangle.centre[k];
        s.axis[k] = light->rectangle.axis[axis][k];
        s.right[k] = view->camera->right[k];
        s.up[k] = view->camera->up[k];
        s.forward[k] = view->camera->forward[k];
    }
    return s;
}

/* Pixels that what is at `at` of a screen axis moves there when it moves by `moved`; away from the
 * eye at 1 / inverse_along, by moved_along. */
static inline float receiver_screen(float perspective, float at, float moved, float inverse_along,
                                    float moved_along, float per_step)
{
    const float near = (moved - at * inverse_along * moved_along) * inverse_along;
    const float e = (perspective > 0.0f ? near : moved) * per_step;
    return fabsf(e) < RECEIVER_STEP_MOST ? e : 0.0f;
}

/* Steps along a light axis of a lit receiver at (px, py, pz) with the normal n: receiver_steps. */
static inline void receiver_step(const struct receiver_stepper *s, float px, float py, float pz,
                                 float nx, float ny, float nz, float *step_x, float *step_y)
{
    const float x = s->centre[0] - px, y = s->centre[1] - py, z = s->centre[2] - pz;
    const float up = x * nx + y * ny + z * nz;
    const float least = RECEIVER_GRAZING * sqrtf(x * x + y * y + z * z);
    const float guarded = fabsf(up) >= least ? up : up < 0.0f ? -least : least;
    const float lambda = receiver_along(nx, ny, nz, s->axis) / guarded; /* lit: not 0 */
    const float tx = s->axis[0] - lambda * x, ty = s->axis[1] - lambda * y;
    const float tz = s->axis[2] - lambda * z;
    /* the point is in front of the eye: it has a depth */
    const float inverse = 1.0f / receiver_along(px, py, pz, s->forward);
    const float along = receiver_along(tx, ty, tz, s->forward), perspective = s->perspective;
    *step_x = receiver_screen(perspective, receiver_along(px, py, pz, s->right),
                              receiver_along(tx, ty, tz, s->right), inverse, along, s->per_step[0]);
    *step_y = receiver_screen(perspective, receiver_along(px, py, pz, s->up),
                              receiver_along(tx, ty, tz, s->up), inverse, along, s->per_step[1]);
}
