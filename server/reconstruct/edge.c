#include "server/reconstruct/edge.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/strata.h"

/* Pixels at 9 samples; all shrink with m(N), as the noise that is averaged and the penumbra's own
 * width do. */
#define NARROW_PX 1.0f  /* filters this wide and narrower are replaced */
#define WIDE_PX   1.5f  /* from here on none is */
#define ALONG_PX  2.0f  /* sigma along an edge without any bend */
#define ACROSS_PX 0.35f /* least sigma across */
#define TENSOR_PX 2.2f  /* sigma of the structure tensor's window */

#define EXPONENT_MOST 3.0f /* 2.4 sigma */
#define RHO_LEAST     1e-3f
#define COVER_LEAST   0.05f
#define DELTA_MOST    2.0f
#define NODES         8 /* from the light's centre to its edge */
#define SIDE          (2 * EDGE_REACH_PX + 1)

struct edges {
    const struct receiver_light *light;
    const struct patch *patch;
    struct receivers *receivers;
    size_t width;   /* of the receivers' rect */
    uint8_t *known; /* pixels whose own estimate is in the sources */
    float scale;    /* m(N) mu */
};

/* What lies around a pixel, row by row. */
struct view {
    float seen[SIDE][SIDE];
    bool same[SIDE][SIDE]; /* shows the same surface */
};

/* Windows around a pixel: axes on the screen, and what follows on the light. */
struct window {
    float across[2];          /* unit, pixels */
    float falloff[2];         /* 1 / (2 sigma^2) across, along */
    float normal[2];          /* nu */
    float even[2][NODES + 1]; /* I / cov along each axis of the light, centre to edge */
};

static bool is_compatible(const struct shadow_source *p, const struct shadow_target *t,
                          const struct shadow_source *q)
{
    float off = 0.0f, squared = 0.0f, alike = 0.0f;
    for (int k = 0; k < 3; k++) {
        const float d = q->point[k] - p->point[k];
        off += d * p->normal[k];
        squared += d * d;
        alike += p->normal[k] * q->normal[k];
    }
    const float share = SHADOW_PLANE_SHARE * SHADOW_PLANE_SHARE;
    return alike >= SHADOW_COS_NORMALS && squared <= t->distance_most2 &&
           (fabsf(off) <= t->plane_least || off * off <= share * squared);
}

static void place(const struct edges *e, size_t pixel, int32_t *x, int32_t *y)
{
    *x = e->receivers->rect.x0 + (int32_t)(pixel % e->width);
    *y = e->receivers->rect.y0 + (int32_t)(pixel / e->width);
}

static float own_estimate(const struct edges *e, size_t pixel)
{
    struct shadow_source *s = &e->receivers->sources[pixel];
    if (!e->known[pixel]) {
        int32_t x, y;
        place(e, pixel, &x, &y);
        s->seen = strata_ratio(e->light, e->patch, x, y);
        e->known[pixel] = 1;
    }
    return s->seen;
}

static size_t neighbour(const struct edges *e, size_t pixel, int32_t x, int32_t y)
{
    return pixel + (size_t)((ptrdiff_t)y * (ptrdiff_t)e->width + x);
}

static void look_around(const struct edges *e, size_t pixel, struct view *v)
{
    const struct shadow_source *sources = e->receivers->sources;
    for (int32_t y = 0; y < SIDE; y++) {
        for (int32_t x = 0; x < SIDE; x++) {
            const size_t q = neighbour(e, pixel, x - EDGE_REACH_PX, y - EDGE_REACH_PX);
            const bool same =
                receiver_is_lit(&sources[q]) &&
                is_compatible(&sources[pixel], &e->receivers->targets[pixel], &sources[q]);
            v->same[y][x] = same;
            v->seen[y][x] = same ? own_estimate(e, q) : 0.0f;
        }
    }
}

