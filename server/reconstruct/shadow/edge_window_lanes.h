#pragma once
/* Finds the windows along edges of adjacent pixels. */
#include <math.h>

#include "proto/plan.h"
#include "server/reconstruct/shadow/compatible_lanes.h"
#include "server/reconstruct/shadow/edge.h"
#include "server/reconstruct/shadow/receiver_lanes.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/gaussian.h"

/* Pixels at 9 samples. All shrink with m(N), as the noise and the penumbra's own width do. */
#define EDGE_ALONG_PX  2.0f  /* sigma along an edge without any bend */
#define EDGE_ACROSS_PX 0.35f /* least sigma across */
#define EDGE_TENSOR_PX 2.2f  /* sigma of the structure tensor's window */

#define EDGE_NODES 8 /* from the light's centre to its edge */
#define EDGE_AROUND                                                                                \
    (EDGE_SIDE * SIMD_LANES) /* pixels of a view, each row padded to whole lanes                   \
                              */

/* Numbers that all pixels share. */
struct edge_fixed {
    _Alignas(64) float tensor[EDGE_AROUND]; /* weights of the structure tensor; 0 past the end */
    float profile[SIMD_LANES];              /* I at the nodes but the last, twice */
    float x[EDGE_AROUND], y[EDGE_AROUND];
    int32_t inside[EDGE_AROUND];
    int32_t to[EDGE_AROUND]; /* from the pixel */
    float last_profile;
    struct receiver_stepper stepper[2];
};

/* Which pixels around one show the same surface, and how much of the light these see. Zeros before
 * and after serve reads of pixels opposite each other, and those after also reads of pixels beside
 * them. */
struct edge_view {
    _Alignas(64) int32_t padded[SIMD_LANES + EDGE_AROUND + SIMD_LANES + 1];
    _Alignas(64) float seen[EDGE_AROUND + SIMD_LANES + 1];
};

static inline const int32_t *edge_same(const struct edge_view *view)
{
    return view->padded + SIMD_LANES;
}

/* Windows of adjacent pixels, and what they come from. */
struct edge_windows {
    _Alignas(64) float tensor[3][SIMD_LANES]; /* xx, xy, yy */
    float point[3][SIMD_LANES], surface[3][SIMD_LANES], eta[SIMD_LANES];
    float sigma_px[SIMD_LANES];
    int32_t told[SIMD_LANES];                           /* whether an edge was found */
    float across[2][SIMD_LANES];                        /* unit, pixels */
    float falloff[2][SIMD_LANES];                       /* 1 / (2 sigma^2) across, along */
    float normal[2][SIMD_LANES];                        /* nu */
    float reach[2][SIMD_LANES], inverse[2][SIMD_LANES]; /* struct coverage_shear, by axes */
    float all[2][SIMD_LANES], rest[2][SIMD_LANES];
    float last[2][SIMD_LANES]; /* I / cov at the last node */
};

static inline void edge_fix(const struct edge_field *f, struct edge_fixed *out)
{
    const bool gaussian = f->light->rectangle.profile == PROFILE_GAUSSIAN;
    const float tensor_px = EDGE_TENSOR_PX * f->scale, falloff = 0.5f / (tensor_px * tensor_px);
    for (int i = 0; i < EDGE_AROUND; i++) {
        const int32_t x = i % SIMD_LANES - EDGE_REACH_PX, y = i / SIMD_LANES - EDGE_REACH_PX;
        const float cx = (float)x + 0.5f, cy = (float)y + 0.5f;
        const bool pairs = x < EDGE_REACH_PX && y < EDGE_REACH_PX;
        out->x[i] = (float)x;
        out->y[i] = (float)y;
        out->inside[i] = x <= EDGE_REACH_PX;
        out->to[i] = y * f->width + x;
        out->tensor[i] = pairs ? gaussian_exp_minus((cx * cx + cy * cy) * falloff) : 0.0f;
    }
    for (int i = 0; i < SIMD_LANES; i++) {
        const float y = (float)(i % EDGE_NODES) / EDGE_NODES;
        out->profile[i] = gaussian ? gaussian_exp_minus(2.0f * y * y) : 1.0f;
    }
    out->last_profile = gaussian ? gaussian_exp_minus(2.0f) : 1.0f;
    for (int i = 0; i < 2; i++) out->stepper[i] = receiver_stepper_of(f->light, i);
}

