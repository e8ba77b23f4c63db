/* The job document of a case. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "tests/property/sky.h"
#include "tests/property/stage.h"

static json_t *vector(const double v[3], double scale)
{
    return json_pack("[f, f, f]", v[0] * scale, v[1] * scale, v[2] * scale);
}

static json_t *point(const struct change *change, const double v[3])
{
    double at[3];
    stage_place(change, v, at);
    return vector(at, 1);
}

static json_t *direction(const struct change *change, const double v[3], double scale)
{
    double turned[3];
    stage_turn(change, v, turned);
    return vector(turned, scale);
}

static json_t *rectangle(const struct case_light *l, const struct change *change)
{
    double u[3], v[3];
    stage_frame(l->facing, u, v);
    /* Mirrored, u x v would point to the other side. */
    const double *first = change->mirrored ? v : u, *second = change->mirrored ? u : v;
    const double a = l->half[change->mirrored], b = l->half[!change->mirrored],
                 scale = stage_scale(change);
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:s}", "type", "rectangle", "center",
                     point(change, l->centre), "half_u", direction(change, first, a * scale),
                     "half_v", direction(change, second, b * scale), "radiance",
                     vector(l->level, stage_gain(change)), "profile",
                     l->kind == CASE_GAUSSIAN ? "gaussian" : "uniform");
}

static json_t *light_of(const struct case_light *l, const struct change *change)
{
    const double scale = stage_scale(change), gain = stage_gain(change);
    double towards[3] = {0, 0, 0};
    towards[l->facing % 3] = l->facing < 3 ? 1 : -1;
    switch (l->kind) {
    case CASE_POINT:
        return json_pack("{s:s, s:o, s:o}", "type", "point", "position", point(change, l->centre),
                         "intensity", vector(l->level, gain * scale * scale));
    case CASE_SPOT:
        return json_pack("{s:s, s:o, s:o, s:o, s:f, s:f}", "type", "spot", "position",
                         point(change, l->centre), "direction", direction(change, towards, 1),
                         "intensity", vector(l->level, gain * scale * scale), "inner_deg", 20.0,
                         "outer_deg", 50.0);
    case CASE_SUN:
        return json_pack("{s:s, s:o, s:o}", "type", "directional", "direction",
                         direction(change, towards, 1), "irradiance", vector(l->level, gain));
    default:
        return rectangle(l, change);
    }
}

static json_t *lights_of(const struct property_case *c, const struct change *change)
{
    json_t *lights = json_array();
    for (int i = 0; i < c->light_count; i++)
        if (!(change->lights >> i & 1))
            json_array_append_new(lights, light_of(&c->lights[i], change));
    return lights;
}

static json_t *effects_of(const struct property_case *c, const struct change *change)
{
    json_t *effects = json_pack("{s:i}", "indirect_bounces", c->bounces);
    if (c->occlusion > 0)
        json_object_set_new(effects, "ambient_occlusion",
                            json_pack("{s:f}", "distance", c->occlusion * stage_scale(change)));
    return effects;
}

static json_t *layers_of(const struct property_case *c, const struct change *change)
{
    static const char *const names[] = {PICTURE_LAYERS};
    json_t *layers = json_array();
    for (size_t i = 0; i < (c->layers ? sizeof names / sizeof names[0] : 1); i++)
        json_array_append_new(layers, json_string(names[i]));
    if (c->occlusion > 0) json_array_append_new(layers, json_string("occlusion"));
    if (change->layer && !(c->occlusion > 0 && !strcmp(change->layer, "occlusion")))
        json_array_append_new(layers, json_string(change->layer));
    return layers;
}

#define ASSET "0000000000000000000000000000000000000000000000000000000000000001"

static json_t *camera_of(const struct property_case *c, const struct change *change)
{
    double up[3];
    stage_turn(change, (double[]){0, 1, 0}, up);
    if (c->orthographic) return json_integer(0); /* the scene's own */
    return json_pack("{s:o, s:o, s:o, s:f}", "eye", point(change, c->eye), "target",
                     point(change, c->target), "up", vector(up, 1), "yfov_deg", c->yfov_deg);
}

static json_t *scene_of(const struct property_case *c, const struct change *change)
{
    return json_pack("{s:s, s:b, s:o}", "asset", ASSET, "lights", 0, "camera",
                     camera_of(c, change));
}

