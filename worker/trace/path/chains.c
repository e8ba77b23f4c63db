#include "worker/trace/path/chains.h"

#include "worker/trace/path/path_kernels.h"

static void set(struct path_rgb *to, uint32_t slot, const float v[3])
{
    to->r[slot] = v[0];
    to->g[slot] = v[1];
    to->b[slot] = v[2];
}

/* What the chain has done to light, with the chances of its turns. */
static void throughput_of(const struct path_packet *p, uint32_t i, float out[3])
{
    out[0] = p->throughput.x[i];
    out[1] = p->throughput.y[i];
    out[2] = p->throughput.z[i];
}

static void note_lane(const struct path_packet *p, const struct path_vertex *v, uint32_t i,
                      struct path_radiance *h)
{
    const struct surface *s = &v->surface;
    const uint32_t slot = p->slot[i];
    const struct bsdf *b = &v->bsdf[i];
    const bool lobes = v->active.on[i] && !v->lambert.on[i];
    const float active = v->active.on[i] ? 1.0f : 0.0f;
    float t[3], tint[3] = {0.0f, 0.0f, 0.0f};
    throughput_of(p, i, t);
    if (lobes) bsdf_tint(b, tint);
    set(&h->albedo, slot,
        (float[3]){active * t[0] * s->albedo.x[i], active * t[1] * s->albedo.y[i],
                   active * t[2] * s->albedo.z[i]});
    set(&h->normal, slot, (float[3]){s->normal.x[i], s->normal.y[i], s->normal.z[i]});
    set(&h->tint, slot, (float[3]){t[0] * tint[0], t[1] * tint[1], t[2] * tint[2]});
    h->alpha[slot] = lobes ? bsdf_sharpest_alpha(b) : 0.0f;
    h->distance[slot] += s->distance[i];
}

void chains_note(const struct path_context *c, const struct path_packet *p,
                 const struct path_vertex *v, struct path_radiance *h)
{
    for (uint32_t i = 0; i < p->count; i++)
        if (chains_has(c, p, v, h, i) && v->surface.hit.on[i]) note_lane(p, v, i, h);
}

void chains_gather(const struct path_context *c, const struct path_packet *p,
                   const struct path_vertex *v, const struct lanes_mask *lit,
                   const struct lanes3 *diffuse, struct path_radiance *h)
{
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (!lit->on[i] || !chains_has(c, p, v, h, i)) continue;
        h->diffuse_direct.r[slot] += diffuse->x[i];
        h->diffuse_direct.g[slot] += diffuse->y[i];
        h->diffuse_direct.b[slot] += diffuse->z[i];
    }
}

static float over(float part, float all)
{
    return all > 0.0f ? part / all : 0.0f;
}

static void keep_share(const struct path_packet *p, const struct path_scattering *s, uint32_t i,
                       struct path_radiance *h)
{
    const float diffuse = s->diffuse[i];
    float t[3];
    throughput_of(p, i, t);
    set(&h->share, p->slot[i],
        (float[3]){over(diffuse, s->weight.x[i] * t[0]), over(diffuse, s->weight.y[i] * t[1]),
                   over(diffuse, s->weight.z[i] * t[2])});
}

/* A path that reflects where most is transmitted, or the other way round, tells filters nothing of
 * what most paths of its pixel see, nor does one that ends: it leaves the chain. */
static void go_on(const struct path_context *c, const struct path_vertex *v,
                  const struct path_scattering *s, uint32_t i, uint32_t slot,
                  struct path_radiance *h)
{
    const bool through = s->through.on[i];
    if (s->on.on[i] && through != bsdf_reflects_max(&v->bsdf[i], v->back.z[i]))
        h->chain[slot]++;
    else
        h->strayed[slot] = c->chains;
}

/* One colour of dispersed glass would tell little of what all show: there chains end. */
void chains_scatter(const struct path_context *c, const struct path_packet *p,
                    const struct path_vertex *v, const struct path_scattering *s,
                    struct path_radiance *h)
{
    if (c->field) return;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (p->part[i] != PATH_PART_NONE || h->chain[slot] != v->depth || !v->active.on[i])
            continue;
        if (!v->lambert.on[i] && bsdf_is_dirac(&v->bsdf[i]) && !v->bsdf[i].dispersed)
            go_on(c, v, s, i, slot, h);
        else if (c->chains && v->depth > 0 && s->on.on[i])
            keep_share(p, s, i, h);
    }
}
