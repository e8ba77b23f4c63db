#include "worker/scene/glazing.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "proto/plan.h"
#include "worker/scene/lamp_points.h"
#include "worker/scene/render_scene.h"
#include "worker/shade/direction.h"
#include "worker/shade/lambert.h"

/* Rays from each group of emitters. */
#define RAYS 128u

/* Lamps of which a smaller share shines through glass are left to chance. */
#define SHARE_MIN 0.2f

/* Glass up to this many times as far from a lamp's middle as the lamp itself belongs to it: paths
 * are sent to all of it, since it may be frosted. Through other panes they aim at the lamp. */
#define BULB_TIMES 3.0f

/* Glass up to this roughness sends paths on nearly as they came. */
#define CLEAR_ROUGHNESS 0.1f

/* ---- rays through glass ---- */

/* The largest number of surfaces of glass that are noted along a ray. */
#define SURFACES 8u

/* What a ray has met of glass, of which some may lie beyond what stops it. */
struct met {
    uint32_t count; /* of all, which may be more than are noted */
    float distance[SURFACES];
    bool frosted[SURFACES]; /* it scatters what comes through */
};

/* Embree hands the context on to the filter. */
struct probe {
    struct RTCIntersectContext context;
    struct met *met;
    bool clear_only; /* frosted glass stops the ray */
};

enum { RAY_FAR = 8 }; /* of one ray: the fields of struct RTCRay in order */

static void pass_glass(const struct RTCFilterFunctionNArguments *args)
{
    const struct mesh_view *mesh = args->geometryUserPtr;
    const float *ray = (const float *)args->ray;
    const struct probe *probe = (const struct probe *)(const void *)args->context;
    const struct material *m = mesh->material;
    struct met *met = probe->met;
    if (m->emissive || (!m->transmissive && !m->translucent)) return; /* it shines itself */
    const bool frosted = m->translucent || m->roughness > CLEAR_ROUGHNESS;
    if (frosted && probe->clear_only) return;
    if (met->count < SURFACES) {
        met->distance[met->count] = ray[RAY_FAR];
        met->frosted[met->count] = frosted;
    }
    met->count++;
    args->valid[0] = 0;
}

static void begin(const struct render_scene *scene, struct met *met, struct probe *out)
{
    met->count = 0;
    *out = (struct probe){.met = met};
    rtcInitIntersectContext(&out->context);
    if (scene->has_glass) out->context.filter = pass_glass;
}

bool glazing_sees(const struct render_scene *scene, struct RTCRay *ray, bool *through)
{
    struct met met;
    struct probe probe;
    begin(scene, &met, &probe);
    probe.clear_only = true;
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
    float share, clear; /* of its rays that met glass, and clear glass alone */
    float reach;        /* how far from its middle they did */
    uint32_t random;
};

/* Samples a ray that leaves a lamp. */
static struct RTCRay leave(const struct lamp_source *source, uint32_t *random)
{
    const float turn[2] = {path_next(random), path_next(random)};
    struct emitter_point p;
    float t[3], b[3], d[3], way[3];
    lamp_sample(source, random, &p);
    const float side = p.double_sided && path_next(random) < 0.5f ? -1.0f : 1.0f;
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

static uint32_t noted(const struct met *met)
{
    return met->count < SURFACES ? met->count : SURFACES;
}

static float first_of(const struct met *met)
{
    float first = INFINITY;
    for (uint32_t i = 0; i < noted(met); i++) first = fminf(first, met->distance[i]);
    return first;
}

static bool is_clear(const struct met *met, float end)
{
    bool clear = true;
    for (uint32_t i = 0; i < noted(met); i++) clear &= !(met->frosted[i] && met->distance[i] < end);
    return clear;
}

/* Returns how far from the lamp's middle the glass around it ends, which the ray met first. */
static float reach_of(const struct emitter_groups *g, uint32_t k, const struct RTCRay *ray,
                      const struct met *met)
{
    const float most = fminf(2.0f * first_of(met) + g->radius[k], ray->tfar);
    float last = 0.0f;
    for (uint32_t i = 0; i < noted(met); i++)
        if (met->distance[i] <= most) last = fmaxf(last, met->distance[i]);
    const float x = ray->org_x + last * ray->dir_x - g->x[k];
    const float y = ray->org_y + last * ray->dir_y - g->y[k];
    const float z = ray->org_z + last * ray->dir_z - g->z[k];
    return sqrtf(x * x + y * y + z * z);
}

static struct lamp look(const struct render_scene *s, const struct lamp_source *source,
                        const struct emitter_groups *g, uint32_t k)
{
    struct lamp lamp = {.random = 1};
    for (uint32_t i = 0; i < RAYS; i++) {
        struct RTCRay ray = leave(source, &lamp.random);
        struct met met;
        trace(s, &ray, &met);
        const bool clear = is_clear(&met, ray.tfar);
        if (!(first_of(&met) < ray.tfar)) continue;
        lamp.share += 1.0f / (float)RAYS;
        lamp.clear += clear ? 1.0f / (float)RAYS : 0.0f;
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
    const bool is_bulb = lamp->reach <= BULB_TIMES * g->radius[k];
    const float share = is_bulb ? lamp->share : lamp->clear, power = share * g->power[k];
    const uint32_t at = place_for(lamps, power);
    if (share < SHARE_MIN || at == EMITTER_GROUPS) return;
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

static void learn_rectangles(const struct render_scene *scene, struct emitter_groups *lamps)
{
    for (uint64_t i = 0; i < scene->blob->count[SCENE_LIGHTS]; i++) {
        const struct lamp_source source = {.rectangle = &scene->blob->lights[i]};
        struct emitter_groups g;
        if (source.rectangle->type != LIGHT_RECTANGLE) continue;
        lamp_bound(source.rectangle, &g);
        const struct lamp lamp = look(scene, &source, &g, 0);
        keep(&g, 0, &lamp, lamps);
    }
}

static void learn_emitters(const struct render_scene *scene, struct emitter_groups *lamps)
{
    const struct emitter_tree *t = emitters_tree(scene->emitters);
    for (uint32_t i = 0; t && i < t->root_groups; i++) {
        const struct emitter_groups *g = &t->nodes[i / EMITTER_GROUPS].groups;
        const uint32_t k = i % EMITTER_GROUPS;
        const struct lamp lamp =
            look(scene, &(struct lamp_source){scene->emitters, g->below[k], NULL}, g, k);
        keep(g, k, &lamp, lamps);
    }
}

void glazing_learn(const struct render_scene *scene, struct glazing *out)
{
    memset(out, 0, sizeof *out);
    if (!scene->has_glass) return;
    learn_emitters(scene, &out->lamps);
    learn_rectangles(scene, &out->lamps);
}
