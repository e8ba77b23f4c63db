#include <string.h>

#include "worker/trace/path.h"

void path_harvest_add(const struct path_context *c, struct path_harvest *h, uint32_t scatterings,
                      uint32_t slot, const float value[3])
{
    struct path_rgb *to = scatterings > 1 ? &h->indirect : &h->direct;
    to->r[slot] += value[0];
    to->g[slot] += value[1];
    to->b[slot] += value[2];
    if (!c->demodulate || (c->leaves_sky && scatterings == 1)) return;
    to = scatterings > 1 ? &h->diffuse_indirect : &h->diffuse_direct;
    to->r[slot] += value[0] * h->share.r[slot];
    to->g[slot] += value[1] * h->share.g[slot];
    to->b[slot] += value[2] * h->share.b[slot];
}

void path_harvest_clear_field(struct path_harvest *h, uint32_t count)
{
    const size_t bytes = sizeof(float) * count * LANES;
    memset(h->indirect.r, 0, bytes);
    memset(h->indirect.g, 0, bytes);
    memset(h->indirect.b, 0, bytes);
    memset(h->distance, 0, bytes);
}

void path_harvest_mirrors(struct path_harvest *h, uint32_t count, const struct path_vertex *from)
{
    const struct mirrors *m = &from->mirrors;
    for (uint32_t k = 0; k < count; k++)
        for (uint32_t i = 0; i < LANES; i++) h->mirrored[k * LANES + i] = m->any ? m->count[i] : 0;
}