/* Fills the view of one pixel. */
static inline void edge_look(const struct edge_field *f, const struct edge_fixed *fixed,
                             size_t pixel, struct edge_view *v)
{
    const struct shadow_pixels *p = f->pixels;
    const struct compatible_receiver receiver = compatible_receiver_of(p, pixel);
    for (int row = 0; row < EDGE_AROUND; row += SIMD_LANES) {
        const size_t q = (size_t)((ptrdiff_t)pixel + fixed->to[row]);
        const float *x = p->point[0] + q, *y = p->point[1] + q, *z = p->point[2] + q;
        const float *nx = p->normal[0] + q, *ny = p->normal[1] + q, *nz = p->normal[2] + q;
        const float *own = f->seen + q;
        for (int i = 0; i < SIMD_LANES; i++) {
            const float value = own[i];
            float squared;
            const int32_t same =
                compatible_point(&receiver, x[i], y[i], z[i], nx[i], ny[i], nz[i], &squared) &
                fixed->inside[row + i];
            v->padded[SIMD_LANES + row + i] = same;
            v->seen[row + i] = same ? value : 0.0f;
        }
    }
}

/* Computes the structure tensor over four pixels that touch: xx, xy, yy. */
static inline void edge_tensor(const struct edge_fixed *fixed, const struct edge_view *v,
                               float out[3])
{
    _Alignas(64) float xx[SIMD_LANES] = {0}, xy[SIMD_LANES] = {0}, yy[SIMD_LANES] = {0};
    for (int row = 0; row + SIMD_LANES < EDGE_AROUND; row += SIMD_LANES) {
        const float *above = v->seen + row, *below = above + SIMD_LANES;
        const int32_t *same = edge_same(v) + row, *same_below = same + SIMD_LANES;
        for (int i = 0; i < SIMD_LANES; i++) {
            const int32_t all = same[i] & same[i + 1] & same_below[i] & same_below[i + 1];
            const float a = below[i + 1] - above[i], b = below[i] - above[i + 1];
            const float tensor = fixed->tensor[row + i], weight = all ? tensor : 0.0f;
            const float x = a - b, y = a + b, own = weight * x;
            xx[i] = fused(own, x, xx[i]);
            xy[i] = fused(own, y, xy[i]);
            yy[i] = fused(weight * y, y, yy[i]);
        }
    }
    out[0] = simd_sum(xx);
    out[1] = simd_sum(xy);
    out[2] = simd_sum(yy);
}

static inline void edge_ask(const struct edge_field *f, const struct edge_fixed *fixed,
                            size_t pixel, float sigma_px, uint32_t lane,
                            const struct edge_view *view, struct edge_windows *w)
{
    const struct shadow_pixels *p = f->pixels;
    float tensor[3];
    edge_tensor(fixed, view, tensor);
    for (int k = 0; k < 3; k++) {
        w->tensor[k][lane] = tensor[k];
        w->point[k][lane] = p->point[k][pixel];
        w->surface[k][lane] = p->normal[k][pixel];
    }
    w->eta[lane] = p->eta[pixel];
    w->sigma_px[lane] = sigma_px;
}

/* Finds the unit vectors across edges, and widths by the certainty of these, from 0 (every
 * direction alike) to 1. */
