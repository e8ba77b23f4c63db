#include "server/reconstruct/compose/resolve_run.h"

#include <math.h>

static void match_ids(const uint32_t *restrict ids, const uint32_t *restrict subs, uint32_t count,
                      int32_t *restrict plain)
{
    for (uint32_t j = 0; j < count; j++) plain[j] &= -(surface_sub_id(ids[j]) == subs[j]);
}

/* Asks less than surface_surely_same: points that are near only because the surface faces so are
 * left to resolve_pixel. */
static void match_surfaces(const struct resolver *r, size_t i, uint32_t k, uint32_t count,
                           int32_t *restrict plain)
{
    const struct surface_view view = r->view;
    const struct patch *p = r->patch;
    const float *restrict depth = p->depth + i, *restrict sub = p->sub_depth[k] + i;
    const float *restrict nx = p->normal[0] + i, *restrict mx = p->sub_normal[k][0] + i;
    const float *restrict ny = p->normal[1] + i, *restrict my = p->sub_normal[k][1] + i;
    const float *restrict nz = p->normal[2] + i, *restrict mz = p->sub_normal[k][2] + i;
    for (uint32_t j = 0; j < count; j++) {
        const float cosine = nx[j] * mx[j] + ny[j] * my[j] + nz[j] * mz[j];
        const int32_t near = surface_near_anyhow(&view, depth[j], sub[j]) & (sub[j] > 0.0f);
        plain[j] &= -(near & !(cosine < SURFACE_COS_FULL));
    }
}

/* plain: zeros. */
static void find_plain(const struct resolver *r, size_t i, uint32_t count, int32_t *restrict plain)
{
    const struct patch *p = r->patch;
    if (!p->depth) return;
    for (uint32_t j = 0; j < count; j++) plain[j] = -(p->depth[i + j] > 0.0f);
    for (uint32_t k = 0; k < r->subs; k++) {
        match_surfaces(r, i, k, count, plain);
        if (p->id && p->sub_id[k]) match_ids(p->id + i, p->sub_id[k] + i, count, plain);
    }
}

static void add(const float *restrict from, uint32_t count, float *restrict sum)
{
    for (uint32_t j = 0; j < count; j++) sum[j] += from[j];
}

/* What the samples' albedos add up to. */
static void add_albedo(const struct resolver *r, size_t i, int c, uint32_t count,
                       float *restrict own)
{
    const struct patch *p = r->patch;
    for (uint32_t j = 0; j < count; j++) own[j] = p->albedo[0] ? p->albedo[c][i + j] : 1.0f;
    for (uint32_t k = 0; k < r->subs; k++) add(p->sub_albedo[k][c] + i, count, own);
}

static void add_reflectance(const struct resolver *r, size_t i, int c, uint32_t count,
                            float *restrict own)
{
    const struct patch *p = r->patch;
    for (uint32_t j = 0; j < count; j++) own[j] = 0.0f;
    add(p->reflectance[c] + i, count, own);
    for (uint32_t k = 0; k < r->subs; k++)
        if (p->sub_reflectance[k][0]) add(p->sub_reflectance[k][c] + i, count, own);
}

/* out = by * light, after what was there. */
static void add_lit(const float *restrict by, const float *restrict light, uint32_t count,
                    float *restrict out)
{
    for (uint32_t j = 0; j < count; j++) out[j] += by[j] * light[j];
}

static void scale(float *restrict values, uint32_t count, float share)
{
    for (uint32_t j = 0; j < count; j++) values[j] *= share;
}

static void light_channel(const struct resolver *r, size_t i, int c, uint32_t count,
                          struct resolved_run *out)
{
    const struct lighting *l = r->lighting;
    float own[RESOLVE_RUN], *const sums[] = {out->total[c], out->direct[c], out->indirect[c]};
    const float *const lights[] = {l->total[c], l->direct[c], l->indirect[c]};
    const int wanted = r->parts ? 3 : 1;
    add_albedo(r, i, c, count, own);
    for (uint32_t j = 0; j < count; j++) out->albedo[c][j] = own[j];
    for (int s = 0; s < wanted; s++) {
        for (uint32_t j = 0; j < count; j++) sums[s][j] = 0.0f;
        add_lit(own, lights[s] + i, count, sums[s]);
    }
    if (l->glossy[0] && r->patch->reflectance[0]) {
        add_reflectance(r, i, c, count, own);
        add_lit(own, l->glossy[c] + i, count, out->total[c]);
        if (r->parts) add_lit(own, l->glossy[c] + i, count, out->indirect[c]);
    }
    for (int s = 0; s < wanted; s++) scale(sums[s], count, r->share);
    scale(out->albedo[c], count, r->share);
}

/* Mixed pixels are left to resolve_pixel, whatever their few samples show. */
static void leave_mixed(const struct mixed_share *mixed, size_t i, uint32_t count,
                        int32_t *restrict plain)
{
    uint32_t e = mixed_share_from(mixed, i);
    for (; e < mixed->count && mixed_share_pixel(mixed, e) < i + count; e++)
        plain[mixed_share_pixel(mixed, e) - i] = 0;
}

void resolve_run(const struct resolver *r, size_t i, uint32_t count, struct resolved_run *out)
{
    int32_t any = 0;
    for (uint32_t j = 0; j < count; j++) out->plain[j] = 0;
    if (!r->errors) find_plain(r, i, count, out->plain);
    leave_mixed(&r->patch->mixed, i, count, out->plain);
    for (uint32_t j = 0; j < count; j++) any |= out->plain[j];
    if (!any) return;
    for (int c = 0; c < 3; c++) light_channel(r, i, c, count, out);
    for (uint32_t j = 0; j < count; j++) out->coverage[j] = (float)(1 + r->subs) * r->share;
}

void resolved_run_set(struct resolved_run *run, uint32_t k, const struct resolved *pixel)
{
    for (int c = 0; c < 3; c++) {
        run->direct[c][k] = pixel->direct[c];
        run->indirect[c][k] = pixel->indirect[c];
        run->total[c][k] = pixel->total[c];
        run->albedo[c][k] = pixel->albedo[c];
    }
    run->coverage[k] = pixel->coverage;
}
