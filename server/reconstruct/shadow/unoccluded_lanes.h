#pragma once
/* The unoccluded of shadow_kernels: E = integral of I cos cos' / d^2 over a rectangle, for many
 * receivers at once. The compiler vectorises its loops over short arrays for whatever instruction
 * set the including file is compiled for.
 *
 *   uniform, near  Lambert's formula over the outline cut at the receiver's horizon (Lambert 1760;
 *                  Baum et al. 1989): E = 1/2 |sum of theta_i n . (v_i x v_i+1) / |v_i x v_i+1||
 *   uniform, far   its sum cancels down to (size/distance)^2 of its terms, so that below an eighth
 *                  3 x 3 Gauss-Legendre points are nearer, if the whole light is up; and below
 *                  a thousandth in any case
 *   Gaussian, far  4 x 4 points of the Gauss rule for the profile exp(-2 u^2), if the whole light
 *                  is up; else 12 x 12 Gauss-Legendre points over the part that is
 *   Gaussian, near Lambert's formula times the mean of the profile, weighted with cos cos' / d^2,
 *                  over such 12 x 12 points */
#include <math.h>
#include <stddef.h>

#include "proto/plan.h"
#include "server/reconstruct/shadow/shadow_kernels.h"
#include "server/reconstruct/shadow/unoccluded_quadrature_lanes.h"
#include "server/reconstruct/simd/inline.h"

#define UNOCCLUDED_FAR2     64.0f /* (distance / half-diagonal)^2, uniform, the light all up */
#define UNOCCLUDED_VERY_FAR 1e6f  /* the same, anyway */
#define UNOCCLUDED_PROFILE2 6.0f  /* (distance / half-diagonal)^2 of Gaussian ones */
/* On a light, or beside it in its plane, rounding decides whether a receiver is in front of the
 * light and the light above its horizon, and could yield a whole hemisphere. So E is 0 for
 * receivers nearer to the plane than the rounding error of the way from the eye. It is also 0 for
 * those that face as the light does, if the light rises by no more than UNOCCLUDED_RISE of its
 * size. */
#define UNOCCLUDED_ROUNDING 4e-6f
#define UNOCCLUDED_RISE     5e-4f
#define UNOCCLUDED_FACING   0.5f

static inline float unoccluded_dot(float ax, float ay, float az, float bx, float by, float bz)
{
    return fused(az, bz, fused(ay, by, ax * bx));
}

/* Returns theta n . (a x b) / |a x b| for unit vectors a, b, from their scalar product, n . (a x b)
 * and |a x b|. theta / sin(theta) is a fit for acute angles with error 2e-8. Obtuse ones take it
 * from the opposite angle, and the sine from the product itself, which avoids dividing by a root
 * that cancels. */
static inline float unoccluded_arc(float cosine, float along, float sine)
{
    const float x = fabsf(cosine);
    /* by pairs of coefficients: half as many steps that wait for each other */
    const float x2 = x * x, x4 = x2 * x2;
    const float fit01 = fused(x, -0.999996f, 1.57079631f);
    const float fit23 = fused(x, -0.664857777f, 0.785263024f);
    const float fit45 = fused(x, -0.480613401f, 0.576413591f);
    const float fit67 = fused(x, -0.192103921f, 0.348387262f);
    const float fit89 = fused(x, -0.0111628242f, 0.0678737293f);
    const float high = fused(x4, fit89, fused(x2, fit67, fit45));
    const float fit = fused(x4, high, fused(x2, fit23, fit01));
    float share = along / (sine > UNOCCLUDED_TINY ? sine : UNOCCLUDED_TINY);
    share = share < 1.0f ? share : 1.0f; /* where squares underflow */
    share = share > -1.0f ? share : -1.0f;
    const float acute = fit * (sine < 1.0f ? sine : 1.0f);
    return share * (cosine < 0.0f ? 3.14159265f - acute : acute);
}

static void unoccluded_reach(const struct shadow_rectangle *light, size_t first, size_t count,
                             const float *const point[3], struct unoccluded_chunk *c)
{
    const float unit = 1.0f / (light->half[0] + light->half[1]), *o = light->centre;
    float centre = 0.0f;
    for (int k = 0; k < 3; k++) centre += fabsf(o[k] * unit);
    for (size_t i = count; i < UNOCCLUDED_LANES; i++) c->reach[i] = centre;
    for (size_t i = 0; i < count; i++) {
        const float x = fabsf(point[0][first + i] * unit), y = fabsf(point[1][first + i] * unit);
        c->reach[i] = centre + x + y + fabsf(point[2][first + i] * unit);
    }
}

