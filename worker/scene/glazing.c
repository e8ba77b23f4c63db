#include "worker/scene/glazing.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/scene/emitters.h"
#include "worker/scene/render_scene.h"
#include "worker/shade/direction.h"
#include "worker/shade/lambert.h"

/* Rays from each group of emitters. */
#define RAYS 128u

/* Lamps of which a smaller share shines through glass are left to chance. */
#define SHARE_MIN 0.05f

/* Glass up to this many times as far from a lamp's middle as the lamp itself belongs to it: paths
 * are sent to all of it, since it may be frosted. Through other panes they aim at the lamp. */
#define BULB_TIMES 3.0f

/* ---- rays through glass ---- */

/* The largest number of surfaces of glass that are noted along a ray. */
#define SURFACES 8u

/* What a ray has met of glass, of which some may lie beyond what stops it. */
struct met {
    uint32_t count; /* of all, which may be more than are noted */
    float distance[SURFACES];
};

/* Embree hands the context on to the filter. */
struct probe {
    struct RTCIntersectContext context;
    struct met *met;
};

enum { RAY_FAR = 8 }; /* of one ray: the fields of struct RTCRay in order */

static void pass_glass(const struct RTCFilterFunctionNArguments *args)
{
    const struct mesh_view *mesh = args->geometryUserPtr;
    const float *ray = (const float *)args->ray;
    struct met *met = ((struct probe *)(void *)args->context)->met;
    if (!mesh->material->transmissive && !mesh->material->translucent) return;
    if (met->count < SURFACES) met->distance[met->count] = ray[RAY_FAR];
    met->count++;
    args->valid[0] = 0;
}

static void begin(const struct render_scene *scene, struct met *met, struct probe *out)
{
    met->count = 0;
    out->met = met;
    rtcInitIntersectContext(&out->context);
    if (scene->has_glass) out->context.filter = pass_glass;
}

bool glazing_sees(const struct render_scene *scene, struct RTCRay *ray, bool *through)
{
    struct met met;
    struct probe probe;
    begin(scene, &met, &probe);
    rtcOccluded1(scene->top, &probe.context, ray);
    *through = met.count > 0;
    return ray->tfar > 0.0f;
}

static void trace(const struct render_scene *scene, struct RTCRay *ray, struct met *met)
{
    struct probe probe;
    struct RTCRayHit hit = {.ray = *ray};
    begin(scene, met, &probe);
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene->top, &probe.context, &hit);
    ray->tfar = hit.ray.tfar;
}

/* ---- lamps ---- */

struct lamp {
    float share, reach; /* of its rays that met glass, and how far from its middle they did */
    uint32_t random;
};

static float next_random(uint32_t *state)
{
    *state += 0x9e3779b9u;
    return (float)(path_mix(*state) >> 8) * 0x1p-24f;
}

/* Walks down from a group by the power of what is below. Returns a leaf. */
static uint32_t descend(const struct emitter_tree *t, uint32_t at, uint32_t *random)
{
    while (!(at & EMITTER_LEAF)) {
        const struct emitter_groups *g = &t->nodes[at].groups;
        float sum = 0.0f, upto = 0.0f;
        uint32_t taken = 0;
        for (uint32_t k = 0; k < g->count; k++) sum += g->power[k];
        const float target = next_random(random) * sum;
        for (uint32_t k = 0; k < g->count && upto <= target; k++) {
            upto += g->power[k];
            taken = k;
        }
        at = g->below[taken];
    }
    return at & ~EMITTER_LEAF;
}

/* Samples a ray that leaves a group. */
static struct RTCRay leave(const struct emitters *e, uint32_t below, uint32_t *random)
{
    const uint32_t leaf = descend(emitters_tree(e), below, random);
    const float choice = next_random(random);
    const float u[2] = {next_random(random), next_random(random)};
    const float turn[2] = {next_random(random), next_random(random)};
    struct emitter_point p;
    float t[3], b[3], d[3], way[3];
    emitters_sample(e, leaf, emitters_choose(e, leaf, choice, u), u, &p);
    const float side = p.double_sided && next_random(random) < 0.5f ? -1.0f : 1.0f;
    for (int k = 0; k < 3; k++) p.normal[k] *= side;
    direction_frame(p.normal, t, b);
    lambert_direction(turn[0], turn[1], &d[0], &d[1], &d[2]);
    for (int k = 0; k < 3; k++) way[k] = d[0] * t[k] + d[1] * b[k] + d[2] * p.normal[k];
    return (struct RTCRay){.org_x = p.position[0],
                           .org_y = p.position[1],
                           .org_z = p.position[2],
                           .dir_x = way[0],
                           .dir_y = way[1],
                           .dir_z = way[2],
                           .tnear = p.offset,
                           .tfar = INFINITY,
                           .mask = UINT32_MAX};
}

