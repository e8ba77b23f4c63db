#pragma once
/* shadow_kernels' filter_edges. */
#include <math.h>
#include <string.h>

#include "proto/pattern.h"
#include "proto/plan.h"
#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/edge.h"
#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/receiver_lanes.h"

/* Pixels at 9 samples; all shrink with m(N), as the noise that is averaged and the penumbra's own
 * width do. */
#define EDGE_ALONG_PX  2.0f  /* sigma along an edge without any bend */
#define EDGE_ACROSS_PX 0.35f /* least sigma across */
#define EDGE_TENSOR_PX 2.2f  /* sigma of the structure tensor's window */

#define EDGE_EXPONENT_MOST 3.0f /* 2.4 sigma */
#define EDGE_NODES         8    /* from the light's centre to its edge */
#define EDGE_LANES         32   /* neighbours at once: many windows have no more */
#define EDGE_AROUND        (EDGE_SIDE * SHADOW_LANES) /* a view: each row filled up to whole lanes */

/* The same for all pixels. */
struct edge_fixed {
    float tensor[EDGE_AROUND];   /* weights of the structure tensor; 0 past the end */
    float profile[SHADOW_LANES]; /* I at the nodes */
    float x[EDGE_AROUND], y[EDGE_AROUND];
    int32_t inside[EDGE_AROUND];
    ptrdiff_t to[EDGE_AROUND]; /* from the pixel */
    struct receiver_stepper stepper[2];
};

/* What lies around a pixel. */
struct edge_view {
    float seen[EDGE_AROUND + SHADOW_LANES + 1];
    int32_t same[EDGE_AROUND + SHADOW_LANES + 1]; /* shows the same surface */
};

/* Windows around a pixel: axes on the screen, and what follows on the light. */
struct edge_window {
    float across[2];  /* unit, pixels */
    float falloff[2]; /* 1 / (2 sigma^2) across, along */
    float normal[2];  /* nu */
    /* I / cov along each axis of the light: at the nodes but the last, and from there to the next.
     */
    float even[2][EDGE_NODES], rise[2][EDGE_NODES];
};

/* Neighbours that count, side by side. */
struct edge_chunk {
    int32_t at[EDGE_LANES];
    uint32_t bits[EDGE_LANES];
    float exponent[EDGE_LANES], u[2][EDGE_LANES], jitter[2][EDGE_LANES];
    float column[SHADOW_STRATA_MAX][EDGE_LANES], row[EDGE_LANES];
    float shift[2][EDGE_LANES];
};

static inline void edge_fix(const struct edge_field *f, struct edge_fixed *out)
{
    const bool gaussian = f->light->rectangle.profile == PROFILE_GAUSSIAN;
    const float tensor_px = EDGE_TENSOR_PX * f->scale, falloff = 0.5f / (tensor_px * tensor_px);
    for (int i = 0; i < EDGE_AROUND; i++) {
        const int32_t x = i % SHADOW_LANES - EDGE_REACH_PX, y = i / SHADOW_LANES - EDGE_REACH_PX;
        const float cx = (float)x + 0.5f, cy = (float)y + 0.5f;
        const bool pairs = x < EDGE_REACH_PX && y < EDGE_REACH_PX;
        out->x[i] = (float)x;
        out->y[i] = (float)y;
        out->inside[i] = x <= EDGE_REACH_PX;
        out->to[i] = (ptrdiff_t)y * f->width + x;
        out->tensor[i] = pairs ? gaussian_exp_minus((cx * cx + cy * cy) * falloff) : 0.0f;
    }
    for (int i = 0; i < SHADOW_LANES; i++) {
        const float y = (float)i / EDGE_NODES;
        out->profile[i] = gaussian ? gaussian_exp_minus(2.0f * y * y) : 1.0f;
    }
    for (int i = 0; i < 2; i++) out->stepper[i] = receiver_stepper_of(f->light, i);
}

