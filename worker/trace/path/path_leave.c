#include "worker/trace/path/path_leave.h"

#include <math.h>

#include "proto/pattern_path.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_record.h"

/* Beyond what it has met a path carries only what no light field brings of the first surface's
 * lobes; by chance, in proportion to that share. */
void path_leave_diffuse(const struct path_context *c, struct path_packet *p, struct path_vertex *v,
                        struct path_radiance *h)
{
    _Alignas(LANES_ALIGN) float chance[LANES], unused[LANES];
    uint64_t *counters = c->counters->value;
    bool any = false;
    c->kernels->path_pairs(p, PATH_VERTEX + PATH_ROULETTE, chance, unused);
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t slot = p->slot[i];
        if (!v->active.on[i]) continue;
        if (h->own[slot] > 0.0f) {
            any = true;
            continue;
        }
        float kept[3] = {h->kept.r[slot], h->kept.g[slot], h->kept.b[slot]};
        float most = fmaxf(kept[0], fmaxf(kept[1], kept[2]));
        bool stays = chance[i] < most;
        counters[most > 0.0f ? COUNTER_SKIPPED_ROULETTE : COUNTER_SKIPPED_LIGHT_FIELD] += !stays;
        v->active.on[i] &= stays ? -1 : 0;
        v->lambert.on[i] &= v->active.on[i];
        any |= stays;
        if (!stays) continue;
        p->throughput.x[i] *= kept[0] / most;
        p->throughput.y[i] *= kept[1] / most;
        p->throughput.z[i] *= kept[2] / most;
        h->share.r[slot] = h->share.g[slot] = h->share.b[slot] = 0.0f;
    }
    if (!any) v->any_lambert = v->any_general = false;
    if (c->record) path_record_leave(c, p, v);
}

void path_end_lanes(const struct lanes_mask *ended, struct path_vertex *v)
{
    v->any_lambert = v->any_general = false;
    for (int i = 0; i < LANES; i++) {
        v->active.on[i] &= ~ended->on[i];
        v->lambert.on[i] &= v->active.on[i];
        v->any_lambert |= v->lambert.on[i] != 0;
        v->any_general |= v->active.on[i] != v->lambert.on[i];
    }
}

/* Surfaces with a normal map are paths' alone. */
bool path_leaves_to_fields(const struct surface *s, int i)
{
    return !(s->mesh[i]->traits & MESH_BUMPY);
}

void path_hide_from_fields(struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        if (!s->hit.on[i] || path_leaves_to_fields(s, i)) continue;
        s->albedo.x[i] = s->albedo.y[i] = s->albedo.z[i] = 0.0f;
    }
}

/* Paths that bring nothing are as if they had never been traced, as those of pixels that show no
 * other lobes are not: what they have seen does not count. */
static void forget_surface(const struct path_packet *p, const struct path_vertex *v,
                           struct path_radiance *h)
{
    struct path_rgb *const noted[] = {&h->albedo, &h->normal};
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (v->active.on[i] && (!v->lambert.on[i] || !path_leaves_to_fields(&v->surface, (int)i)))
            continue;
        h->coverage[slot] = h->distance[slot] = 0.0f;
        for (int k = 0; k < 2; k++) noted[k]->r[slot] = noted[k]->g[slot] = noted[k]->b[slot] = 0;
    }
}

/* Light fields bring what diffuse lobes send on: none is left. */
void path_leave_surface(const struct path_context *c, const struct path_packet *p,
                        struct path_vertex *v, struct path_radiance *h)
{
    struct lanes_mask ended = v->lambert;
    for (int i = 0; i < LANES; i++) {
        struct bsdf *b = &v->bsdf[i];
        if (!v->active.on[i]) continue;
        if (!path_leaves_to_fields(&v->surface, i)) {
            ended.on[i] = 0;
        } else {
            const uint32_t slot = p->slot[i];
            h->albedo.r[slot] = h->albedo.g[slot] = h->albedo.b[slot] = 0.0f;
            if (!v->lambert.on[i]) b->albedo[0] = b->albedo[1] = b->albedo[2] = 0;
        }
    }
    forget_surface(p, v, h);
    c->counters->value[COUNTER_SKIPPED_LIGHT_FIELD] += lanes_count(&ended);
    if (lanes_count(&ended) > 0) path_end_lanes(&ended, v);
    if (c->record) path_record_leave(c, p, v);
}

/* Paths beside light fields go on from so many times the share of light that their first surface's
 * facets reflect, over the width of their lobe, at most surely. */
#define LOBE_CHANCE 2.0f

/* Returns how often a lobe of facets is worth a look, beside others that are always. */
static float lobe_chance(const struct layers *l, int i)
{
    const float width = 0.5f * (l->alpha_u[i] + l->alpha_v[i]); /* above 0: layers are rough */
    return LOBE_CHANCE * (l->metallic[i] + 1.0f - l->kept[i]) / width;
}

/* Diffuse lobes bring nothing of the plan's lights, and facets that reflect little only a little.
 */
static float listed_share(const struct path_vertex *v, int i)
{
    const struct layers *l = &v->layers;
    if (!v->left.on[i]) return 1.0f;
    if (v->lambert.on[i]) return 0.0f;
    return l->on.on[i] ? fminf(lobe_chance(l, i), 1.0f) : 1.0f;
}

void path_leave_listed(const struct path_packet *p, struct path_vertex *v, struct path_radiance *h)
{
    for (int i = 0; i < LANES; i++) {
        v->left.on[i] = v->active.on[i] && path_leaves_to_fields(&v->surface, i) ? -1 : 0;
        v->listed[i] = listed_share(v, i);
    }
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        h->own[slot] = v->left.on[i] ? 0.0f : 1.0f;
        h->listed[slot] = v->listed[i];
    }
}

/* Where facets reflect little, and that widely, few paths stand for all: their noise is as small.
 * What narrow lobes show of lights is bright, however little they reflect. */
void path_thin_lobes(const struct path_context *c, struct path_packet *p, struct path_vertex *v)
{
    _Alignas(LANES_ALIGN) float chance[LANES], unused[LANES], stays[LANES];
    const struct layers *l = &v->layers;
    struct lanes_mask ended = {{0}};
    struct lanes3 *t = &p->throughput;
    if (!v->any_general || !l->any) return;
    c->kernels->path_pairs(p, PATH_VERTEX + PATH_ROULETTE, chance, unused);
    for (int i = 0; i < LANES; i++) stays[i] = 1.0f;
    for (uint32_t i = 0; i < p->count; i++) {
        if (!(v->active.on[i] & l->on.on[i])) continue;
        if (!path_leaves_to_fields(&v->surface, (int)i)) continue;
        stays[i] = lobe_chance(l, (int)i);
        if (!(stays[i] < 1.0f)) continue;
        ended.on[i] = chance[i] < stays[i] ? 0 : -1;
        if (ended.on[i]) continue;
        t->x[i] /= stays[i];
        t->y[i] /= stays[i];
        t->z[i] /= stays[i];
    }
    c->counters->value[COUNTER_SKIPPED_ROULETTE] += lanes_count(&ended);
    if (lanes_count(&ended) > 0) path_end_lanes(&ended, v);
    if (c->record) path_record_thin(c, p, v, stays[0]);
}