/* Returns how far from the lamp's middle the glass around it ends, which the ray met first. */
static float reach_of(const struct emitter_groups *g, uint32_t k, const struct RTCRay *ray,
                      const struct met *met)
{
    const uint32_t noted = met->count < SURFACES ? met->count : SURFACES;
    float first = INFINITY, last = 0.0f;
    for (uint32_t i = 0; i < noted; i++) first = fminf(first, met->distance[i]);
    const float most = fminf(2.0f * first + g->radius[k], ray->tfar);
    for (uint32_t i = 0; i < noted; i++)
        if (met->distance[i] <= most) last = fmaxf(last, met->distance[i]);
    const float x = ray->org_x + last * ray->dir_x - g->x[k];
    const float y = ray->org_y + last * ray->dir_y - g->y[k];
    const float z = ray->org_z + last * ray->dir_z - g->z[k];
    return sqrtf(x * x + y * y + z * z);
}

static struct lamp look(const struct render_scene *s, const struct emitter_groups *g, uint32_t k,
                        uint32_t number)
{
    struct lamp lamp = {.random = path_mix(number + 1)};
    for (uint32_t i = 0; i < RAYS; i++) {
        struct RTCRay ray = leave(s->emitters, g->below[k], &lamp.random);
        struct met met;
        float first = INFINITY;
        trace(s, &ray, &met);
        for (uint32_t j = 0; j < met.count && j < SURFACES; j++)
            first = fminf(first, met.distance[j]);
        if (!(first < ray.tfar)) continue;
        lamp.share += 1.0f / (float)RAYS;
        lamp.reach = fmaxf(lamp.reach, reach_of(g, k, &ray, &met));
    }
    return lamp;
}

/* Returns the place of a new lamp; where all are taken, that of the faintest, if it is fainter. */
static uint32_t place_for(const struct emitter_groups *lamps, float power)
{
    uint32_t faintest = 0;
    if (lamps->count < EMITTER_GROUPS) return lamps->count;
    for (uint32_t k = 1; k < EMITTER_GROUPS; k++)
        if (lamps->power[k] < lamps->power[faintest]) faintest = k;
    return lamps->power[faintest] < power ? faintest : EMITTER_GROUPS;
}

static void keep(const struct emitter_groups *g, uint32_t k, const struct lamp *lamp,
                 struct emitter_groups *lamps)
{
    const float power = lamp->share * g->power[k];
    const uint32_t at = place_for(lamps, power);
    const bool is_bulb = lamp->reach <= BULB_TIMES * g->radius[k];
    if (at == EMITTER_GROUPS) return;
    if (at == lamps->count) lamps->count++;
    lamps->power[at] = power;
    lamps->x[at] = g->x[k];
    lamps->y[at] = g->y[k];
    lamps->z[at] = g->z[k];
    lamps->radius[at] = is_bulb ? fmaxf(lamp->reach, g->radius[k]) : g->radius[k];
    lamps->axis_x[at] = g->axis_x[k];
    lamps->axis_y[at] = g->axis_y[k];
    lamps->axis_z[at] = g->axis_z[k];
    lamps->cosine[at] = is_bulb ? -1.0f : g->cosine[k];
    lamps->sine[at] = is_bulb ? 0.0f : g->sine[k];
}

void glazing_learn(const struct render_scene *scene, struct glazing *out)
{
    const struct emitter_tree *t = emitters_tree(scene->emitters);
    memset(out, 0, sizeof *out);
    for (uint32_t i = 0; t && scene->has_glass && i < t->root_groups; i++) {
        const struct emitter_groups *g = &t->nodes[i / EMITTER_GROUPS].groups;
        const struct lamp lamp = look(scene, g, i % EMITTER_GROUPS, i);
        if (lamp.share >= SHARE_MIN) keep(g, i % EMITTER_GROUPS, &lamp, &out->lamps);
    }
}
