#pragma once
/* light_kernels' light_hidden, sample_strata, add_strata and add_slopes: a light's strata before
 * Embree and after. */
#include "proto/pattern.h"
#include "worker/trace/hit/block_store.h"
#include "worker/trace/light/light_lanes.h"
#include "worker/trace/light/shadow_sums.h"
#include "worker/trace/light/strata.h"

/* Returns the largest product of a direction with the ways to a rectangle's corners, given its
 * products with the way to the centre and with the half sides. */
static inline float reach(float centre, float u, float v)
{
    return centre + fabsf(u) + fabsf(v);
}

/* Returns why no point of the rectangle sends light to lane i, as far as its corners can tell. */
LANE_INLINE int32_t hidden_lane(const struct plan_light *p, const struct surface *r, int i)
{
    const float *c = p->position, *u = p->half_u, *v = p->half_v, *d = p->direction;
    float wx = c[0] - r->position.x[i], wy = c[1] - r->position.y[i];
    float wz = c[2] - r->position.z[i];
    float nx = r->normal.x[i], ny = r->normal.y[i], nz = r->normal.z[i];
    float fx = r->facet.x[i], fy = r->facet.y[i], fz = r->facet.z[i];
    float nu = nx * u[0] + ny * u[1] + nz * u[2], nv = nx * v[0] + ny * v[1] + nz * v[2];
    float fu = fx * u[0] + fy * u[1] + fz * u[2], fv = fx * v[0] + fy * v[1] + fz * v[2];
    float shading = wx * nx + wy * ny + wz * nz, facet = wx * fx + wy * fy + wz * fz;
    int32_t skip = -(wx * d[0] + wy * d[1] + wz * d[2]) > 0.0f ? LIGHT_TRACED : LIGHT_FACING_AWAY;
    skip = -reach(-facet, fu, fv) > 0.0f ? skip : LIGHT_TRACED;
    skip = -reach(-shading, nu, nv) > 0.0f ? skip : LIGHT_TRACED;
    return reach(shading, nu, nv) > 0.0f ? skip : LIGHT_BELOW_HORIZON;
}

/* Finds the lanes that no point of a rectangle can light. It lies below a plane when all its
 * corners do, and a receiver behind its plane is behind all of it. Rectangles that only the facet
 * hides are sampled: their strata count as blocked. */
static bool kernel_light_hidden(const struct light *light, const struct surface *restrict r,
                                const struct lanes_mask *restrict lanes,
                                struct light_packet *restrict out)
{
    const struct plan_light *p = light->plan;
    int32_t open = 0;
    if (p->type != LIGHT_RECTANGLE) return false;
    if (lanes->on[0] && hidden_lane(p, r, 0) == LIGHT_TRACED) return false; /* as most are */
    for (int i = 0; i < LANES; i++) {
        const int32_t skip = hidden_lane(p, r, i);
        out->skip[i] = skip;
        open |= lanes->on[i] & -(skip == LIGHT_TRACED);
    }
    return open == 0;
}

static void kernel_lattice_jitters(const struct pattern_lattice *restrict lattice,
                                   const struct block *restrict b, float *restrict jitter0,
                                   float *restrict jitter1)
{
    for (int i = 0; i < LANES; i++) {
        jitter0[i] = pattern_lattice_jitter(lattice, b->x_px[i], b->y_px[i], 0);
        jitter1[i] = pattern_lattice_jitter(lattice, b->x_px[i], b->y_px[i], 1);
    }
}

static void kernel_place_strata(const float *restrict jitter0, const float *restrict jitter1,
                                uint32_t l, struct strata *restrict out)
{
    out->l = l;
    for (uint32_t k = 0; k < l; k++)
        for (int i = 0; i < LANES; i++) {
            out->column[k][i] = pattern_axis(jitter0[i], l, k);
            out->row[k][i] = pattern_axis(jitter1[i], l, k);
        }
}

/* Computes the middles of a rectangle's columns, at v = 1/2, in the order of sample_rectangle's
 * sums. Each column is a line through its middle, and rows are equally far from it in all
 * columns. */
static void place_column(const struct plan_light *p, const float *restrict u,
                         struct lanes3 *restrict out)
{
    const float *c = p->position, *h = p->half_u;
    for (int i = 0; i < LANES; i++) {
        float a = 2.0f * u[i] - 1.0f;
        out->x[i] = c[0] + a * h[0];
        out->y[i] = c[1] + a * h[1];
        out->z[i] = c[2] + a * h[2];
    }
}

static void place_row(const struct plan_light *p, const float *restrict v,
                      struct lanes3 *restrict out)
{
    const float *h = p->half_v;
    for (int i = 0; i < LANES; i++) {
        float b = 2.0f * v[i] - 1.0f;
        out->x[i] = b * h[0];
        out->y[i] = b * h[1];
        out->z[i] = b * h[2];
    }
}

static void sample_place(const struct light *restrict light, const struct lanes3 *restrict column,
                         const struct lanes3 *restrict row, const int32_t *restrict origin,
                         const struct surface *restrict r, const struct lanes_mask *restrict lanes,
                         struct light_packet *restrict out)
{
    out->end = SHADOW_END;
    for (int i = 0; i < LANES; i++)
        sample_point_of_rectangle(light, r, lanes, i, origin[i], column->x[i] + row->x[i],
                                  column->y[i] + row->y[i], column->z[i] + row->z[i], 1.0f, false,
                                  out);
}