/* Loads receivers in units of the light's size, on which E does not depend, so that squares of
 * squares stay finite. */
static void unoccluded_load(const struct shadow_rectangle *light, size_t first, size_t count,
                            const float *const point[3], const float *const normal[3],
                            struct unoccluded_chunk *c)
{
    const float unit = 1.0f / (light->half[0] + light->half[1]);
    c->half[0] = light->half[0] * unit;
    c->half[1] = light->half[1] * unit;
    for (int k = 0; k < 3; k++) {
        /* lanes past the end stand in the light's centre and have no normal */
        for (size_t i = count; i < UNOCCLUDED_LANES; i++) c->centre[k][i] = c->normal[k][i] = 0.0f;
        for (size_t i = 0; i < count; i++) {
            c->centre[k][i] = (light->centre[k] - point[k][first + i]) * unit;
            c->normal[k][i] = normal[k][first + i];
        }
    }
    unoccluded_reach(light, first, count, point, c);
    const float *a = light->axis[0], *b = light->axis[1], *n = light->normal;
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        const float x = c->centre[0][i], y = c->centre[1][i], z = c->centre[2][i];
        const float nx = c->normal[0][i], ny = c->normal[1][i], nz = c->normal[2][i];
        c->front[i] = -unoccluded_dot(x, y, z, n[0], n[1], n[2]);
        c->up[i] = unoccluded_dot(x, y, z, nx, ny, nz);
        c->up_u[i] = c->half[0] * unoccluded_dot(nx, ny, nz, a[0], a[1], a[2]);
        c->up_v[i] = c->half[1] * unoccluded_dot(nx, ny, nz, b[0], b[1], b[2]);
        c->across_u[i] = 2.0f * c->half[0] * unoccluded_dot(x, y, z, a[0], a[1], a[2]);
        c->across_v[i] = 2.0f * c->half[1] * unoccluded_dot(x, y, z, b[0], b[1], b[2]);
        c->squared[i] = unoccluded_dot(x, y, z, x, y, z);
        const float facing = unoccluded_dot(nx, ny, nz, n[0], n[1], n[2]);
        const float rise = c->up[i] + fabsf(c->up_u[i]) + fabsf(c->up_v[i]);
        const int32_t in_plane = (c->front[i] <= UNOCCLUDED_ROUNDING * c->reach[i]) |
                                 ((facing > UNOCCLUDED_FACING) & (rise <= UNOCCLUDED_RISE));
        const float kept = in_plane ? 0.0f : 1.0f; /* without a normal E is 0 */
        for (int k = 0; k < 3; k++) c->normal[k][i] *= kept;
        c->up[i] *= kept;
        c->up_u[i] *= kept;
        c->up_v[i] *= kept;
    }
}

/* Computes which part of an edge lies above the horizon, as shares a to b. Its ends lie `from` and
 * `to` above it. */
static inline void unoccluded_cut(float from, float to, float rise, float *a, float *b)
{
    const int up = from > 0.0f, up_next = to > 0.0f;
    const float steep = up == up_next ? 1.0f : rise; /* not 0 where it crosses */
    float cut = -from / steep;
    cut = cut > 0.0f ? cut : 0.0f;
    cut = cut < 1.0f ? cut : 1.0f;
    *a = up ? 0.0f : up_next ? cut : 0.0f;
    *b = up_next ? 1.0f : up ? cut : 0.0f;
}

/* The two ends of the visible part of an edge: their squares and scalar product, the square of
 * their vector product from the edge's, its part along the normal, and the edge's share between
 * them. All are computed before any is added, because steps that short let the CPU work on several
 * receivers at once. */
struct unoccluded_pair {
    _Alignas(64) float aa[UNOCCLUDED_LANES], bb[UNOCCLUDED_LANES], ab[UNOCCLUDED_LANES];
    float cross[UNOCCLUDED_LANES], along[UNOCCLUDED_LANES], share[UNOCCLUDED_LANES];
};

/* Adds the terms of pairs. */
static inline void unoccluded_add(const struct unoccluded_pair *pair, float *polygon)
{
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        const float length = sqrtf(pair->aa[i]) * sqrtf(pair->bb[i]);
        const float inverse = 1.0f / (length > UNOCCLUDED_TINY ? length : UNOCCLUDED_TINY);
        float cosine = pair->ab[i] * inverse;
        cosine = cosine > -1.0f ? cosine : -1.0f;
        cosine = cosine < 1.0f ? cosine : 1.0f;
        const float part = pair->share[i] * inverse;
        polygon[i] += unoccluded_arc(cosine, part * pair->along[i], part * sqrtf(pair->cross[i]));
    }
}

