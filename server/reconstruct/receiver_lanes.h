#pragma once
/* shadow_kernels' place_receivers, and how receivers move on the screen. Formulas of one receiver,
 * and loops over short arrays that the compiler vectorises. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/coverage.h"
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

/* Receivers before they are spread over sources and targets. */
struct receiver_chunk {
    float front[RECEIVER_LANES], pixel[RECEIVER_LANES];
    float u[2][RECEIVER_LANES], gamma[2][RECEIVER_LANES];
    int32_t lit[RECEIVER_LANES]; /* the light reaches it, from far enough off the light's plane */
};

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
        c->lit[i] = (towards + rise > 0.0f) & (front > RECEIVER_FRONT * (size + distance));
        /* lit: neither is 0 */
        const float inverse_front = 1.0f / front, inverse = 1.0f / distance;
        const float up = towards * inverse;
        const float inverse_up = up > RECEIVER_GRAZING ? inverse / up : 0.0f;
        const float gamma_u = facing_u * inverse_up - 4.0f * (aside_u * inverse) * inverse;
        const float gamma_v = facing_v * inverse_up - 4.0f * (aside_v * inverse) * inverse;
        c->front[i] = front;
        c->pixel[i] = fixed + growing * depth[i];
        c->u[0][i] = -aside_u * inverse_front;
        c->u[1][i] = -aside_v * inverse_front;
        c->gamma[0][i] = receiver_clamp(gamma_u * half_u, -RECEIVER_GAMMA, RECEIVER_GAMMA);
        c->gamma[1][i] = receiver_clamp(gamma_v * half_v, -RECEIVER_GAMMA, RECEIVER_GAMMA);
    }
}

/* Pixel i as it is to its neighbours, and they to it. */
static inline void receiver_spread(const struct receiver_chunk *c, uint32_t i,
                                   struct shadow_source *s, struct shadow_target *t)
{
    const float pixel = c->pixel[i];
    s->u[0] = c->u[0][i];
    s->u[1] = c->u[1][i];
    t->distance = c->front[i];
    t->plane_least = RECEIVER_PLANE_PX * pixel;
    t->distance_most2 = RECEIVER_FAR_PX * pixel * RECEIVER_FAR_PX * pixel;
    t->gamma[0] = c->gamma[0][i];
    t->gamma[1] = c->gamma[1][i];
}

static inline void kernel_place_receivers(const struct receiver_light *light, uint32_t count,
                                          const float *depth, const float *const point[3],
                                          const float *const normal[3],
                                          struct shadow_source *sources,
                                          struct shadow_target *targets)
{
    struct receiver_chunk c;
    for (uint32_t first = 0; first < count; first += RECEIVER_LANES) {
        const uint32_t left = count - first, n = left < RECEIVER_LANES ? left : RECEIVER_LANES;
        const float *const p[3] = {point[0] + first, point[1] + first, point[2] + first};
        const float *const q[3] = {normal[0] + first, normal[1] + first, normal[2] + first};
        receiver_place(light, depth + first, p, q, n, &c);
        for (uint32_t i = 0; i < n; i++) {
            struct shadow_source s = RECEIVER_NO_SOURCE;
            struct shadow_target t = RECEIVER_NO_TARGET;
            for (int k = 0; k < 3; k++) {
                s.point[k] = p[k][i];
                s.normal[k] = c.lit[i] ? q[k][i] : 0.0f;
            }
            if (c.lit[i]) receiver_spread(&c, i, &s, &t);
            sources[first + i] = s;
            targets[first + i] = t;
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