/* Samples evenly bright rectangles of so few columns that the batch goes through all of them. */
static void sample_grid(const struct light *light, const struct strata *strata, uint32_t first,
                        uint32_t count, const struct surface *r, const struct lanes_mask *lanes,
                        struct light_packet *batch)
{
    const struct plan_light *p = light->plan;
    const uint32_t l = strata->l;
    _Alignas(LANES_ALIGN) int32_t origin[LANES];
    struct lanes3 column[SHADOW_BATCH], row;
    for (int i = 0; i < LANES; i++) origin[i] = judge_origin(r, i);
    for (uint32_t k = 0; k < l; k++) place_column(p, strata->column[k], &column[k]);
    for (uint32_t k = 0, at = first % l, down = first / l; k < count; k++) {
        if (k == 0 || at == 0) place_row(p, strata->row[down], &row);
        sample_place(light, &column[at], &row, origin, r, lanes, &batch[k]);
        if (++at == l) at = 0, down++;
    }
}

static void sample_one_by_one(const struct light *light, const struct strata *strata,
                              uint32_t first, uint32_t count, const struct surface *r,
                              const struct lanes_mask *lanes, struct light_packet *batch)
{
    const bool wide = light->plan->type == LIGHT_RECTANGLE;
    const bool profiled = light->plan->profile == PROFILE_GAUSSIAN;
    for (uint32_t k = 0; k < count; k++) {
        const float *u = strata_u(strata, first + k), *v = strata_v(strata, first + k);
        batch[k].end = SHADOW_END;
        if (!wide)
            kernel_sample_light(light, u, v, r, lanes, &batch[k]);
        else if (profiled)
            sample_rectangle(light, u, v, r, lanes, false, true, &batch[k]);
        else
            sample_rectangle(light, u, v, r, lanes, false, false, &batch[k]);
    }
}

static bool kernel_sample_strata(const struct light *light, const struct strata *strata,
                                 uint32_t first, uint32_t count, const struct surface *receiver,
                                 const struct lanes_mask *restrict lanes,
                                 struct light_packet *restrict batch)
{
    const struct plan_light *p = light->plan;
    _Alignas(LANES_ALIGN) int32_t all[LANES];
    int32_t skipped = 0;
    if (p->type == LIGHT_RECTANGLE && p->profile == PROFILE_UNIFORM && strata->l <= SHADOW_BATCH)
        sample_grid(light, strata, first, count, receiver, lanes, batch);
    else
        sample_one_by_one(light, strata, first, count, receiver, lanes, batch);
    for (int i = 0; i < LANES; i++) all[i] = lanes->on[i];
    for (uint32_t k = 0; k < count; k++)
        for (int i = 0; i < LANES; i++) all[i] &= batch[k].traced.on[i];
    for (int i = 0; i < LANES; i++) skipped |= all[i] ^ lanes->on[i];
    return skipped == 0;
}

static void sums_init(struct shadow_sums *restrict s)
{
    for (int i = 0; i < LANES; i++) {
        s->irradiance[i] = s->row[i] = s->most[i] = 0.0f;
        s->least[i] = 1.0f;
        s->seen[i] = s->blocked.on[i] = 0;
    }
}

/* Adds up strata whose rays have come back. Blocked rays have a tfar before their end: -infinity
 * from occlusion queries, the blocker's t from closest-hit ones. */
static void kernel_add_strata(const struct light_packet *restrict batch, uint32_t first,
                              uint32_t count, uint32_t l, struct shadow_sums *restrict out)
{
    struct shadow_sums sums;
    uint32_t column = first % l;
    if (first == 0) sums_init(out);
    sums = *out;
    for (uint32_t k = 0; k < count; k++) {
        const struct light_packet *p = &batch[k];
        const float *restrict tfar = p->rays.ray.tfar;
        for (int i = 0; i < LANES; i++) {
            int32_t blocked = -(tfar[i] < p->end) & p->traced.on[i];
            float added = p->irradiance[i];
            sums.row[i] += p->traced.on[i] & ~blocked ? added : 0.0f;
            blocked |= -(p->skip[i] == LIGHT_BELOW_FACET);
            sums.seen[i] |= (blocked + 1) << ((first & 7) + k);
        }
        if (++column < l) continue;
        column = 0;
        for (int i = 0; i < LANES; i++) {
            sums.irradiance[i] += sums.row[i];
            sums.row[i] = 0.0f;
        }
    }
    const float scale = 1.0f / (float)(l * l);
    for (int i = 0; first + count == l * l && i < LANES; i++) sums.irradiance[i] *= scale;
    *out = sums;
}

static void kernel_store_visibility(const struct block *b, const struct lanes_mask *hit,
                                    struct shadow_sums *sums, uint8_t *plane)
{
    _Alignas(LANES_ALIGN) uint8_t bytes[LANES];
    for (int i = 0; i < LANES; i++) {
        bytes[i] = (uint8_t)(sums->seen[i] & hit->on[i]);
        sums->seen[i] >>= 8;
    }
    block_scatter(b, bytes, plane, sizeof bytes[0]);
}

static void kernel_add_slopes(const struct light_packet *restrict p,
                              struct shadow_sums *restrict sums)
{
    const float *restrict tfar = p->rays.ray.tfar;
    for (int i = 0; i < LANES; i++) {
        int32_t blocked = tfar[i] < p->end ? p->traced.on[i] : 0;
        float near = blocked ? tfar[i] : 1.0f, far = blocked ? tfar[i] : 0.0f;
        sums->blocked.on[i] |= blocked;
        sums->least[i] = near < sums->least[i] ? near : sums->least[i];
        sums->most[i] = far > sums->most[i] ? far : sums->most[i];
    }
}
