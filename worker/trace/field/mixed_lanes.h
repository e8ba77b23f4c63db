#pragma once
/* field_kernels' place_cells, compare_cells, mark_colours and split_subs. */
#include <float.h>

#include "proto/octahedron.h"
#include "worker/trace/field/mixed.h"

/* Neighbours that face apart by more, 20 degrees, show two surfaces, however near they are. */
#define MIXED_COSINE SURFACE_COS_NONE

/* Where samples of a pixel differ by more, as squares over the larger one, there is an edge in its
 * texture. As roots, which is how bright they look, they then differ by a twentieth of white. */
#define MIXED_CONTRAST 0.01f

static void kernel_place_cells(const struct surface_view *view, int32_t x, int32_t y, size_t count,
                               const float *restrict depth, const uint32_t *restrict normal,
                               const uint32_t *restrict id, const struct mixed_cells *cells,
                               size_t first)
{
    const struct surface_view v = *view;
    const struct plan_camera c = *v.camera;
    float *restrict px = cells->point[0] + first, *restrict py = cells->point[1] + first;
    float *restrict pz = cells->point[2] + first, *restrict nx = cells->normal[0] + first;
    float *restrict ny = cells->normal[1] + first, *restrict nz = cells->normal[2] + first;
    float *restrict distance = cells->distance + first;
    uint32_t *restrict ids = cells->id + first;
    const float b = v.b_start + v.b_step * ((float)y + 0.5f);
    for (size_t i = 0; i < count; i++) {
        float n[3];
        const float a = v.a_start + v.a_step * ((float)(x + (int32_t)i) + 0.5f);
        const float d = surface_distance(depth[i]), root = sqrtf(1.0f + a * a + b * b);
        const float along = v.orthographic ? d : d / root, across = v.orthographic ? 1.0f : along;
        octahedron_unpack((int16_t)(normal[i] & 0xffffu), (int16_t)(normal[i] >> 16), 32767.0f, n);
        px[i] = a * across;
        py[i] = b * across;
        pz[i] = along;
        nx[i] = n[0] * c.right[0] + n[1] * c.right[1] + n[2] * c.right[2];
        ny[i] = n[0] * c.up[0] + n[1] * c.up[1] + n[2] * c.up[2];
        nz[i] = n[0] * c.forward[0] + n[1] * c.forward[1] + n[2] * c.forward[2];
        distance[i] = d;
        ids[i] = surface_sub_id(id[i]) & (d > 0.0f ? UINT32_MAX : 0u);
    }
}

static void kernel_mark_colours(const uint16_t *restrict a, const uint16_t *restrict b,
                                size_t count, uint8_t *restrict mixed)
{
    for (size_t i = 0; i < count; i++) {
        const float x = (float)(int32_t)a[i] * (1.0f / 65535.0f);
        const float y = (float)(int32_t)b[i] * (1.0f / 65535.0f), d = x - y;
        mixed[i] |= (uint8_t)(d * d > MIXED_CONTRAST * (x > y ? x : y));
    }
}

/* Returns how far apart two points may be along a normal, as in surface_match.h. */
static inline float mixed_allowed(const struct surface_view *v, float a, float b, float squared,
                                  float cosine)
{
    const float rest = 1.0f - cosine * cosine, sine = sqrtf(rest > 0.0f ? rest : 0.0f);
    return surface_pixel_size(v, a > b ? a : b) * SURFACE_PLANE_PX +
           sqrtf(squared) * (sine + SURFACE_SLACK);
}

static void kernel_compare_cells(const struct surface_view *view, const struct mixed_cells *cells,
                                 size_t first, size_t offset, size_t count, uint8_t *restrict apart)
{
    const struct surface_view v = *view;
    const float *restrict x = cells->point[0], *restrict y = cells->point[1];
    const float *restrict z = cells->point[2], *restrict nx = cells->normal[0];
    const float *restrict ny = cells->normal[1], *restrict nz = cells->normal[2];
    const float *restrict distance = cells->distance;
    const uint32_t *restrict id = cells->id;
    for (size_t i = first; i < first + count; i++) {
        const size_t j = i + offset;
        const float cosine = nx[i] * nx[j] + ny[i] * ny[j] + nz[i] * nz[j];
        const float dx = x[j] - x[i], dy = y[j] - y[i], dz = z[j] - z[i];
        const float off = fabsf(dx * nx[i] + dy * ny[i] + dz * nz[i]);
        const float allowed =
            mixed_allowed(&v, distance[i], distance[j], dx * dx + dy * dy + dz * dz, cosine);
        const int here = distance[i] > 0.0f, there = distance[j] > 0.0f;
        const int alike = (id[i] == id[j]) & (cosine >= MIXED_COSINE) & (off <= allowed);
        const int outside = (distance[i] < 0.0f) | (distance[j] < 0.0f);
        apart[i] = (uint8_t)((outside == 0) & ((here != there) | (here & there & (alike == 0))));
    }
}

