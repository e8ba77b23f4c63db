#pragma once
/* The place_receivers of shadow_kernels, and how receivers move on the screen. Formulas are of one
 * receiver, in loops over short arrays that the compiler vectorises. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/shadow/coverage.h"
#include "server/reconstruct/shadow/receiver.h"
#include "server/reconstruct/shadow/shadow_lanes.h"
#include "server/reconstruct/simd/clamp.h"
#include "server/reconstruct/simd/inline.h"

#define RECEIVER_PLANE_PX 2.0f
#define RECEIVER_FAR_PX   120.0f
#define RECEIVER_GRAZING  0.02f /* least cosine towards the light that directions are taken at */
#define RECEIVER_GAMMA    0.95f /* a half-side */
#define RECEIVER_FRONT    1e-4f /* of distance and size; nearer the light's plane u is undefined */
#define RECEIVER_STEP_MAX 1e30f

static inline float receiver_along(float x, float y, float z, const float axis[3])
{
    return x * axis[0] + y * axis[1] + z * axis[2];
}

/* Planes of pixels, from one of them on. */
struct receiver_planes {
    float *point[3], *normal[3], *u[2], *gamma[2];
    float *distance, *plane_min, *distance_most2;
};

static inline struct receiver_planes receiver_planes_at(const struct shadow_pixels *p, size_t at)
{
    struct receiver_planes out = {.distance = p->distance + at,
                                  .plane_min = p->plane_min + at,
                                  .distance_most2 = p->distance_most2 + at};
    for (int k = 0; k < 3; k++) out.point[k] = p->point[k] + at, out.normal[k] = p->normal[k] + at;
    for (int k = 0; k < 2; k++) out.u[k] = p->u[k] + at, out.gamma[k] = p->gamma[k] + at;
    return out;
}

static inline void kernel_place_receivers(const struct receiver_light *light, uint32_t count,
                                          const float *depth, size_t from,
                                          const struct shadow_pixels *out)
{
    const struct receiver_light own = *light; /* no plane that is written could be it */
    const struct receiver_planes to = receiver_planes_at(out, from);
    const struct shadow_rectangle *r = &own.rectangle;
    const float *a = r->axis[0], *b = r->axis[1], *centre = r->centre;
    const float half_u = r->half[0], half_v = r->half[1], size = half_u + half_v;
    const float fixed = own.view.orthographic ? own.view.pixel_size : 0.0f;
    const float growing = own.view.orthographic ? 0.0f : own.view.pixel_size;
#pragma GCC ivdep /* planes lie beside each other */
    for (uint32_t i = 0; i < count; i++) {
        const float nx = to.normal[0][i], ny = to.normal[1][i], nz = to.normal[2][i];
        const float x = centre[0] - to.point[0][i], y = centre[1] - to.point[1][i];
        const float z = centre[2] - to.point[2][i];
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
        const float inverse_up = up > RECEIVER_GRAZING ? 1.0f / towards : 0.0f;
        const float gamma_u = facing_u * inverse_up - 4.0f * (aside_u * inverse) * inverse;
        const float gamma_v = facing_v * inverse_up - 4.0f * (aside_v * inverse) * inverse;
        const float within_u = clamp(gamma_u * half_u, -RECEIVER_GAMMA, RECEIVER_GAMMA);
        const float within_v = clamp(gamma_v * half_v, -RECEIVER_GAMMA, RECEIVER_GAMMA);
        to.normal[0][i] = simd_keep(lit, nx);
        to.normal[1][i] = simd_keep(lit, ny);
        to.normal[2][i] = simd_keep(lit, nz);
        to.u[0][i] = lit ? -aside_u * inverse_front : 0.0f;
        to.u[1][i] = lit ? -aside_v * inverse_front : 0.0f;
        to.distance[i] = lit ? front : 0.0f;
        to.plane_min[i] = lit ? RECEIVER_PLANE_PX * pixel : 0.0f;
        to.distance_most2[i] = lit ? RECEIVER_FAR_PX * pixel * RECEIVER_FAR_PX * pixel : 0.0f;
        to.gamma[0][i] = lit ? within_u : 0.0f;
        to.gamma[1][i] = lit ? within_v : 0.0f;
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

/* Returns by how many pixels a point at `at` of a screen axis moves there when it moves by `moved`
 * along it, and by moved_along from the eye, at the depth 1 / inverse_along. */
static inline float receiver_screen(float perspective, float at, float moved, float inverse_along,
                                    float moved_along, float per_step)
{
    const float near = (moved - at * inverse_along * moved_along) * inverse_along;
    const float e = (perspective > 0.0f ? near : moved) * per_step;
    return fabsf(e) < RECEIVER_STEP_MAX ? e : 0.0f;
}

/* What steps along both light axes of a lit receiver share. */
struct receiver_aim {
    float x, y, z;       /* to the light's centre */
    float inverse_up;    /* of its part along the normal; at grazing angles, of the least */
    float inverse_depth; /* of the distance along the view */
    float across, above; /* on the screen's axes */
};

/* Returns it for a receiver at (px, py, pz) with the normal n. It lies in front of the eye. */
static inline struct receiver_aim receiver_aim(const struct receiver_stepper *s, float px, float py,
                                               float pz, float nx, float ny, float nz)
{
    const float x = s->centre[0] - px, y = s->centre[1] - py, z = s->centre[2] - pz;
    const float up = x * nx + y * ny + z * nz;
    const float least = RECEIVER_GRAZING * sqrtf(x * x + y * y + z * z);
    const float guarded = fabsf(up) >= least ? up : up < 0.0f ? -least : least; /* lit: not 0 */
    return (struct receiver_aim){x,
                                 y,
                                 z,
                                 1.0f / guarded,
                                 1.0f / receiver_along(px, py, pz, s->forward),
                                 receiver_along(px, py, pz, s->right),
                                 receiver_along(px, py, pz, s->up)};
}

/* Computes receiver_steps along the stepper's light axis, for a receiver with the normal n. */
static inline void receiver_step(const struct receiver_stepper *s, const struct receiver_aim *aim,
                                 float nx, float ny, float nz, float *step_x, float *step_y)
{
    const float lambda = receiver_along(nx, ny, nz, s->axis) * aim->inverse_up;
    const float tx = s->axis[0] - lambda * aim->x, ty = s->axis[1] - lambda * aim->y;
    const float tz = s->axis[2] - lambda * aim->z, inverse = aim->inverse_depth;
    const float along = receiver_along(tx, ty, tz, s->forward), perspective = s->perspective;
    *step_x = receiver_screen(perspective, aim->across, receiver_along(tx, ty, tz, s->right),
                              inverse, along, s->per_step[0]);
    *step_y = receiver_screen(perspective, aim->above, receiver_along(tx, ty, tz, s->up), inverse,
                              along, s->per_step[1]);
}
