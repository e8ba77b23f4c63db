#pragma once
/* Turns triangles into surfaces, in sixteen lanes: finish_surface of hit_kernels, and the parts of
 * hit_lanes.h. */
#include <math.h>
#include <string.h>

#include "worker/scene/offset.h"
#include "worker/trace/hit/hit.h"
#include "worker/trace/hit/vector_lanes.h"

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

/* Puts the same corners into every lane. */
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

static inline float largest(float a, float b, float c)
{
    float m = fabsf(a) > fabsf(b) ? fabsf(a) : fabsf(b);
    return m > fabsf(c) ? m : fabsf(c);
}

/* Computes position and facet of lane i on the triangle v0, v1, v2. Returns the magnitude of
 * offset.h. */
LANE_INLINE float place_lane(struct vector v0, struct vector v1, struct vector v2, float u, float v,
                             struct vector *position, struct vector *facet)
{
    float ax = v1.x - v0.x, ay = v1.y - v0.y, az = v1.z - v0.z;
    float bx = v2.x - v0.x, by = v2.y - v0.y, bz = v2.z - v0.z;
    float mx = largest(v0.x, v1.x, v2.x), my = largest(v0.y, v1.y, v2.y);
    float mz = largest(v0.z, v1.z, v2.z);
    *position =
        (struct vector){v0.x + u * ax + v * bx, v0.y + u * ay + v * by, v0.z + u * az + v * bz};
    *facet = (struct vector){ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx};
    return largest(mx, my, mz);
}

static void place_on_triangles(const struct corner_lanes *restrict c,
                               const struct RTCHit16 *restrict hit, float *restrict magnitude,
                               struct surface *restrict s)
{
    for (int i = 0; i < LANES; i++) {
        struct vector position, facet;
        magnitude[i] =
            place_lane(lane_get(&c->corner[0], i), lane_get(&c->corner[1], i),
                       lane_get(&c->corner[2], i), hit->u[i], hit->v[i], &position, &facet);
        lane_put(position, i, &s->position);
        lane_put(facet, i, &s->facet);
    }
}

LANE_INLINE struct vector interpolated(struct vector n0, struct vector n1, struct vector n2,
                                       float u, float v)
{
    float w = 1.0f - u - v;
    return (struct vector){w * n0.x + u * n1.x + v * n2.x, w * n0.y + u * n1.y + v * n2.y,
                           w * n0.z + u * n1.z + v * n2.z};
}

/* Interpolates the normals of smooth lanes. Lanes without normals are flat. */
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

static void place_spread(const struct mesh_view *mesh, bool bent, const struct RTCHit16 *hit,
                         float *magnitude, struct surface *s)
{
    const uint32_t *triangle = mesh->triangles + (size_t)3 * hit->primID[0];
    struct corner_lanes corners;
    struct lanes_mask smooth;
    spread_corners(triangle, mesh->positions, &corners);
    place_on_triangles(&corners, hit, magnitude, s);
    if (!bent) return;
    for (int i = 0; i < LANES; i++) smooth.on[i] = mesh->normals ? -1 : 0;
    spread_corners(triangle, mesh->normals ? mesh->normals : mesh->positions, &corners);
    interpolate_normals(&corners, &smooth, hit, s);
}

static void place_each(const struct mesh_view *const *mesh, bool bent, const struct RTCHit16 *hit,
                       float *magnitude, struct surface *s)
{
    static const float origin[3] = {0};
    static const uint32_t corner[3] = {0};
    static const struct mesh_view nothing = {.positions = origin, .triangles = corner};
    const struct mesh_view *on[LANES];
    const uint32_t *triangle[LANES];
    struct corner_lanes corners;
    struct lanes_mask smooth;
    for (int i = 0; i < LANES; i++) {
        on[i] = mesh[i] ? mesh[i] : &nothing;
        triangle[i] = on[i]->triangles + (size_t)3 * (mesh[i] ? hit->primID[i] : 0);
        put_corners(triangle[i], on[i]->positions, i, &corners);
    }
    place_on_triangles(&corners, hit, magnitude, s);
    if (!bent) return;
    for (int i = 0; i < LANES; i++) {
        smooth.on[i] = on[i]->normals ? -1 : 0;
        put_corners(triangle[i], on[i]->normals ? on[i]->normals : on[i]->positions, i, &corners);
    }
    interpolate_normals(&corners, &smooth, hit, s);
}

/* Gathers surfaces from triangles. `bent`: some normals are not their facets'; else there are none
 * yet. */
