#include "worker/trace/field/field_pack.h"

#include <string.h>

/* Chooses the lanes of the slots. */
static void deal_slots(const struct lanes_mask *lanes, struct field_pack *p)
{
    uint32_t chosen[LANES], count = 0;
    for (uint32_t i = 0; i < LANES; i++)
        if (lanes->on[i]) chosen[count++] = i;
    p->replicas = LANES / count;
    for (uint32_t v = 0; v < LANES; v++) {
        p->lane[v] = chosen[v % count];
        p->part[v] = v / count;
        p->on.on[v] = v / count < p->replicas ? -1 : 0;
    }
}

static void pick(const uint32_t lane[LANES], const float *from, float *to)
{
    for (int v = 0; v < LANES; v++) to[v] = from[lane[v]];
}

static void pick3(const uint32_t lane[LANES], const struct lanes3 *from, struct lanes3 *to)
{
    pick(lane, from->x, to->x);
    pick(lane, from->y, to->y);
    pick(lane, from->z, to->z);
}

static void pick_mask(const uint32_t lane[LANES], const struct lanes_mask *from,
                      struct lanes_mask *to)
{
    for (int v = 0; v < LANES; v++) to->on[v] = from->on[lane[v]];
}

static void pick_surface(const uint32_t lane[LANES], const struct surface *from, struct surface *to)
{
    pick3(lane, &from->position, &to->position);
    pick3(lane, &from->origin, &to->origin);
    pick3(lane, &from->plane, &to->plane);
    pick3(lane, &from->lift, &to->lift);
    pick3(lane, &from->facet, &to->facet);
    pick3(lane, &from->normal, &to->normal);
    pick3(lane, &from->albedo, &to->albedo);
    pick3(lane, &from->emission, &to->emission);
    pick(lane, from->distance, to->distance);
    pick_mask(lane, &from->hit, &to->hit);
    pick_mask(lane, &from->light, &to->light);
    pick_mask(lane, &from->behind, &to->behind);
    for (int v = 0; v < LANES; v++) {
        to->id[v] = from->id[lane[v]];
        to->mesh[v] = from->mesh[lane[v]];
    }
    to->any_bsdf = from->any_bsdf;
    to->any_emission = from->any_emission;
}

/* Picks all that rays ask that leave first surfaces; the choice of lights is no part of it. */
static void pick_vertex(const uint32_t lane[LANES], const struct path_vertex *from,
                        struct path_vertex *to)
{
    to->depth = from->depth;
    pick_surface(lane, &from->surface, &to->surface);
    pick_mask(lane, &from->active, &to->active);
    pick_mask(lane, &from->lambert, &to->lambert);
    to->any_lambert = from->any_lambert;
    to->any_general = from->any_general;
    to->mirrors.any = false;
    to->far = NULL;
    to->is_far = false;
    if (!from->any_general) return;
    for (int v = 0; v < LANES; v++) to->bsdf[v] = from->bsdf[lane[v]];
    pick3(lane, &from->tangent, &to->tangent);
    pick3(lane, &from->bitangent, &to->bitangent);
    pick3(lane, &from->back, &to->back);
}

void field_pack_init(const struct block *block, const struct path_vertex *from,
                     const struct lanes_mask *lanes, struct field_pack *out)
{
    deal_slots(lanes, out);
    out->block = *block;
    out->block.whole = false;
    for (int v = 0; v < LANES; v++) {
        out->block.x_px[v] = block->x_px[out->lane[v]];
        out->block.y_px[v] = block->y_px[out->lane[v]];
        out->block.element[v] = block->element[out->lane[v]];
    }
    pick_mask(out->lane, &block->inside, &out->block.inside);
    pick_mask(out->lane, &block->kept, &out->block.kept);
    pick_vertex(out->lane, from, &out->vertex);
}

void field_pack_take(const struct field_pack *pack, const struct path_radiance *h, uint32_t first,
                     uint32_t part, struct field_sample *out)
{
    const float *const r = h->indirect.r + first, *const g = h->indirect.g + first;
    const float *const b = h->indirect.b + first, *const distance = h->distance + first;
    if (!pack) {
        memcpy(out->radiance.x, r, sizeof out->radiance.x);
        memcpy(out->radiance.y, g, sizeof out->radiance.y);
        memcpy(out->radiance.z, b, sizeof out->radiance.z);
        memcpy(out->distance, distance, sizeof out->distance);
        return;
    }
    memset(out, 0, sizeof *out);
    for (int v = 0; v < LANES; v++) {
        const uint32_t i = pack->lane[v];
        if (!pack->on.on[v] || pack->part[v] != part) continue;
        out->radiance.x[i] = r[v];
        out->radiance.y[i] = g[v];
        out->radiance.z[i] = b[v];
        out->distance[i] = distance[v];
    }
}