/* Does surface_match for lane i and a pixel. */
static inline float mixed_match(const struct surface_view *v, const struct mixed_subs *s, int i,
                                const struct shown_surface *pixel)
{
    const float *n = pixel->normal;
    const float cosine = s->normal.x[i] * n[0] + s->normal.y[i] * n[1] + s->normal.z[i] * n[2];
    const float x = s->point.x[i] - pixel->point[0], y = s->point.y[i] - pixel->point[1];
    const float z = s->point.z[i] - pixel->point[2];
    const float off = fabsf(x * n[0] + y * n[1] + z * n[2]);
    const float allowed =
        mixed_allowed(v, s->distance[i], pixel->distance, x * x + y * y + z * z, cosine);
    const float id = s->id[i] == pixel->id ? 1.0f : SURFACE_OTHER_ID;
    const float turn = (cosine - SURFACE_COS_NONE) / (SURFACE_COS_FULL - SURFACE_COS_NONE);
    /* Distances are above 0, and so is `allowed` unless it underflows. */
    const float near =
        (SURFACE_FADE - off / (allowed > 0.0f ? allowed : FLT_MIN)) / (SURFACE_FADE - 1.0f);
    const float facing = turn < 1.0f ? turn : 1.0f, level = near < 1.0f ? near : 1.0f;
    return (facing > 0.0f) & (level > 0.0f) ? id * facing * level : 0.0f;
}

static inline float mixed_tent(float at, float step)
{
    const float t = 1.5f - fabsf(at - step);
    return t > 0.05f ? t : 0.05f;
}

static void weigh_lender(const struct surface_view *view, const struct mixed_subs *restrict s,
                         const struct shown_surface *pixel, uint32_t slot,
                         struct mixed_shares *restrict out)
{
    const struct surface_view v = *view;
    const float dx = (float)(slot % 3) - 0.5f, dy = (float)(slot / 3) - 0.5f;
    const float x = (float)s->x_px, y = (float)s->y_px;
    for (int i = 0; i < LANES; i++) {
        const float tent = mixed_tent(s->px[i] - x, dx) * mixed_tent(s->py[i] - y, dy) * 0.125f;
        const float left = 1.0f - out->share[MIXED_SLOT_OWN][i];
        const float weight = left * tent * mixed_match(&v, s, i, pixel);
        out->share[slot][i] = s->on.on[i] ? weight : 0.0f;
    }
}

/* Computes points and normals in camera space. */
static void place_subs_seen(const struct surface_view *view, struct mixed_subs *restrict s)
{
    const struct surface_view v = *view;
    const struct plan_camera c = *v.camera;
    for (int i = 0; i < LANES; i++) {
        const float a = v.a_start + v.a_step * s->px[i], b = v.b_start + v.b_step * s->py[i];
        const float d = s->distance[i];
        const float along = v.orthographic ? d : d / sqrtf(1.0f + a * a + b * b);
        const float across = v.orthographic ? 1.0f : along;
        const float x = s->facing.x[i], y = s->facing.y[i], z = s->facing.z[i];
        s->point.x[i] = a * across;
        s->point.y[i] = b * across;
        s->point.z[i] = along;
        s->normal.x[i] = x * c.right[0] + y * c.right[1] + z * c.right[2];
        s->normal.y[i] = x * c.up[0] + y * c.up[1] + z * c.up[2];
        s->normal.z[i] = x * c.forward[0] + y * c.forward[1] + z * c.forward[2];
    }
}

static void normalise_shares(const struct mixed_subs *restrict s, uint32_t lenders,
                             struct mixed_shares *restrict out)
{
    _Alignas(LANES_ALIGN) float sum[LANES] = {0};
    for (uint32_t slot = 0; slot < MIXED_SLOTS; slot++)
        if (lenders >> slot & 1u)
            for (int i = 0; i < LANES; i++) sum[i] += out->share[slot][i];
    for (int i = 0; i < LANES; i++) {
        const int lent = sum[i] >= SURFACE_WEIGHT_MIN;
        out->lent.on[i] = -(lent & (s->on.on[i] != 0));
        sum[i] = lent ? 1.0f / sum[i] : 0.0f;
    }
    for (uint32_t slot = 0; slot < MIXED_SLOTS; slot++)
        if (lenders >> slot & 1u)
            for (int i = 0; i < LANES; i++) out->share[slot][i] *= sum[i];
}

static void kernel_split_subs(const struct surface_view *view,
                              const struct shown_surface pixels[MIXED_SLOTS], uint32_t lenders,
                              struct mixed_subs *s, struct mixed_shares *out)
{
    float least = 1.0f;
    place_subs_seen(view, s);
    for (int i = 0; i < LANES; i++) out->share[MIXED_SLOT_OWN][i] = 0.0f;
    if (lenders >> MIXED_SLOT_OWN & 1u)
        for (int i = 0; i < LANES; i++)
            out->share[MIXED_SLOT_OWN][i] =
                s->on.on[i] ? mixed_match(view, s, i, &pixels[MIXED_SLOT_OWN]) : 0.0f;
    for (int i = 0; i < LANES; i++) {
        const float own = s->on.on[i] ? out->share[MIXED_SLOT_OWN][i] : 1.0f;
        least = own < least ? own : least;
    }
    out->lenders = lenders & 1u << MIXED_SLOT_OWN;
    if (least < 1.0f) out->lenders = lenders;
    for (uint32_t slot = 0; slot < MIXED_SLOTS; slot++)
        if (slot != MIXED_SLOT_OWN && out->lenders >> slot & 1u)
            weigh_lender(view, s, &pixels[slot], slot, out);
    normalise_shares(s, out->lenders, out);
}