static inline void edge_turn(const struct edge_field *f, struct edge_windows *w)
{
    const float least = EDGE_ACROSS_PX * f->scale, most = EDGE_ALONG_PX * f->scale;
    for (int i = 0; i < SIMD_LANES; i++) {
        const float xx = w->tensor[0][i], xy = w->tensor[1][i], yy = w->tensor[2][i];
        /* The tensor's larger eigenvector has half of the doubled angle. */
        const float half = 0.5f * (xx - yy), root = sqrtf(half * half + xy * xy);
        const float twice = half / (root > 0.0f ? root : 1.0f); /* in [-1, 1] but for rounding */
        const float y = sqrtf(twice < 1.0f ? 0.5f - 0.5f * twice : 0.0f);
        const float sure = 2.0f * root / (root > 0.0f ? xx + yy : 1.0f);
        const float sigma_px = w->sigma_px[i], across = sigma_px > least ? sigma_px : least;
        const float longer = most > across ? most - across : 0.0f;
        const float along = across + sure * sure * longer;
        w->told[i] = sure > 0.0f;
        w->across[0][i] = sqrtf(twice > -1.0f ? 0.5f + 0.5f * twice : 0.0f);
        w->across[1][i] = xy < 0.0f ? -y : y;
        w->sigma_px[i] = across;
        w->falloff[0][i] = 0.5f / (across * across);
        w->falloff[1][i] = 0.5f / (along * along);
    }
}

/* Finds the edges' normals on the light. */
static inline void edge_face(const struct edge_fixed *fixed, struct edge_windows *w)
{
    const struct receiver_stepper u = fixed->stepper[0], v = fixed->stepper[1];
    for (int i = 0; i < SIMD_LANES; i++) {
        const float nx = w->surface[0][i], ny = w->surface[1][i], nz = w->surface[2][i];
        const struct receiver_aim aim =
            receiver_aim(&u, w->point[0][i], w->point[1][i], w->point[2][i], nx, ny, nz);
        float u_x, u_y, v_x, v_y;
        receiver_step(&u, &aim, nx, ny, nz, &u_x, &u_y);
        receiver_step(&v, &aim, nx, ny, nz, &v_x, &v_y);
        w->normal[0][i] = u_x * w->across[0][i] + u_y * w->across[1][i];
        w->normal[1][i] = v_x * w->across[0][i] + v_y * w->across[1][i];
    }
}

/* Computes the shear along an axis of the light for a pixel across the edge, in half-sides, for
 * coverage. */
static inline void edge_shear(const struct edge_field *f, const struct edge_fixed *fixed,
                              const float length[SIMD_LANES], int axis, struct edge_windows *w)
{
    const float half = f->light->rectangle.half[axis], last = fixed->last_profile;
    for (int i = 0; i < SIMD_LANES; i++) {
        const float normal = w->normal[axis][i] / length[i];
        const float shear = w->eta[i] * fabsf(normal) / (length[i] * half), delta = 0.5f * shear;
        const struct coverage_shear s = coverage_shear_of(
            shear * w->sigma_px[i], delta < COVERAGE_DELTA_MAX ? delta : COVERAGE_DELTA_MAX);
        w->normal[axis][i] = normal;
        w->reach[axis][i] = s.reach;
        w->inverse[axis][i] = s.inverse;
        w->all[axis][i] = s.all;
        w->rest[axis][i] = s.rest;
        w->last[axis][i] = last / coverage_at(&s, 1.0f);
    }
}

/* Makes the windows. */
static inline void edge_make_windows(const struct edge_field *f, const struct edge_fixed *fixed,
                                     struct edge_windows *w)
{
    _Alignas(64) float length[SIMD_LANES];
    edge_turn(f, w);
    edge_face(fixed, w);
    for (int i = 0; i < SIMD_LANES; i++) {
        const float n0 = w->normal[0][i], n1 = w->normal[1][i];
        length[i] = sqrtf(n0 * n0 + n1 * n1);
        w->told[i] &= (length[i] > 0.0f) & (length[i] < INFINITY);
    }
    for (int axis = 0; axis < 2; axis++) edge_shear(f, fixed, length, axis, w);
}