/* Adds the term of edge e from `corner`, relative to the light's centre, where it is above the
 * horizon, and notes where it crosses the horizon. `whole` says that it is above for all
 * receivers. */
SIMD_INLINE void unoccluded_edge(const float corner[3], const float e[3], bool whole,
                                 struct unoccluded_chunk *c)
{
    struct unoccluded_pair pair;
    const float ox = corner[0], oy = corner[1], oz = corner[2];
    const float ex = e[0], ey = e[1], ez = e[2];
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        const float nx = c->normal[0][i], ny = c->normal[1][i], nz = c->normal[2][i];
        const float px = c->centre[0][i] + ox, py = c->centre[1][i] + oy, pz = c->centre[2][i] + oz;
        const float from = unoccluded_dot(nx, ny, nz, px, py, pz);
        const float rise = unoccluded_dot(nx, ny, nz, ex, ey, ez);
        const float to = from + rise;
        float a = 0.0f, b = 1.0f;
        if (!whole) unoccluded_cut(from, to, rise, &a, &b);
        const float ax = fused(a, ex, px), ay = fused(a, ey, py), az = fused(a, ez, pz);
        const float bx = fused(b, ex, px), by = fused(b, ey, py), bz = fused(b, ez, pz);
        const float cx = py * ez - pz * ey, cy = pz * ex - px * ez, cz = px * ey - py * ex;
        pair.aa[i] = unoccluded_dot(ax, ay, az, ax, ay, az);
        pair.bb[i] = unoccluded_dot(bx, by, bz, bx, by, bz);
        pair.ab[i] = unoccluded_dot(ax, ay, az, bx, by, bz);
        pair.cross[i] = unoccluded_dot(cx, cy, cz, cx, cy, cz);
        pair.along[i] = unoccluded_dot(nx, ny, nz, cx, cy, cz);
        pair.share[i] = b - a;
        if (whole) continue;
        const int up = from > 0.0f, up_next = to > 0.0f;
        const int leaves = up > up_next, enters = up < up_next;
        c->leave[0][i] = leaves ? bx : c->leave[0][i];
        c->leave[1][i] = leaves ? by : c->leave[1][i];
        c->leave[2][i] = leaves ? bz : c->leave[2][i];
        c->enter[0][i] = enters ? ax : c->enter[0][i];
        c->enter[1][i] = enters ? ay : c->enter[1][i];
        c->enter[2][i] = enters ? az : c->enter[2][i];
    }
    unoccluded_add(&pair, c->polygon);
}

/* Returns whether the light is above all receivers' horizons, beyond any rounding. */
static int32_t unoccluded_is_whole(const struct unoccluded_chunk *c)
{
    int32_t whole = 1;
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) whole &= unoccluded_is_open(c, i);
    return whole;
}

/* Sums over the light's edges into c->polygon. */
SIMD_INLINE void unoccluded_outline(const struct shadow_rectangle *light, bool whole,
                                    struct unoccluded_chunk *c)
{
    static const float outline[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        for (int k = 0; k < 3; k++) c->leave[k][i] = c->enter[k][i] = 0.0f;
        c->polygon[i] = 0.0f;
    }
    for (int k = 0; k < 4; k++) {
        const float *from = outline[k], *to = outline[(k + 1) & 3];
        float corner[3], edge[3];
        for (int j = 0; j < 3; j++) {
            const float u = c->half[0] * light->axis[0][j];
            const float v = c->half[1] * light->axis[1][j];
            corner[j] = from[0] * u + from[1] * v;
            edge[j] = (to[0] - from[0]) * u + (to[1] - from[1]) * v;
        }
        unoccluded_edge(corner, edge, whole, c);
    }
}