/* NULL: none. */
static json_t *environment_of(const struct property_case *c, const struct change *change)
{
    if (sky_has_map(c, change))
        return json_pack("{s:s, s:f, s:f}", "asset", ASSET, "intensity", stage_gain(change),
                         "rotation_deg", sky_rotation_deg(change));
    const double *e = c->environment;
    if (change->no_environment || !(e[0] > 0 || e[1] > 0 || e[2] > 0)) return NULL;
    return json_pack("{s:o}", "radiance", vector(e, stage_gain(change)));
}

/* Under a target paths make the picture, but for what light fields bring beside them. */
static const char *method_name(const struct property_case *c, const struct change *change)
{
    if (change->one_round && c->error > 0) return "none";
    return change->unfiltered ? "average" : case_methods[c->method];
}

static const char *filter_name(const struct change *change, const char *const *names, int number)
{
    return change->unfiltered ? "average" : names[number];
}

/* Averages have neither a residual filter nor one of the sky; nor has what further rounds are
 * compared with. */
static void set_division(const struct property_case *c, const struct change *change, json_t *job)
{
    json_t *sampling = json_object_get(job, "sampling"), *filter = json_object_get(job, "filter");
    const bool averaged = change->unfiltered || change->one_round;
    if (c->residual)
        json_object_set_new(filter, "residual",
                            json_string(averaged ? "none" : case_residuals[c->residual]));
    if (c->environment_filter)
        json_object_set_new(
            filter, "environment",
            json_string(averaged ? "average" : case_environments[c->environment_filter]));
    if (c->halved && !averaged) json_object_set_new(sampling, "field_scale", json_real(0.5));
}

/* What further samples are dealt by. */
static void set_rounds(const struct property_case *c, const struct change *change, json_t *job)
{
    json_t *sampling = json_object_get(job, "sampling"), *filter = json_object_get(job, "filter");
    if (c->mu > 0) json_object_set_new(filter, "mu", json_real(c->mu));
    if (c->indirect == CASE_ADAPTIVE && c->most > 0)
        json_object_set_new(sampling, "indirect_spp", json_integer(c->most));
    if (change->one_round) return;
    if (c->error > 0) json_object_set_new(sampling, "target_error", json_real(c->error));
    if (c->error > 0 && c->most > 0)
        json_object_set_new(sampling, "max_spp", json_integer(c->most));
    if (c->lens_second_set > 0)
        json_object_set_new(sampling, "lens_extra", json_integer(c->lens_second_set));
}

/* Averages are what tells whether adaptive sampling is right. */
static const char *indirect_name(const struct property_case *c, const struct change *change)
{
    const bool averaged = change->one_round && c->indirect == CASE_ADAPTIVE;
    return averaged ? "average" : filter_name(change, case_indirects, c->indirect);
}

char *stage_job(const struct property_case *c, const struct change *change)
{
    json_t *job = json_pack(
        "{s:o, s:{s:i, s:i}, s:o, s:o, s:{s:i, s:i, s:i}, s:{s:s, s:s, s:s, s:s}, s:o}", "scene",
        scene_of(c, change), "image", "width", c->width, "height", c->height, "lights",
        lights_of(c, change), "effects", effects_of(c, change), "sampling", "spp",
        change->spp ? change->spp : c->spp, "seed", (int)(change->seed ? change->seed : c->seed),
        "tile_px", c->tile, "filter", "method", method_name(c, change), "indirect",
        indirect_name(c, change), "glossy", filter_name(change, case_glossies, c->glossy), "lens",
        filter_name(change, case_lenses, c->lens_filter), "layers", layers_of(c, change));
    set_division(c, change, job);
    set_rounds(c, change, job);
    if (c->focus > 0)
        json_object_set_new(job, "lens",
                            json_pack("{s:f, s:f, s:i}", "aperture_radius",
                                      c->aperture * stage_scale(change), "focus_distance",
                                      c->focus * stage_scale(change), "blades", c->blades));
    json_t *environment = environment_of(c, change);
    if (environment) json_object_set_new(job, "environment", environment);
    if (c->tent)
        json_object_set_new(json_object_get(job, "image"), "pixel_filter", json_string("tent"));
    char *text = json_dumps(job, JSON_COMPACT);
    json_decref(job);
    if (!text) abort();
    return text;
}
