#include "worker/scene/caustics.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "proto/plan.h"
#include "worker/scene/lamp_points.h"
#include "worker/scene/photon_flight.h"
#include "worker/scene/photon_targets.h"
#include "worker/scene/render_scene.h"
#include "worker/shade/direction.h"

/* Photons that leave the lamps, and the sky. */
#define PHOTONS 32768u

/* Fewer photons tell nothing. */
#define LEAST (4 * PHOTONS_IN_LEAF)

/* Photons go on this part of a target's radius beyond its surface. */
#define CLEARANCE 1e-4f

/* Of a sky only what is above so many times its mean is sent: paths find the rest. */
#define BRIGHT_TIMES 2.0f

/* Half of the paths are sent where photons bring this part of what could come without them. */
#define HALF_FLUX 0.5f

struct shooting {
    const struct render_scene *scene;
    const struct photon_targets *to;
    uint32_t random;
    struct photon *photons;
    uint32_t kept;
};

static float luminance(const float c[3])
{
    return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

/* Chooses one of the targets by weight. Returns its probability; 0: there is none. */
static float choose(struct shooting *s, const float weight[PHOTON_TARGETS_MAX], uint32_t *chosen)
{
    float sum = 0.0f, upto = 0.0f;
    for (uint32_t k = 0; k < s->to->count; k++) sum += weight[k];
    const float at = path_next(&s->random) * sum;
    *chosen = 0;
    for (uint32_t k = 0; k < s->to->count && upto <= at; k++) {
        upto += weight[k];
        *chosen = k;
    }
    return sum > 0.0f ? weight[*chosen] / sum : 0.0f;
}

static void send(struct shooting *s, struct photon_flight *f, const struct photon_target *to)
{
    struct photon *out = &s->photons[s->kept];
    f->to = to->instance;
    s->kept += photon_flight_follow(s->scene, f, CLEARANCE * to->radius, &s->random, out);
}

/* Returns ERR_MEMORY, and that there is nothing to shoot at as 0 without room for photons. */
static int begin(const struct render_scene *scene, struct shooting *s)
{
    *s = (struct shooting){.scene = scene, .to = scene->targets, .random = 1};
    if (!s->to) return 0;
    s->photons = malloc(PHOTONS * sizeof *s->photons);
    return s->photons ? 0 : ERR_MEMORY;
}

static int finish(struct shooting *s, struct photons **out)
{
    *out = NULL;
    if (s->kept < LEAST) {
        free(s->photons);
        return 0;
    }
    *out = photons_create(s->photons, s->kept);
    return *out ? 0 : ERR_MEMORY;
}

static float share_of(float flux, float other)
{
    return flux > 0.0f ? flux / (flux + HALF_FLUX * other) : 0.0f;
}

/* ---- the sky's ---- */

struct skylight {
    const struct environment *map;
    float cosine, sine, width, height, distance;
    float upto[ENVIRONMENT_BINS];
};

static uint32_t choose_bin(const struct skylight *sky, float u)
{
    uint32_t low = 0, high = ENVIRONMENT_BINS - 1;
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        if (u < sky->upto[middle])
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* Chooses where light comes from. Returns its luminance beyond what paths find, over its density.
 */
static float choose_sky(struct shooting *s, const struct skylight *sky, float d[3])
{
    const uint32_t bin = choose_bin(sky, path_next(&s->random));
    const float u[2] = {path_next(&s->random), path_next(&s->random)};
    const float share = (float)environment_bin_share(sky->map, bin);
    float on_map[3], radiance[3];
    if (!(share > 0.0f)) return 0.0f;
    const struct environment_texel t =
        environment_texel_of(sky->map, environment_choose(sky->map, bin, path_next(&s->random), u));
    if (!(t.density > 0.0f)) return 0.0f;
    environment_place(t, sky->width, u, on_map);
    environment_read(sky->map, environment_find(on_map, sky->width, sky->height), radiance);
    direction_set(sky->cosine * on_map[0] - sky->sine * on_map[2], on_map[1],
                  sky->sine * on_map[0] + sky->cosine * on_map[2], d);
    const float bright = luminance(radiance) - BRIGHT_TIMES * environment_mean(sky->map);
    return fmaxf(bright, 0.0f) / (share * t.density);
}

static void shoot_sky(struct shooting *s, const struct skylight *sky)
{
    float weight[PHOTON_TARGETS_MAX], d[3] = {0}, x[3], y[3], sine, cosine;
    struct photon_flight f = {.near = 0.0f};
    uint32_t chosen;
    for (uint32_t k = 0; k < s->to->count; k++)
        weight[k] = s->to->target[k].radius * s->to->target[k].radius;
    const float chance = choose(s, weight, &chosen);
    const struct photon_target *t = &s->to->target[chosen];
    f.power =
        choose_sky(s, sky, d) * ELEMENTARY_PI * t->radius * t->radius / (chance * (float)PHOTONS);
    const float out = t->radius * sqrtf(path_next(&s->random));
    elementary_sincos_turn(path_next(&s->random), &sine, &cosine);
    if (!(f.power > 0.0f) || !isfinite(f.power)) return;
    direction_frame(d, x, y);
    for (int k = 0; k < 3; k++) {
        f.at[k] = t->middle[k] + out * (cosine * x[k] + sine * y[k]) + sky->distance * d[k];
        f.way[k] = -d[k];
    }
    send(s, &f, t);
}

int caustics_of_sky(const struct render_scene *scene, const struct environment *map, float cosine,
                    float sine, struct photons **out)
{
    struct shooting s;
    struct skylight sky = {.map = map, .cosine = cosine, .sine = sine};
    struct RTCBounds b;
    float sum = 0.0f;
    *out = NULL;
    int error = begin(scene, &s);
    if (error || !s.photons) return error;
    environment_size(map, &sky.width, &sky.height);
    rtcGetSceneBounds(scene->top, &b);
    sky.distance = 2.0f * (fabsf(b.upper_x - b.lower_x) + fabsf(b.upper_y - b.lower_y) +
                           fabsf(b.upper_z - b.lower_z));
    for (uint32_t k = 0; k < ENVIRONMENT_BINS; k++)
        sky.upto[k] = sum += (float)environment_bin_share(map, k);
    for (uint32_t i = 0; i < PHOTONS && sum > 0.0f; i++) shoot_sky(&s, &sky);
    error = finish(&s, out);
    for (uint32_t i = 0; *out && i < (*out)->leaf_count; i++)
        (*out)->leaves[i].share =
            share_of((*out)->leaves[i].flux, ELEMENTARY_PI * environment_mean(map));
    return error;
}

/* ---- the lamps' ---- */

/* All that shines: what bounds each source, and their power up to and with each. */
struct lamps {
    struct lamp_source *sources;
    struct emitter_groups *bounds; /* one a source */
    float *upto;
    uint32_t count;
    float power;
};

static void add_lamp(struct lamps *l, const struct lamp_source *source)
{
    l->sources[l->count] = *source;
    l->upto[l->count] = l->power += l->bounds[l->count].power[0];
    l->count++;
}

static void take_group(const struct emitter_groups *g, uint32_t k, struct emitter_groups *out)
{
    out->power[0] = g->power[k];
    out->x[0] = g->x[k];
    out->y[0] = g->y[k];
    out->z[0] = g->z[k];
    out->radius[0] = g->radius[k];
}

static void find_lamps(const struct render_scene *scene, struct lamps *l)
{
    const struct emitter_tree *t = emitters_tree(scene->emitters);
    for (uint32_t i = 0; t && i < t->root_groups; i++) {
        const struct emitter_groups *g = &t->nodes[i / EMITTER_GROUPS].groups;
        const uint32_t k = i % EMITTER_GROUPS;
        take_group(g, k, &l->bounds[l->count]);
        add_lamp(l, &(struct lamp_source){scene->emitters, g->below[k], NULL});
    }
    for (uint64_t i = 0; i < scene->blob->count[SCENE_LIGHTS]; i++) {
        const struct scene_light *light = &scene->blob->lights[i];
        if (light->type != LIGHT_RECTANGLE) continue;
        lamp_bound(light, &l->bounds[l->count]);
        add_lamp(l, &(struct lamp_source){.rectangle = light});
    }
}

static int lamps_init(const struct render_scene *scene, struct lamps *l)
{
    const struct emitter_tree *t = emitters_tree(scene->emitters);
    const size_t most = (t ? t->root_groups : 0) + (size_t)scene->blob->count[SCENE_LIGHTS];
    *l = (struct lamps){.count = 0};
    if (most == 0) return 0;
    l->sources = malloc(most * sizeof *l->sources);
    l->bounds = aligned_alloc(_Alignof(struct emitter_groups), most * sizeof *l->bounds);
    l->upto = malloc(most * sizeof *l->upto);
    if (!l->sources || !l->bounds || !l->upto) return ERR_MEMORY;
    find_lamps(scene, l);
    return 0;
}

static void lamps_fini(struct lamps *l)
{
    free(l->sources);
    free(l->bounds);
    free(l->upto);
}

/* Samples a direction from a point to a sphere. Returns the solid angle of all. */
static float aim(struct shooting *s, const float from[3], const struct photon_target *t, float d[3])
{
    float axis[3], x[3], y[3], sine, cosine;
    const float distance = direction_normalize(t->middle[0] - from[0], t->middle[1] - from[1],
                                               t->middle[2] - from[2], axis);
    const float ratio = t->radius / fmaxf(distance, t->radius);
    const float height = ratio * ratio / (1.0f + sqrtf(1.0f - ratio * ratio));
    const float down = path_next(&s->random) * height,
                out = sqrtf(fmaxf(down * (2.0f - down), 0.0f));
    elementary_sincos_turn(path_next(&s->random), &sine, &cosine);
    if (!(distance > 0.0f)) axis[2] = 1.0f;
    direction_frame(axis, x, y);
    for (int k = 0; k < 3; k++)
        d[k] = out * (cosine * x[k] + sine * y[k]) + (1.0f - down) * axis[k];
    return 2.0f * ELEMENTARY_PI * height;
}

static void shoot_lamp(struct shooting *s, const struct lamps *l)
{
    float weight[PHOTON_TARGETS_MAX];
    const float at = path_next(&s->random) * l->power;
    struct emitter_point p;
    struct photon_flight f = {.near = 0.0f};
    uint32_t k = 0, chosen;
    while (k + 1 < l->count && at >= l->upto[k]) k++;
    lamp_sample(&l->sources[k], &s->random, &p);
    for (uint32_t i = 0; i < s->to->count; i++) {
        const struct photon_target *t = &s->to->target[i];
        float squared = 0.0f;
        for (int j = 0; j < 3; j++)
            squared += (t->middle[j] - p.position[j]) * (t->middle[j] - p.position[j]);
        weight[i] = t->radius * t->radius / fmaxf(squared, t->radius * t->radius);
    }
    const float chance = choose(s, weight, &chosen);
    const float angle = aim(s, p.position, &s->to->target[chosen], f.way);
    const float along = direction_dot(f.way, p.normal);
    const float cosine = p.double_sided ? fabsf(along) : along;
    if (!(cosine > 0.0f) || !(chance > 0.0f)) return;
    f.power = l->power * cosine * angle / (chance * (float)PHOTONS);
    memcpy(f.at, p.position, sizeof f.at);
    f.near = p.offset;
    send(s, &f, &s->to->target[chosen]);
}

/* Returns what all lamps would send to a place at most, were nothing in between. */
static float lit_by(const struct lamps *l, const struct photon_leaf *leaf)
{
    float sum = 0.0f;
    for (uint32_t i = 0; i < l->count; i++) {
        const struct emitter_groups *b = &l->bounds[i];
        const float x = b->x[0] - leaf->low[0], y = b->y[0] - leaf->low[1];
        const float z = b->z[0] - leaf->low[2], r = b->radius[0];
        sum += 0.5f * b->power[0] / fmaxf(x * x + y * y + z * z + r * r, 1e-30f);
    }
    return sum;
}

static int shoot_lamps(const struct render_scene *scene, const struct lamps *lamps,
                       struct photons **out)
{
    struct shooting s;
    int error = begin(scene, &s);
    if (error || !s.photons) return error;
    for (uint32_t i = 0; i < PHOTONS; i++) shoot_lamp(&s, lamps);
    error = finish(&s, out);
    for (uint32_t i = 0; *out && i < (*out)->leaf_count; i++)
        (*out)->leaves[i].share =
            share_of((*out)->leaves[i].flux, lit_by(lamps, &(*out)->leaves[i]));
    return error;
}

int caustics_of_lamps(const struct render_scene *scene, struct photons **out)
{
    struct lamps lamps;
    *out = NULL;
    if (!scene->targets) return 0;
    int error = lamps_init(scene, &lamps);
    if (!error && lamps.power > 0.0f && isfinite(lamps.power))
        error = shoot_lamps(scene, &lamps, out);
    lamps_fini(&lamps);
    return error;
}