static void gather_surface(const struct mesh_view *const *mesh, bool one_triangle, bool bent,
                           const struct RTCHit16 *hit, float *magnitude, struct surface *s)
{
    if (one_triangle)
        place_spread(mesh[0], bent, hit, magnitude, s);
    else
        place_each(mesh, bent, hit, magnitude, s);
}

/* Returns whether a vector's squares, scaled by its largest component, are within range. */
LANE_INLINE int has_direction(struct vector v)
{
    float ax = fabsf(v.x), ay = fabsf(v.y), az = fabsf(v.z);
    float most = ax > ay ? ax : ay;
    most = most > az ? most : az;
    return (most > 1e-37f) & (most < 1e37f);
}

/* Returns v at unit length. It is scaled by the largest component first, so that neither tiny nor
 * huge triangles leave the range of squares; a vector without a direction becomes `fallback` times
 * `sign`. */
LANE_INLINE struct vector normalised(struct vector v, struct vector fallback, float sign)
{
    float ax = fabsf(v.x), ay = fabsf(v.y), az = fabsf(v.z);
    float most = ax > ay ? ax : ay;
    most = most > az ? most : az;
    int usable = has_direction(v);
    float down = 1.0f / (usable ? most : 1.0f);
    float x = usable ? v.x * down : sign * fallback.x;
    float y = usable ? v.y * down : sign * fallback.y;
    float z = usable ? v.z * down : sign * fallback.z;
    float scale = 1.0f / sqrtf(x * x + y * y + z * z); /* the largest component is 1, or unit */
    return (struct vector){x * scale, y * scale, z * scale};
}

/* Returns v turned to the side where its product with the unit direction d, times sign, is
 * positive. */
LANE_INLINE struct vector turned(struct vector v, struct vector d, float sign)
{
    float flip = sign * dot(v, d) < 0.0f ? -1.0f : 1.0f;
    return (struct vector){v.x * flip, v.y * flip, v.z * flip};
}

/* Returns n, bent back until it just faces the viewer. Interpolation and normal maps may turn the
 * normal of a visible facet away. */
LANE_INLINE struct vector bent_to_viewer(struct vector n, struct vector d)
{
    float facing = -dot(n, d);
    float lift = facing < FACING_MIN ? FACING_MIN - facing : 0.0f;
    float x = n.x - lift * d.x, y = n.y - lift * d.y, z = n.z - lift * d.z;
    /* A unit vector with its part along the view replaced; at least FACING_MIN long. */
    float scale = 1.0f / sqrtf(x * x + y * y + z * z);
    return (struct vector){x * scale, y * scale, z * scale};
}

/* Computes what hit.h promises of lane i of s, from a unit facet and a raw normal. `flat`: the
 * normal is that of the facet. */
LANE_INLINE void finish_vectors(struct vector direction, struct vector position,
                                struct vector facet, struct vector normal, float magnitude,
                                bool flat, int i, struct surface *s)
{
    float off = offset_distance(magnitude);
    facet = turned(facet, direction, -1.0f);
    if (flat)
        normal = facet;
    else
        normal = turned(normalised(normal, facet, 1.0f), facet, 1.0f);
    lane_put(facet, i, &s->facet);
    lane_put(facet, i, &s->plane);
    lane_put((struct vector){0.0f, 0.0f, 0.0f}, i, &s->lift);
    lane_put(bent_to_viewer(normal, direction), i, &s->normal);
    s->origin.x[i] = position.x + off * facet.x;
    s->origin.y[i] = position.y + off * facet.y;
    s->origin.z[i] = position.z + off * facet.z;
}

static void finish_flat(const struct RTCRay16 *restrict r, const float *restrict magnitude,
                        struct surface *restrict s)
{
    for (int i = 0; i < LANES; i++) {
        const struct vector direction = lane_direction(r, i);
        const struct vector facet = normalised(lane_get(&s->facet, i), direction, -1.0f);
        finish_vectors(direction, lane_get(&s->position, i), facet, facet, magnitude[i], true, i,
                       s);
    }
}

static void finish_bent(const struct RTCRay16 *restrict r, const float *restrict magnitude,
                        struct surface *restrict s)
{
    for (int i = 0; i < LANES; i++) {
        const struct vector direction = lane_direction(r, i);
        const struct vector facet = normalised(lane_get(&s->facet, i), direction, -1.0f);
        finish_vectors(direction, lane_get(&s->position, i), facet, lane_get(&s->normal, i),
                       magnitude[i], false, i, s);
    }
}

static void kernel_finish_surface(const struct RTCRay16 *rays, const float *magnitude, bool flat,
                                  struct surface *s)
{
    if (flat)
        finish_flat(rays, magnitude, s);
    else
        finish_bent(rays, magnitude, s);
}
