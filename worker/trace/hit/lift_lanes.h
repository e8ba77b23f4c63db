#pragma once
/* Finds where rays start from surfaces that vertex normals make round, for hit_lanes.h.
 *
 * A facet of such a surface faces away from a light earlier than the surface does, and brightness
 * would end at the facet's edge. So rays may go below the facet's plane, down to the horizon of
 * the interpolated normal. They start from the surface that the vertex normals describe. Its point
 * is the mean of the point's projections onto the vertices' tangent planes, of those that lie
 * above it (Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4). Rays to
 * above the plane need no lift, since a convex surface does not hide itself there. */
#include "worker/trace/hit/surface_lanes.h"

/* The squared cosine, of 39 degrees, up to which a normal rounds its facet. An icosahedron's 37 are
 * within it; at the corners of a box, whose normals are means of its sides' normals, it is 55. */
#define ROUND_COSINE2 0.6f

/* The corners of sixteen triangles, and how far each lane's origin goes. */
struct lift_lanes {
    struct corner_lanes place, normal;
    struct lanes3 round; /* the interpolated normal */
    struct lanes3 lift;
};

/* Adds the way from a point to the tangent plane of a vertex, as far as the plane is above it;
 * `side`: 1 or -1 times the normal points to the ray's side. */
LANE_INLINE struct vector add_lift(struct vector sum, struct vector point, struct vector vertex,
                                   struct vector n, float side, float weight)
{
    const struct vector from = {point.x - vertex.x, point.y - vertex.y, point.z - vertex.z};
    const float below = dot(from, n), by = side * below < 0.0f ? -weight * below : 0.0f;
    return (struct vector){sum.x + by * n.x, sum.y + by * n.y, sum.z + by * n.z};
}

LANE_INLINE int is_round(struct vector n, struct vector facet, float side)
{
    const float cosine = dot(n, facet);
    return (side * cosine > 0.0f) & (cosine * cosine > ROUND_COSINE2);
}

LANE_INLINE int is_same(struct vector a, struct vector b)
{
    return (a.x == b.x) & (a.y == b.y) & (a.z == b.z);
}

/* Computes a lane's lift and its interpolated normal, in the mesh's space. Where the normals are
 * alike the triangle is flat, and nothing is lifted. */
LANE_INLINE void lift_lane(int behind, float u, float v, int i, struct lift_lanes *l)
{
    static const struct vector none = {0.0f, 0.0f, 0.0f}, any = {1.0f, 0.0f, 0.0f};
    const struct vector a = lane_get(&l->place.corner[0], i), b = lane_get(&l->place.corner[1], i);
    const struct vector c = lane_get(&l->place.corner[2], i);
    const struct vector n0 = lane_get(&l->normal.corner[0], i);
    const struct vector n1 = lane_get(&l->normal.corner[1], i);
    const struct vector n2 = lane_get(&l->normal.corner[2], i);
    struct vector point, facet, round = interpolated(n0, n1, n2, u, v), sum = none;
    place_lane(a, b, c, u, v, &point, &facet);
    facet = normalised(facet, any, 1.0f);
    const float front = dot(round, facet) < 0.0f ? -1.0f : 1.0f, side = behind ? -front : front;
    const int flat = is_same(n0, n1) & is_same(n1, n2);
    const int rounded =
        is_round(n0, facet, front) & is_round(n1, facet, front) & is_round(n2, facet, front);
    sum = add_lift(sum, point, a, n0, side, 1.0f - u - v);
    sum = add_lift(sum, point, b, n1, side, u);
    sum = add_lift(sum, point, c, n2, side, v);
    lane_put(rounded & !flat ? sum : none, i, &l->lift);
    lane_put(round, i, &l->round);
}

/* Sets the lift and the facet of lane i, whose rays leave the surface that lifted origins lie
 * on. */
LANE_INLINE void lift_origin(const struct lift_lanes *l, struct vector direction, int i,
                             struct surface *s)
{
    const struct vector lift = lane_get(&l->lift, i), facet = lane_get(&s->facet, i);
    const int up = (lift.x != 0.0f) | (lift.y != 0.0f) | (lift.z != 0.0f);
    const struct vector round =
        turned(normalised(lane_get(&l->round, i), facet, 1.0f), facet, 1.0f);
    const struct vector horizon = bent_to_viewer(round, direction);
    lane_put(lift, i, &s->lift);
    s->facet.x[i] = up ? horizon.x : facet.x;
    s->facet.y[i] = up ? horizon.y : facet.y;
    s->facet.z[i] = up ? horizon.z : facet.z;
}

/* Reads the corners of the lanes on round meshes; others get normals that lift nothing. */
static void find_round_corners(const struct mesh_view *const *mesh, const struct RTCHit16 *hit,
                               struct lift_lanes *l)
{
    static const float nothing[3] = {0.0f, 0.0f, 0.0f};
    static const uint32_t corner[3] = {0, 0, 0};
    for (int i = 0; i < LANES; i++) {
        const bool round = mesh[i] && mesh[i]->traits & MESH_ROUND;
        const uint32_t *triangle = round ? mesh[i]->triangles + (size_t)3 * hit->primID[i] : corner;
        put_corners(triangle, round ? mesh[i]->positions : nothing, i, &l->place);
        put_corners(triangle, round ? mesh[i]->normals : nothing, i, &l->normal);
    }
}

static void find_lifts(const struct surface *restrict s, const struct RTCHit16 *restrict hit,
                       struct lift_lanes *restrict l)
{
    for (int i = 0; i < LANES; i++) lift_lane(s->behind.on[i], hit->u[i], hit->v[i], i, l);
}

static void lift_origins(const struct RTCRay16 *restrict r, const struct lift_lanes *restrict l,
                         struct surface *restrict s)
{
    for (int i = 0; i < LANES; i++) lift_origin(l, lane_direction(r, i), i, s);
}