/* The unit vector across the edge, and how sure that is: 0 in every direction alike .. 1. */
static float find_edge(const struct view *v, float falloff, float across[2])
{
    float xx = 0.0f, xy = 0.0f, yy = 0.0f;
    for (int y = 0; y + 1 < SIDE; y++) {
        for (int x = 0; x + 1 < SIDE; x++) {
            if (!(v->same[y][x] && v->same[y][x + 1] && v->same[y + 1][x] && v->same[y + 1][x + 1]))
                continue;
            const float a = v->seen[y + 1][x + 1] - v->seen[y][x];
            const float b = v->seen[y + 1][x] - v->seen[y][x + 1];
            const float cx = (float)(x - EDGE_REACH_PX) + 0.5f;
            const float cy = (float)(y - EDGE_REACH_PX) + 0.5f;
            const float weight = gaussian_exp_minus((cx * cx + cy * cy) * falloff);
            xx += weight * (a - b) * (a - b);
            xy += weight * (a - b) * (a + b);
            yy += weight * (a + b) * (a + b);
        }
    }
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
static void weigh_nodes(const struct edges *e, float shear, float sigma_px, float even[NODES + 1])
{
    const bool gaussian = e->light->rectangle.profile == PROFILE_GAUSSIAN;
    const float delta = 0.5f * shear, rho = shear * sigma_px;
    const float a = 1.0f + (delta < DELTA_MOST ? delta : DELTA_MOST);
    const float inverse = rho > RHO_LEAST ? 1.0f / rho : 0.0f;
    const float all = 2.0f * gaussian_phi(a * inverse) - 1.0f; /* a >= 1: 0 only if inverse is */
    for (int i = 0; i <= NODES; i++) {
        const float y = (float)i / NODES;
        const float stays =
            gaussian_phi((a - y) * inverse) + gaussian_phi((a + y) * inverse) - 1.0f;
        const float share = all > 1e-6f ? stays / all : 1.0f;
        even[i] = (gaussian ? gaussian_exp_minus(2.0f * y * y) : 1.0f) /
                  (share > COVER_LEAST ? share : COVER_LEAST);
    }
}

/* False where the edge on the light cannot be told. */
static bool make_window(const struct edges *e, size_t pixel, float sigma_px, float sure,
                        struct window *w)
{
    const struct shadow_source *s = &e->receivers->sources[pixel];
    const float least = ACROSS_PX * e->scale, across = sigma_px > least ? sigma_px : least;
    const float most = ALONG_PX * e->scale, longer = most > across ? most - across : 0.0f;
    const float along = across + sure * sure * longer;
    float steps[2][2];
    receiver_steps(e->light, s, steps);
    for (int i = 0; i < 2; i++)
        w->normal[i] = steps[i][0] * w->across[0] + steps[i][1] * w->across[1];
    const float length = sqrtf(w->normal[0] * w->normal[0] + w->normal[1] * w->normal[1]);
    if (!(length > 0.0f && length < INFINITY)) return false;
    for (int i = 0; i < 2; i++) {
        w->normal[i] /= length;
        /* shear along axis i by a pixel across, in half-sides */
        const float shear = s->eta * fabsf(w->normal[i]) / (length * e->light->rectangle.half[i]);
        weigh_nodes(e, shear, across, w->even[i]);
    }
    w->falloff[0] = 0.5f / (across * across);
    w->falloff[1] = 0.5f / (along * along);
    return true;
}

/* w_i of filters.md section 2 at y half-sides; 0 off the light. */
static float point_weight(const struct shadow_target *t, const struct window *w, int axis, float y)
{
    const float at = fabsf(y) * NODES;
    if (!(at <= NODES)) return 0.0f;
    const int node = (int)at < NODES ? (int)at : NODES - 1;
    const float *even = &w->even[axis][node], rest = at - (float)node;
    return (even[0] + (even[1] - even[0]) * rest) * (1.0f + t->gamma[axis] * y);
}

/* Adds a neighbour's strata, moved on to where pixel `to` has them. */
static void add_strata(const struct edges *e, size_t to, size_t from, const struct window *w,
                       float weight, float sums[2])
{
    const struct shadow_source *p = &e->receivers->sources[to], *q = &e->receivers->sources[from];
    const struct shadow_target *t = &e->receivers->targets[to];
    const struct rect rect = e->patch->rect;
    const uint32_t l = e->light->strata;
    uint32_t columns[SHADOW_STRATA_MAX];
    float jitter[2], rows[SHADOW_STRATA_MAX], shift[2];
    int32_t x, y;
    place(e, from, &x, &y);
    strata_jitters(e->light, &x, &y, 1, &jitter[0], &jitter[1]);
    strata_columns(e->light, e->patch,
                   (size_t)(y - rect.y0) * (size_t)rect_width(rect) + (size_t)(x - rect.x0),
                   columns);
    const float apart =
        t->distance * ((q->u[0] - p->u[0]) * w->normal[0] + (q->u[1] - p->u[1]) * w->normal[1]);
    for (int i = 0; i < 2; i++)
        shift[i] = p->eta * apart * w->normal[i] / e->light->rectangle.half[i];
    for (uint32_t b = 0; b < l; b++)
        rows[b] = point_weight(t, w, 1, 2.0f * pattern_axis(jitter[1], l, b) - 1.0f + shift[1]);
    for (uint32_t a = 0; a < l; a++) {
        const float at = 2.0f * pattern_axis(jitter[0], l, a) - 1.0f + shift[0];
        const float column = weight * point_weight(t, w, 0, at);
        for (uint32_t b = 0; b < l; b++) {
            const float whole = column * rows[b];
            sums[0] += columns[a] >> b & 1u ? whole : 0.0f;
            sums[1] += whole;
        }
    }
}

/* The seen fraction by a window along the edge; -1 where that says nothing. Neighbours count in
 * pairs opposite each other, so that what changes linearly cancels. */
static float filter_along(const struct edges *e, size_t pixel, const struct view *v,
                          const struct window *w)
{
    float sums[2] = {0};
    for (int32_t y = -EDGE_REACH_PX; y <= EDGE_REACH_PX; y++) {
        for (int32_t x = -EDGE_REACH_PX; x <= EDGE_REACH_PX; x++) {
            const bool *there = &v->same[EDGE_REACH_PX + y][EDGE_REACH_PX + x];
            if (!*there || !v->same[EDGE_REACH_PX - y][EDGE_REACH_PX - x]) continue;
            const float across = (float)x * w->across[0] + (float)y * w->across[1];
            const float along = (float)y * w->across[0] - (float)x * w->across[1];
            const float exponent = across * across * w->falloff[0] + along * along * w->falloff[1];
            if (exponent > EXPONENT_MOST) continue;
            add_strata(e, pixel, neighbour(e, pixel, x, y), w, gaussian_exp_minus(exponent), sums);
        }
    }
    return sums[1] > 0.0f ? sums[0] / sums[1] : -1.0f;
}

/* How much of the sheared filter's answer stays. */
static float kept_share(const struct edges *e, float sigma_px)
{
    const float s = (sigma_px / e->scale - NARROW_PX) / (WIDE_PX - NARROW_PX);
    const float within = s > 0.0f ? s < 1.0f ? s : 1.0f : 0.0f;
    return within * within * (3.0f - 2.0f * within);
}

/* The seen fraction of one pixel; -1 where no edge can be told. */
static float filter_one(const struct edges *e, size_t pixel, float sigma_px)
{
    struct view view;
    struct window window;
    const float tensor_px = TENSOR_PX * e->scale;
    look_around(e, pixel, &view);
    const float sure = find_edge(&view, 0.5f / (tensor_px * tensor_px), window.across);
    if (!(sure > 0.0f) || !make_window(e, pixel, sigma_px, sure, &window)) return -1.0f;
    return filter_along(e, pixel, &view, &window);
}

int edges_filter(const struct receiver_light *light, const struct patch *patch,
                 struct receivers *receivers, const uint32_t *pixels, uint32_t count,
                 struct edge_answer *out)
{
    const size_t area = (size_t)rect_area(receivers->rect);
    struct edges e = {.light = light,
                      .patch = patch,
                      .receivers = receivers,
                      .width = (size_t)rect_width(receivers->rect),
                      .scale = wedge_scale(light->plan, light->strata)};
    e.known = scratch_take(patch->scratch, area);
    if (!e.known) return ERR_MEMORY;
    memset(e.known, 0, area);
    for (uint32_t k = 0; k < count; k++) {
        const float sigma_px = wedge_width_px(&receivers->targets[pixels[k]]);
        out[k] = (struct edge_answer){-1.0f, 1.0f};
        if (sigma_px < WIDE_PX * e.scale) out[k].seen = filter_one(&e, pixels[k], sigma_px);
        if (out[k].seen >= 0.0f) out[k].kept = kept_share(&e, sigma_px);
    }
    scratch_give(patch->scratch, e.known);
    return 0;
}

float edge_join(const struct edge_answer *edge, float sheared)
{
    if (edge->seen < 0.0f) return sheared;
    if (sheared < 0.0f) return edge->seen;
    return edge->seen + edge->kept * (sheared - edge->seen); /* exact where both agree */
}
