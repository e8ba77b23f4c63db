#pragma once
/* lane_kernels' finish_surface. Included by lane_kernels_body.h only. */
#include <math.h>
#include <string.h>

#include "worker/trace/hit.h"
#include "worker/trace/offset.h"

/* Shading normals stay at least this far (as a cosine) on the viewer's side. */
#define FACING_MIN 1e-3f

/* Unit lengths. Scaled by the largest component first, so that neither tiny nor huge triangles
 * leave the range of squares; vectors without a direction become `fallback` times `sign`. */
static void normalise(struct lanes3 *restrict v, const struct lanes3 *restrict fallback, float sign)
{
    for (int i = 0; i < LANES; i++) {
        float ax = fabsf(v->x[i]), ay = fabsf(v->y[i]), az = fabsf(v->z[i]);
        float most = ax > ay ? ax : ay;
        most = most > az ? most : az;
        int usable = (most > 1e-37f) & (most < 1e37f);
        float down = 1.0f / (usable ? most : 1.0f);
        float x = usable ? v->x[i] * down : sign * fallback->x[i];
        float y = usable ? v->y[i] * down : sign * fallback->y[i];
        float z = usable ? v->z[i] * down : sign * fallback->z[i];
        float scale = 1.0f / sqrtf(x * x + y * y + z * z); /* the largest component is 1, or unit */
        v->x[i] = x * scale;
        v->y[i] = y * scale;
        v->z[i] = z * scale;
    }
}

/* Turns v to the side where its product with the unit direction d, times sign, is positive. */
static void turn(struct lanes3 *restrict v, const struct lanes3 *restrict d, float sign)
{
    for (int i = 0; i < LANES; i++) {
        float side = sign * (v->x[i] * d->x[i] + v->y[i] * d->y[i] + v->z[i] * d->z[i]);
        float flip = side < 0.0f ? -1.0f : 1.0f;
        v->x[i] *= flip;
        v->y[i] *= flip;
        v->z[i] *= flip;
    }
}

/* Interpolation and normal maps may turn a normal away from the viewer of a visible facet: it is
 * bent back until it just faces him. */
static void bend_to_viewer(struct lanes3 *restrict n, const struct lanes3 *restrict direction)
{
    for (int i = 0; i < LANES; i++) {
        float facing =
            -(n->x[i] * direction->x[i] + n->y[i] * direction->y[i] + n->z[i] * direction->z[i]);
        float lift = facing < FACING_MIN ? FACING_MIN - facing : 0.0f;
        float x = n->x[i] - lift * direction->x[i], y = n->y[i] - lift * direction->y[i];
        float z = n->z[i] - lift * direction->z[i];
        /* A unit vector with its part along the view replaced; at least FACING_MIN long. */
        float scale = 1.0f / sqrtf(x * x + y * y + z * z);
        n->x[i] = x * scale;
        n->y[i] = y * scale;
        n->z[i] = z * scale;
    }
}

static void leave_surface(const float magnitude[LANES], struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        float d = offset_distance(magnitude[i]);
        s->origin.x[i] = s->position.x[i] + d * s->facet.x[i];
        s->origin.y[i] = s->position.y[i] + d * s->facet.y[i];
        s->origin.z[i] = s->position.z[i] + d * s->facet.z[i];
    }
}

static void kernel_finish_surface(const struct RTCRay16 *rays, const float magnitude[LANES],
                                  struct surface *s)
{
    struct lanes3 direction;
    memcpy(direction.x, rays->dir_x, sizeof direction.x);
    memcpy(direction.y, rays->dir_y, sizeof direction.y);
    memcpy(direction.z, rays->dir_z, sizeof direction.z);
    normalise(&s->facet, &direction, -1.0f);
    turn(&s->facet, &direction, -1.0f);
    normalise(&s->normal, &s->facet, 1.0f);
    turn(&s->normal, &s->facet, 1.0f);
    bend_to_viewer(&s->normal, &direction);
    leave_surface(magnitude, s);
}
