#pragma once
/* lane_kernels' gather_surface and finish_surface. Included by lane_kernels_body.h only. */
#include <math.h>
#include <string.h>

#include "worker/trace/hit.h"
#include "worker/trace/offset.h"

/* Shading normals stay at least this far (as a cosine) on the viewer's side. */
#define FACING_MIN 1e-3f

/* Three floats of each corner of sixteen triangles: vertices or their normals. */
struct corner_lanes {
    struct lanes3 corner[3];
};

static inline void put_corners(const uint32_t *triangle, const float *attribute, int i,
                               struct corner_lanes *out)
{
    for (int k = 0; k < 3; k++) {
        const float *at = attribute + (size_t)3 * triangle[k];
        out->corner[k].x[i] = at[0];
        out->corner[k].y[i] = at[1];
        out->corner[k].z[i] = at[2];
    }
}

/* The same corners in every lane. */
static inline void spread_corners(const uint32_t *triangle, const float *attribute,
                                  struct corner_lanes *restrict out)
{
    for (int k = 0; k < 3; k++) {
        const float *at = attribute + (size_t)3 * triangle[k];
        const float x = at[0], y = at[1], z = at[2];
        for (int i = 0; i < LANES; i++) {
            out->corner[k].x[i] = x;
            out->corner[k].y[i] = y;
            out->corner[k].z[i] = z;
        }
    }
}

/* Camera rays of a block mostly meet one triangle: then its corners need be read only once. */
static inline bool is_one_triangle(const struct mesh_view *const *mesh, const struct RTCHit16 *hit)
{
    uint32_t differs = 0;
    bool same_mesh = mesh[0] != NULL;
    for (int i = 1; i < LANES; i++) {
        same_mesh &= mesh[i] == mesh[0];
        differs |= hit->primID[i] ^ hit->primID[0];
    }
    return same_mesh & (differs == 0);
}

static inline float largest(float a, float b, float c)
{
    float m = fabsf(a) > fabsf(b) ? fabsf(a) : fabsf(b);
    return m > fabsf(c) ? m : fabsf(c);
}

static void place_on_triangles(const struct corner_lanes *restrict c,
                               const struct RTCHit16 *restrict hit, float *restrict magnitude,
                               struct surface *restrict s)
{
    const struct lanes3 *v0 = &c->corner[0], *v1 = &c->corner[1], *v2 = &c->corner[2];
    for (int i = 0; i < LANES; i++) {
        float ax = v1->x[i] - v0->x[i], ay = v1->y[i] - v0->y[i], az = v1->z[i] - v0->z[i];
        float bx = v2->x[i] - v0->x[i], by = v2->y[i] - v0->y[i], bz = v2->z[i] - v0->z[i];
        float u = hit->u[i], v = hit->v[i];
        float mx = largest(v0->x[i], v1->x[i], v2->x[i]);
        float my = largest(v0->y[i], v1->y[i], v2->y[i]);
        float mz = largest(v0->z[i], v1->z[i], v2->z[i]);
        s->position.x[i] = v0->x[i] + u * ax + v * bx;
        s->position.y[i] = v0->y[i] + u * ay + v * by;
        s->position.z[i] = v0->z[i] + u * az + v * bz;
        s->facet.x[i] = ay * bz - az * by;
        s->facet.y[i] = az * bx - ax * bz;
        s->facet.z[i] = ax * by - ay * bx;
        magnitude[i] = largest(mx, my, mz);
    }
}

/* Lanes without normals are flat. */
static void interpolate_normals(const struct corner_lanes *restrict c,
                                const struct lanes_mask *restrict smooth,
                                const struct RTCHit16 *restrict hit, struct surface *restrict s)
{
    const struct lanes3 *n0 = &c->corner[0], *n1 = &c->corner[1], *n2 = &c->corner[2];
    for (int i = 0; i < LANES; i++) {
        float u = hit->u[i], v = hit->v[i], w = 1.0f - u - v;
        int on = smooth->on[i];
        s->normal.x[i] = on ? w * n0->x[i] + u * n1->x[i] + v * n2->x[i] : s->facet.x[i];
        s->normal.y[i] = on ? w * n0->y[i] + u * n1->y[i] + v * n2->y[i] : s->facet.y[i];
        s->normal.z[i] = on ? w * n0->z[i] + u * n1->z[i] + v * n2->z[i] : s->facet.z[i];
    }
}

static void spread_triangle(const struct mesh_view *mesh, uint32_t index,
                            struct corner_lanes *vertices, struct corner_lanes *normals,
                            struct lanes_mask *smooth)
{
    const uint32_t *triangle = mesh->triangles + (size_t)3 * index;
    spread_corners(triangle, mesh->positions, vertices);
    spread_corners(triangle, mesh->normals ? mesh->normals : mesh->positions, normals);
    for (int i = 0; i < LANES; i++) smooth->on[i] = mesh->normals ? -1 : 0;
}

static void gather_triangles(const struct mesh_view *const *mesh, const struct RTCHit16 *hit,
                             struct corner_lanes *vertices, struct corner_lanes *normals,
                             struct lanes_mask *smooth)
{
    static const float origin[3] = {0};
    static const uint32_t corner[3] = {0};
    static const struct mesh_view nothing = {.positions = origin, .triangles = corner};
    for (int i = 0; i < LANES; i++) {
        const struct mesh_view *m = mesh[i] ? mesh[i] : &nothing;
        const uint32_t *triangle = m->triangles + (size_t)3 * (mesh[i] ? hit->primID[i] : 0);
        put_corners(triangle, m->positions, i, vertices);
        smooth->on[i] = m->normals ? -1 : 0;
        put_corners(triangle, m->normals ? m->normals : m->positions, i, normals);
    }
}

static void kernel_gather_surface(const struct mesh_view *const *mesh, const struct RTCHit16 *hit,
                                  float *magnitude, struct surface *s)
{
    struct corner_lanes vertices, normals;
    struct lanes_mask smooth;
    if (is_one_triangle(mesh, hit))
        spread_triangle(mesh[0], hit->primID[0], &vertices, &normals, &smooth);
    else
        gather_triangles(mesh, hit, &vertices, &normals, &smooth);
    place_on_triangles(&vertices, hit, magnitude, s);
    interpolate_normals(&normals, &smooth, hit, s);
}

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

static void leave_surface(const float *magnitude, struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        float d = offset_distance(magnitude[i]);
        s->origin.x[i] = s->position.x[i] + d * s->facet.x[i];
        s->origin.y[i] = s->position.y[i] + d * s->facet.y[i];
        s->origin.z[i] = s->position.z[i] + d * s->facet.z[i];
    }
}

static void kernel_finish_surface(const struct RTCRay16 *rays, const float *magnitude, bool flat,
                                  struct surface *s)
{
    struct lanes3 direction;
    memcpy(direction.x, rays->dir_x, sizeof direction.x);
    memcpy(direction.y, rays->dir_y, sizeof direction.y);
    memcpy(direction.z, rays->dir_z, sizeof direction.z);
    normalise(&s->facet, &direction, -1.0f);
    turn(&s->facet, &direction, -1.0f);
    if (flat) {
        s->normal = s->facet;
    } else {
        normalise(&s->normal, &s->facet, 1.0f);
        turn(&s->normal, &s->facet, 1.0f);
    }
    bend_to_viewer(&s->normal, &direction);
    leave_surface(magnitude, s);
}
