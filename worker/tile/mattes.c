#include "worker/tile/mattes.h"

#include <string.h>

#include "proto/half.h"
#include "proto/scene/matte.h"
#include "worker/trace/path/path_kernels.h"

_Static_assert(1u << MATTE_BLUR_DIGITS <= MATTE_SAMPLES_MAX, "room for all samples");

/* A name's share of a pixel. */
struct share {
    uint32_t id, count;
};

void matte_scratch_init(struct matte_scratch *s)
{
    memset(s, 0, sizeof *s);
    path_pool_init(&s->pool);
}

static void note(struct matte_list *l, uint32_t instance)
{
    uint32_t k = 0;
    while (k < l->kinds && l->instance[k] != instance) k++;
    if (k == l->kinds) {
        l->instance[l->kinds] = instance;
        l->count[l->kinds++] = 0;
    }
    l->count[k]++;
    l->samples++;
}

/* Traces the packet's rays to what the camera sees. */
static void see(const struct path_context *c, struct path_packet *p, struct matte_list *of)
{
    struct lanes_mask valid;
    const struct RTCHit16 *hit = &p->rays.hit;
    path_packet_lanes(p, &valid);
    if (c->blended) c->kernels->ray_keys(p, 0, PATH_RAY_NEXT, &p->rays.ray);
    queries_sanitise(c->queries, &valid, &p->rays.ray);
    c->counters->value[COUNTER_RAYS_PRIMARY] += lanes_count(&valid);
    queries_closest(c->queries, QUERY_CAMERA, &valid, &p->rays);
    for (uint32_t i = 0; i < p->count; i++) {
        const bool met = valid.on[i] && hit->geomID[i] != RTC_INVALID_GEOMETRY_ID;
        const uint32_t placed = hit->instID[0][i];
        const uint32_t instance = placed != RTC_INVALID_GEOMETRY_ID ? placed : hit->geomID[i];
        note(&of[p->slot[i] % LANES], met ? instance : SCENE_NONE);
    }
}

static void trace(const struct path_context *c, const struct block *b, uint32_t first, uint32_t end,
                  struct matte_scratch *s)
{
    for (; first < end; first += PATH_SAMPLES) {
        path_camera(c, b, first, PATH_SAMPLES, &s->pool);
        for (uint32_t k = 0; k < path_pool_packets(&s->pool); k++)
            see(c, &s->pool.packets[k], s->of);
    }
}

/* Adds instances of one name up. Returns how many names there are. */
static uint32_t add_names(const struct scene *scene, enum matte_kind kind,
                          const struct matte_list *l, struct share out[MATTE_SAMPLES_MAX])
{
    uint32_t names = 0;
    char room[32];
    for (uint32_t k = 0; k < l->kinds; k++) {
        if (l->instance[k] == SCENE_NONE) continue;
        const uint32_t id = matte_id(matte_name(scene, kind, l->instance[k], room));
        uint32_t n = 0;
        while (n < names && out[n].id != id) n++;
        if (n == names) out[names++] = (struct share){id, 0};
        out[n].count += l->count[k];
    }
    return names;
}

static bool is_before(struct share a, struct share b)
{
    return a.count != b.count ? a.count > b.count : a.id < b.id;
}

/* Moves the largest shares to the front, in their order. */
static void rank(struct share *all, uint32_t count)
{
    for (uint32_t r = 0; r < MATTE_RANKS && r < count; r++) {
        uint32_t best = r;
        for (uint32_t k = r + 1; k < count; k++)
            if (is_before(all[k], all[best])) best = k;
        const struct share first = all[best];
        all[best] = all[r];
        all[r] = first;
    }
}

static void store(const struct scene *scene, enum matte_kind kind, const struct matte_list *l,
                  uint32_t element, struct samples *samples)
{
    const uint32_t ids = kind == MATTE_OBJECT ? PLANE_MATTE_OBJECTS : PLANE_MATTE_MATERIALS;
    const uint32_t shares =
        kind == MATTE_OBJECT ? PLANE_MATTE_OBJECT_SHARES : PLANE_MATTE_MATERIAL_SHARES;
    struct share all[MATTE_SAMPLES_MAX];
    if (!samples_u32(samples, ids, 0)) return;
    const uint32_t count = add_names(scene, kind, l, all);
    rank(all, count);
    for (uint32_t r = 0; r < MATTE_RANKS && r < count; r++) {
        const float share = (float)all[r].count / (float)l->samples; /* which is not 0 */
        samples_u32(samples, ids, r)[element] = all[r].id;
        half_from_floats(&share, samples_u16(samples, shares, r) + element, 1);
    }
}

void mattes_trace(const struct path_context *paths, const struct block *b, struct matte_scratch *s,
                  struct samples *samples)
{
    const struct plan *plan = paths->plan;
    const bool blurred = plan_has_shutter(plan) || plan->camera.aperture_radius > 0.0f;
    const struct scene *scene = paths->queries->scene->blob;
    struct path_context c = *paths;
    struct block mixed = *b;
    c.seen_only = true;
    c.edge_digits = blurred ? MATTE_BLUR_DIGITS : MATTE_DIGITS;
    for (int i = 0; i < LANES; i++) s->of[i].kinds = s->of[i].samples = 0;
    trace(&c, b, 0, 1u << MATTE_FIRST_DIGITS, s);
    for (int i = 0; i < LANES; i++)
        if (s->of[i].kinds < 2) mixed.kept.on[i] = 0;
    if (lanes_count(&mixed.kept) > 0)
        trace(&c, &mixed, 1u << MATTE_FIRST_DIGITS, 1u << c.edge_digits, s);
    for (int i = 0; i < LANES; i++)
        for (int kind = 0; b->kept.on[i] && kind < MATTE_KINDS; kind++)
            store(scene, (enum matte_kind)kind, &s->of[i], b->element[i], samples);
}
