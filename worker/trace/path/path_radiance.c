#include <string.h>

#include "worker/trace/path/path_photograph.h"

void path_radiance_add(const struct path_context *c, struct path_radiance *h, uint32_t scatterings,
                       uint32_t slot, const float value[3])
{
    struct path_rgb *to = scatterings > 1 ? &h->indirect : &h->direct;
    to->r[slot] += value[0];
    to->g[slot] += value[1];
    to->b[slot] += value[2];
    if (!c->demodulate || ((c->skip & SKIP_SOFT_SKY) && scatterings == 1)) return;
    to = scatterings > 1 + h->chain[slot] ? &h->diffuse_indirect : &h->diffuse_direct;
    to->r[slot] += value[0] * h->share.r[slot];
    to->g[slot] += value[1] * h->share.g[slot];
    to->b[slot] += value[2] * h->share.b[slot];
}

/* Sets the lanes that are off to zero, whatever they hold. */
static void keep(const struct lanes_mask *on, struct lanes3 *v)
{
    for (int i = 0; i < LANES; i++) {
        v->x[i] = on->on[i] ? v->x[i] : 0.0f;
        v->y[i] = on->on[i] ? v->y[i] : 0.0f;
        v->z[i] = on->on[i] ? v->z[i] : 0.0f;
    }
}

/* Adds all lanes. Whether a light is seen is chance, and adding zeros costs less than wrong
 * branches. */
static void add(const struct path_packet *p, const struct lanes3 *v, struct path_rgb *to)
{
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        to->r[slot] += v->x[i];
        to->g[slot] += v->y[i];
        to->b[slot] += v->z[i];
    }
}

/* Scatterings of chains do not count. */
static void add_after_chains(const struct path_packet *p, uint32_t scatterings,
                             const struct lanes3 *v, struct path_radiance *h)
{
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        const bool direct = scatterings <= 1 + h->chain[slot];
        struct path_rgb *to = direct ? &h->diffuse_direct : &h->diffuse_indirect;
        to->r[slot] += v->x[i];
        to->g[slot] += v->y[i];
        to->b[slot] += v->z[i];
    }
}

void path_radiance_add_lanes(const struct path_context *c, struct path_radiance *h,
                             uint32_t scatterings, const struct path_packet *p,
                             const struct lanes_mask *on, const struct lanes3 *value)
{
    struct lanes3 v = *value;
    struct lanes_mask whole = *on;
    if (c->photograph && scatterings > 1) path_part_add_lanes(p, &whole, value, h);
    on = &whole;
    keep(on, &v);
    add(p, &v, scatterings > 1 ? &h->indirect : &h->direct);
    if (!c->demodulate || ((c->skip & SKIP_SOFT_SKY) && scatterings == 1)) return;
    v = *value;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        v.x[i] *= h->share.r[slot];
        v.y[i] *= h->share.g[slot];
        v.z[i] *= h->share.b[slot];
    }
    keep(on, &v);
    if (c->chains && scatterings > 1)
        add_after_chains(p, scatterings, &v, h);
    else
        add(p, &v, scatterings > 1 ? &h->diffuse_indirect : &h->diffuse_direct);
}

void path_radiance_clear_field(struct path_radiance *h, uint32_t count)
{
    const size_t bytes = sizeof(float) * count * LANES;
    memset(h->indirect.r, 0, bytes);
    memset(h->indirect.g, 0, bytes);
    memset(h->indirect.b, 0, bytes);
    memset(h->distance, 0, bytes);
}

void path_radiance_mirrors(struct path_radiance *h, uint32_t count, const struct path_vertex *from)
{
    const struct mirrors *m = &from->mirrors;
    for (uint32_t k = 0; k < count; k++)
        for (uint32_t i = 0; i < LANES; i++) h->mirrored[k * LANES + i] = m->any ? m->count[i] : 0;
}