/* Adds to c->polygon the edges along the horizon where the outline is cut. */
static void unoccluded_close(struct unoccluded_chunk *c)
{
    struct unoccluded_pair pair;
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        const float ax = c->leave[0][i], ay = c->leave[1][i], az = c->leave[2][i];
        const float bx = c->enter[0][i], by = c->enter[1][i], bz = c->enter[2][i];
        const float cx = ay * bz - az * by, cy = az * bx - ax * bz, cz = ax * by - ay * bx;
        pair.aa[i] = unoccluded_dot(ax, ay, az, ax, ay, az);
        pair.bb[i] = unoccluded_dot(bx, by, bz, bx, by, bz);
        pair.ab[i] = unoccluded_dot(ax, ay, az, bx, by, bz);
        pair.cross[i] = unoccluded_dot(cx, cy, cz, cx, cy, cz);
        pair.along[i] =
            unoccluded_dot(c->normal[0][i], c->normal[1][i], c->normal[2][i], cx, cy, cz);
        pair.share[i] = 1.0f;
    }
    unoccluded_add(&pair, c->polygon);
}

/* Computes Lambert's formula in c->polygon. */
static void unoccluded_polygon(const struct shadow_rectangle *light, bool whole,
                               struct unoccluded_chunk *c)
{
    if (whole) {
        unoccluded_outline(light, true, c);
    } else {
        unoccluded_outline(light, false, c);
        unoccluded_close(c);
    }
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        /* the light's outline runs clockwise as its receivers see it */
        const float e = -0.5f * c->polygon[i];
        c->polygon[i] = e > 0.0f ? e : 0.0f;
    }
}

/* Marks the lanes that quadrature alone serves. Returns how many of the first `count` those are. */
static size_t unoccluded_sort(const struct shadow_rectangle *light, size_t count,
                              struct unoccluded_chunk *c)
{
    const float size2 = c->half[0] * c->half[0] + c->half[1] * c->half[1];
    const bool gaussian = light->profile == PROFILE_GAUSSIAN;
    const float near2 = size2 * (gaussian ? UNOCCLUDED_PROFILE2 : UNOCCLUDED_FAR2);
    const float anyway2 = size2 * UNOCCLUDED_VERY_FAR;
    size_t far_count = 0;
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        const int all_up = c->up[i] > fabsf(c->up_u[i]) + fabsf(c->up_v[i]);
        c->far[i] = (c->squared[i] > anyway2) | (all_up & (c->squared[i] > near2));
    }
    for (size_t i = 0; i < count; i++) far_count += (size_t)c->far[i];
    return far_count;
}

static void unoccluded_near(const struct shadow_rectangle *light, struct unoccluded_chunk *c)
{
    const bool whole = unoccluded_is_whole(c);
    const float area = 4.0f * c->half[0] * c->half[1];
    const float size2 = c->half[0] * c->half[0] + c->half[1] * c->half[1];
    unoccluded_polygon(light, whole, c);
    if (light->profile != PROFILE_GAUSSIAN) return;
    if (whole)
        unoccluded_quadrature(unoccluded_nodes_12[0], unoccluded_nodes_12[1], UNOCCLUDED_ORDER,
                              true, c);
    else
        unoccluded_quadrature_above(c);
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        const float all = c->share[i] > UNOCCLUDED_TINY ? c->share[i] : UNOCCLUDED_TINY;
        const float mean = c->polygon[i] * (c->sum[i] / all);
        /* far, and cut by the horizon: the formula cancels */
        const int cancels = c->squared[i] > size2 * UNOCCLUDED_PROFILE2;
        c->polygon[i] = cancels ? c->sum[i] * area : mean;
    }
}

static void unoccluded_far(const struct shadow_rectangle *light, struct unoccluded_chunk *c)
{
    if (light->profile == PROFILE_GAUSSIAN)
        unoccluded_quadrature(unoccluded_nodes_profile[0], unoccluded_nodes_profile[1], 4, false,
                              c);
    else
        unoccluded_quadrature(unoccluded_nodes_3[0], unoccluded_nodes_3[1], 3, false, c);
}

static void kernel_unoccluded(const struct shadow_rectangle *light, uint32_t count,
                              const float *const point[3], const float *const normal[3], float *out)
{
    struct unoccluded_chunk c;
    for (size_t first = 0; first < count; first += UNOCCLUDED_LANES) {
        const size_t left = count - first;
        const size_t n = left < UNOCCLUDED_LANES ? left : UNOCCLUDED_LANES;
        unoccluded_load(light, first, n, point, normal, &c);
        const size_t far = unoccluded_sort(light, n, &c);
        if (far < n) unoccluded_near(light, &c);
        if (far > 0) unoccluded_far(light, &c);
        for (size_t i = 0; i < n; i++) {
            const float e = c.far[i] ? c.sum[i] * 4.0f * c.half[0] * c.half[1] : c.polygon[i];
            out[first + i] = c.front[i] > 0.0f && e > 0.0f ? e : 0.0f;
        }
    }
}