static inline void edge_look(const struct edge_field *f, const struct edge_fixed *fixed,
                             size_t pixel, struct edge_view *v)
{
    const struct asker asker = asker_of(&f->sources[pixel], &f->targets[pixel]);
    for (int row = 0; row < EDGE_AROUND; row += SHADOW_LANES) {
        const size_t q = (size_t)((ptrdiff_t)pixel + fixed->to[row]);
        const float *x = f->point[0] + q, *y = f->point[1] + q, *z = f->point[2] + q;
        const float *nx = f->normal[0] + q, *ny = f->normal[1] + q, *nz = f->normal[2] + q;
        const float *seen = f->seen + q;
        for (int i = 0; i < SHADOW_LANES; i++) {
            const float value = seen[i];
            float squared;
            const int32_t same =
                compatible_point(&asker, x[i], y[i], z[i], nx[i], ny[i], nz[i], &squared) &
                fixed->inside[row + i];
            v->same[row + i] = same;
            v->seen[row + i] = same ? value : 0.0f;
        }
    }
}

/* The structure tensor over four pixels that touch: xx, xy, yy. */
static inline void edge_tensor(const struct edge_fixed *fixed, const struct edge_view *v,
                               float out[3])
{
    float xx[SHADOW_LANES] = {0}, xy[SHADOW_LANES] = {0}, yy[SHADOW_LANES] = {0};
    for (int row = 0; row + SHADOW_LANES < EDGE_AROUND; row += SHADOW_LANES) {
        const float *seen = v->seen + row, *below = seen + SHADOW_LANES;
        const int32_t *same = v->same + row, *same_below = same + SHADOW_LANES;
        for (int i = 0; i < SHADOW_LANES; i++) {
            const int32_t all = same[i] & same[i + 1] & same_below[i] & same_below[i + 1];
            const float a = below[i + 1] - seen[i], b = below[i] - seen[i + 1];
            const float tensor = fixed->tensor[row + i], weight = all ? tensor : 0.0f;
            xx[i] += weight * (a - b) * (a - b);
            xy[i] += weight * (a - b) * (a + b);
            yy[i] += weight * (a + b) * (a + b);
        }
    }
    out[0] = lanes_total(xx);
    out[1] = lanes_total(xy);
    out[2] = lanes_total(yy);
}

/* The unit vector across the edge, and how sure that is: 0 in every direction alike .. 1. */
static inline float edge_find(const struct edge_fixed *fixed, const struct edge_view *v,
                              float across[2])
{
    float tensor[3];
    edge_tensor(fixed, v, tensor);
    const float xx = tensor[0], xy = tensor[1], yy = tensor[2];
    /* The tensor's larger eigenvector, by half of twice its angle. */
    const float half = 0.5f * (xx - yy), root = sqrtf(half * half + xy * xy);
    if (!(root > 0.0f)) return 0.0f;
    const float twice = half / root; /* within [-1, 1] but for rounding */
    across[0] = sqrtf(twice > -1.0f ? 0.5f + 0.5f * twice : 0.0f);
    across[1] = sqrtf(twice < 1.0f ? 0.5f - 0.5f * twice : 0.0f);
    if (xy < 0.0f) across[1] = -across[1];
    return 2.0f * root / (xx + yy);
}

/* I / cov of filters.md section 2 at the nodes of one axis, on which neighbours are moved by
 * `shear` half-sides a pixel across the edge. */
static inline void edge_weigh_nodes(const struct edge_fixed *fixed, float shear, float sigma_px,
                                    float even[EDGE_NODES], float rise[EDGE_NODES])
{
    const float delta = 0.5f * shear;
    const struct coverage_shear s = coverage_shear_of(
        shear * sigma_px, delta < COVERAGE_DELTA_MOST ? delta : COVERAGE_DELTA_MOST);
    float at[SHADOW_LANES];
    for (int i = 0; i < SHADOW_LANES; i++)
        at[i] = fixed->profile[i] / coverage_at(&s, (float)i / EDGE_NODES);
    for (int i = 0; i < EDGE_NODES; i++) {
        even[i] = at[i];
        rise[i] = at[i + 1] - at[i];
    }
}

