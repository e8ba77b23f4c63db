#pragma once
/* Integrates over rectangles by Gauss rules, for many receivers at once. Where a receiver's horizon
 * crosses the light, only the part above it is integrated: across a horizon the cosine is no
 * polynomial, and a rule errs by a third where little of the light is left. Rows of points that the
 * horizon crosses are cut there; from row to row the integral is smooth. */
#include <stdbool.h>

#include "server/reconstruct/shadow/unoccluded_chunk_lanes.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/gaussian.h"

#define UNOCCLUDED_ORDER 12 /* points an axis, of rows that are cut */

static const float unoccluded_nodes_3[2][3] = {{-0.774596669f, 0.0f, 0.774596669f},
                                               {0.277777778f, 0.444444444f, 0.277777778f}};
static const float unoccluded_nodes_profile[2][4] = {
    {-0.802102150f, -0.282621223f, 0.282621223f, 0.802102150f},
    {0.0602718775f, 0.238800126f, 0.238800126f, 0.0602718775f}};
static const float unoccluded_nodes_12[2][12] = {
    {-0.981560634f, -0.904117256f, -0.769902674f, -0.587317954f, -0.367831499f, -0.125233409f,
     0.125233409f, 0.367831499f, 0.587317954f, 0.769902674f, 0.904117256f, 0.981560634f},
    {0.0235876682f, 0.053469663f, 0.0800391645f, 0.101583714f, 0.116746269f, 0.124573523f,
     0.124573523f, 0.116746269f, 0.101583714f, 0.0800391645f, 0.053469663f, 0.0235876682f}};

/* Returns weight cos cos' / d^2 of a point of the light, `up` above the receiver's horizon. */
static inline float unoccluded_point(const struct unoccluded_chunk *c, size_t i, float weight,
                                     float up, float squared)
{
    /* never nearer than the light's plane, whatever was cancelled */
    const float least = fused(c->front[i], c->front[i], UNOCCLUDED_TINY);
    const float inverse = 1.0f / (squared > least ? squared : least);
    return weight * (up > 0.0f ? up : 0.0f) * inverse * (c->front[i] * inverse);
}

/* Sums w_i w_j I cos cos' / d^2 over order x order points into c->sum; the weights alone, without
 * the profile, into c->share when `profiled`. */
static void unoccluded_quadrature(const float *nodes, const float *weights, int order,
                                  bool profiled, struct unoccluded_chunk *c)
{
    const float uu = c->half[0] * c->half[0], vv = c->half[1] * c->half[1];
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) c->sum[i] = c->share[i] = 0.0f;
    for (int k = 0; k < order * order; k++) {
        const float u = nodes[k % order], v = nodes[k / order];
        const float weight = weights[k % order] * weights[k / order];
        const float added = u * u * uu + v * v * vv;
        const float profile = profiled ? gaussian_exp_minus(2.0f * (u * u + v * v)) : 1.0f;
        for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
            const float up = fused(v, c->up_v[i], fused(u, c->up_u[i], c->up[i]));
            const float moved = fused(v, c->across_v[i], fused(u, c->across_u[i], c->squared[i]));
            const float g = unoccluded_point(c, i, weight, up, moved + added);
            c->sum[i] = fused(g, profile, c->sum[i]);
            c->share[i] += g;
        }
    }
}

/* Points by their way along rows, `in`, and from row to row, `out`: v and u, or the other way about
 * where the horizon rises more along u. */
struct unoccluded_rows {
    _Alignas(64) float up_in[UNOCCLUDED_LANES], up_out[UNOCCLUDED_LANES];
    float across_in[UNOCCLUDED_LANES], across_out[UNOCCLUDED_LANES];
    float square_in[UNOCCLUDED_LANES], square_out[UNOCCLUDED_LANES]; /* of half-sides */
    float middle[UNOCCLUDED_ORDER][UNOCCLUDED_LANES]; /* of the part of a row that is above */
    float half[UNOCCLUDED_ORDER][UNOCCLUDED_LANES];
};

/* Cuts rows of points at the horizon. Where all of the light is above it, the points are those of
 * unoccluded_quadrature, to the last bit, so that a receiver's result does not depend on those
 * beside it. */
static void unoccluded_cut_rows(const struct unoccluded_chunk *c, struct unoccluded_rows *r)
{
    const float uu = c->half[0] * c->half[0], vv = c->half[1] * c->half[1];
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
        const int32_t steep = fabsf(c->up_u[i]) > fabsf(c->up_v[i]);
        const int32_t turned = steep & !unoccluded_is_open(c, i);
        r->up_in[i] = turned ? c->up_u[i] : c->up_v[i];
        r->up_out[i] = turned ? c->up_v[i] : c->up_u[i];
        r->across_in[i] = turned ? c->across_u[i] : c->across_v[i];
        r->across_out[i] = turned ? c->across_v[i] : c->across_u[i];
        r->square_in[i] = turned ? uu : vv;
        r->square_out[i] = turned ? vv : uu;
    }
    for (int k = 0; k < UNOCCLUDED_ORDER; k++)
        for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
            const float base = fused(unoccluded_nodes_12[0][k], r->up_out[i], c->up[i]);
            float least = -base / fabsf(r->up_in[i]);
            least = least > -1.0f ? least : -1.0f;
            least = least < 1.0f ? least : 1.0f;
            r->middle[k][i] = copysignf(0.5f * (1.0f + least), r->up_in[i]);
            r->half[k][i] = 0.5f * (1.0f - least);
        }
}

/* Does unoccluded_quadrature with 12 x 12 points and with the profile, over the part above the
 * horizon. */
static void unoccluded_quadrature_above(struct unoccluded_chunk *c)
{
    struct unoccluded_rows r;
    unoccluded_cut_rows(c, &r);
    for (size_t i = 0; i < UNOCCLUDED_LANES; i++) c->sum[i] = c->share[i] = 0.0f;
    for (int k = 0; k < UNOCCLUDED_ORDER * UNOCCLUDED_ORDER; k++) {
        const int row = k % UNOCCLUDED_ORDER, point = k / UNOCCLUDED_ORDER;
        const float out = unoccluded_nodes_12[0][row], node = unoccluded_nodes_12[0][point];
        const float weight = unoccluded_nodes_12[1][row] * unoccluded_nodes_12[1][point];
        for (size_t i = 0; i < UNOCCLUDED_LANES; i++) {
            const float in = fused(r.half[row][i], node, r.middle[row][i]);
            const float up = fused(in, r.up_in[i], fused(out, r.up_out[i], c->up[i]));
            const float moved =
                fused(in, r.across_in[i], fused(out, r.across_out[i], c->squared[i]));
            const float added = out * out * r.square_out[i] + in * in * r.square_in[i];
            const float profile = gaussian_exp_minus(2.0f * (out * out + in * in));
            const float g = unoccluded_point(c, i, weight * r.half[row][i], up, moved + added);
            c->sum[i] = fused(g, profile, c->sum[i]);
            c->share[i] += g;
        }
    }
}