/* False where the edge on the light cannot be told. */
static inline bool edge_make_window(const struct edge_field *f, const struct edge_fixed *fixed,
                                    size_t pixel, float sigma_px, float sure, struct edge_window *w)
{
    const struct shadow_source *s = &f->sources[pixel];
    const float *half = f->light->rectangle.half, *p = s->point, *n = s->normal;
    const float least = EDGE_ACROSS_PX * f->scale, across = sigma_px > least ? sigma_px : least;
    const float most = EDGE_ALONG_PX * f->scale, longer = most > across ? most - across : 0.0f;
    const float along = across + sure * sure * longer;
    for (int i = 0; i < 2; i++) {
        float x, y;
        receiver_step(&fixed->stepper[i], p[0], p[1], p[2], n[0], n[1], n[2], &x, &y);
        w->normal[i] = x * w->across[0] + y * w->across[1];
    }
    const float length = sqrtf(w->normal[0] * w->normal[0] + w->normal[1] * w->normal[1]);
    if (!(length > 0.0f && length < INFINITY)) return false;
    for (int i = 0; i < 2; i++) {
        w->normal[i] /= length;
        /* shear along axis i by a pixel across, in half-sides */
        const float shear = s->eta * fabsf(w->normal[i]) / (length * half[i]);
        edge_weigh_nodes(fixed, shear, across, w->even[i], w->rise[i]);
    }
    w->falloff[0] = 0.5f / (across * across);
    w->falloff[1] = 0.5f / (along * along);
    return true;
}

/* Numbers of the neighbours in the window, in order, into `kept`; exponents of all. They count in
 * pairs opposite each other, so that what changes linearly cancels. */
static inline size_t edge_choose(const struct edge_fixed *fixed, const struct edge_view *v,
                                 const struct edge_window *w, float *exponents, int32_t *kept)
{
    _Alignas(64) int32_t near[EDGE_AROUND];
    const float ax = w->across[0], ay = w->across[1];
    size_t count = 0;
    for (int i = 0; i < EDGE_AROUND; i++) {
        const float across = fixed->x[i] * ax + fixed->y[i] * ay;
        const float along = fixed->y[i] * ax - fixed->x[i] * ay;
        exponents[i] = across * across * w->falloff[0] + along * along * w->falloff[1];
        near[i] = v->same[i] & (exponents[i] <= EDGE_EXPONENT_MOST);
    }
    const size_t all = lanes_kept(near, EDGE_AROUND, kept);
    for (size_t k = 0; k < all; k++) {
        const int32_t opposite = (EDGE_SIDE - 1) * (SHADOW_LANES + 1) - kept[k];
        kept[count] = kept[k];
        count += v->same[opposite] ? 1 : 0;
    }
    return count;
}

/* Lanes past the end stand at the pixel itself and weigh nothing. */
static inline void edge_load(const struct edge_field *f, const struct edge_fixed *fixed,
                             size_t pixel, const float *exponents, const int32_t *kept,
                             size_t count, struct edge_chunk *c)
{
    for (size_t i = 0; i < EDGE_LANES; i++) {
        const size_t q = i < count ? (size_t)((ptrdiff_t)pixel + fixed->to[kept[i]]) : pixel;
        c->at[i] = (int32_t)q;
        c->exponent[i] = i < count ? exponents[kept[i]] : INFINITY;
        for (int k = 0; k < 2; k++) {
            c->u[k][i] = f->sources[q].u[k];
            c->jitter[k][i] = f->jitter[k][q];
        }
    }
}

/* `factor` times w_i of filters.md section 2 at the k-th of l strata; 0 off the light. */
static inline void edge_weigh(const struct edge_window *w, int axis, float gamma, uint32_t l,
                              uint32_t k, const struct edge_chunk *c, float out[EDGE_LANES])
{
    int32_t node[EDGE_LANES], inside[EDGE_LANES];
    float y[EDGE_LANES], rest[EDGE_LANES], even[EDGE_LANES], rise[EDGE_LANES];
    for (int i = 0; i < EDGE_LANES; i++) {
        y[i] = 2.0f * pattern_axis(c->jitter[axis][i], l, k) - 1.0f + c->shift[axis][i];
        const float at = fabsf(y[i]) * EDGE_NODES;
        inside[i] = at <= EDGE_NODES;
        const int32_t below = (int32_t)(inside[i] ? at : 0.0f);
        node[i] = below < EDGE_NODES ? below : EDGE_NODES - 1;
        rest[i] = at - (float)node[i];
    }
    lanes_look_up(w->even[axis], node, EDGE_LANES, even);
    lanes_look_up(w->rise[axis], node, EDGE_LANES, rise);
    for (int i = 0; i < EDGE_LANES; i++) {
        const float weight = (even[i] + rise[i] * rest[i]) * (1.0f + gamma * y[i]);
        out[i] = inside[i] ? weight : 0.0f;
    }
}

/* Adds the strata of a chunk, moved on to where the pixel has them: seen ones, all. */
static inline void edge_add(const struct edge_field *f, size_t pixel, const struct edge_window *w,
                            struct edge_chunk *c, float seen[EDGE_LANES], float all[EDGE_LANES])
{
    const struct shadow_source *p = &f->sources[pixel];
    const struct shadow_target *t = &f->targets[pixel];
    const float *half = f->light->rectangle.half;
    const uint32_t l = f->light->strata;
    const float distance = t->distance, pu = p->u[0], pv = p->u[1];
    const float n0 = w->normal[0], n1 = w->normal[1];
    const float move0 = p->eta * n0 / half[0], move1 = p->eta * n1 / half[1];
    float weight[EDGE_LANES];
    for (int i = 0; i < EDGE_LANES; i++) {
        const float apart = distance * ((c->u[0][i] - pu) * n0 + (c->u[1][i] - pv) * n1);
        c->shift[0][i] = move0 * apart;
        c->shift[1][i] = move1 * apart;
        weight[i] = gaussian_exp_minus(c->exponent[i]);
    }
    for (uint32_t a = 0; a < l; a++) {
        edge_weigh(w, 0, t->gamma[0], l, a, c, c->column[a]);
        for (int i = 0; i < EDGE_LANES; i++) c->column[a][i] *= weight[i];
    }
    for (uint32_t k = 0; k < l * l; k++) {
        const float *column = c->column[k % l];
        const uint32_t *word = f->bits + k / 32 * f->stride, bit = k % 32;
        if (k % l == 0) edge_weigh(w, 1, t->gamma[1], l, k / l, c, c->row);
        for (int i = 0; bit == 0 && i < EDGE_LANES; i++) c->bits[i] = word[c->at[i]];
        for (int i = 0; i < EDGE_LANES; i++) {
            const float whole = column[i] * c->row[i];
            seen[i] += c->bits[i] >> bit & 1u ? whole : 0.0f;
            all[i] += whole;
        }
    }
}

static inline float edge_filter_one(const struct edge_field *f, const struct edge_fixed *fixed,
                                    size_t pixel, float sigma_px, struct edge_view *view)
{
    struct edge_window window;
    struct edge_chunk chunk;
    float exponents[EDGE_AROUND], seen[EDGE_LANES] = {0}, all[EDGE_LANES] = {0};
    int32_t kept[EDGE_AROUND];
    edge_look(f, fixed, pixel, view);
    const float sure = edge_find(fixed, view, window.across);
    if (!(sure > 0.0f) || !edge_make_window(f, fixed, pixel, sigma_px, sure, &window)) return -1.0f;
    const size_t count = edge_choose(fixed, view, &window, exponents, kept);
    for (size_t first = 0; first < count; first += EDGE_LANES) {
        const size_t left = count - first, n = left < EDGE_LANES ? left : EDGE_LANES;
        edge_load(f, fixed, pixel, exponents, kept + first, n, &chunk);
        edge_add(f, pixel, &window, &chunk, seen, all);
    }
    for (int i = 0; i < SHADOW_LANES; i++) { /* EDGE_LANES are twice as many */
        seen[i] += seen[i + SHADOW_LANES];
        all[i] += all[i + SHADOW_LANES];
    }
    const float whole = lanes_total(all), share = lanes_total(seen);
    return whole > 0.0f ? share / whole : -1.0f;
}

static void kernel_filter_edges(const struct edge_field *f, const uint32_t *pixels,
                                const float *sigma_px, uint32_t count, float *out)
{
    struct edge_fixed fixed;
    struct edge_view view = {0};
    edge_fix(f, &fixed);
    for (uint32_t k = 0; k < count; k++)
        out[k] = edge_filter_one(f, &fixed, pixels[k], sigma_px[k], &view);
}
