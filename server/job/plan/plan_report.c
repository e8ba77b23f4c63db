/* Writes the plan as people read it. */
#include <math.h>
#include <string.h>

#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

static const char *const effect_names[EFFECT_COUNT] = {
    "primary",     "antialias", "direct",    "shadows",  "indirect",   "emission",
    "environment", "lens",      "occlusion", "emitters", "motion_blur"};
static const char *const integrator_names[] = {
    [INTEGRATOR_LIGHT_FIELD] = "light_field",
    [INTEGRATOR_PATHS] = "paths",
    [INTEGRATOR_PATHS_AND_LIGHT_FIELD] = "paths_and_light_field",
    [INTEGRATOR_LENS_FIELD] = "lens_field",
};
static const char *const light_type_names[] = {"point", "spot", "directional", "rectangle"};

static json_t *names_of(uint64_t bits, const char *(*name)(uint32_t bit))
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < 64; i++)
        if (bits >> i & 1u) json_array_append_new(list, json_string(name(i)));
    return list;
}

static const char *effect_of(uint32_t bit)
{
    return effect_names[bit];
}

/* Returns the name of a plane, or of a list beside them. */
static const char *plane_of(uint32_t bit)
{
    if (bit == PLANE_MIXED) return "mixed";
    return bit == PLANE_LONE ? "lone" : samples_plane(bit)->name;
}

static const char *light_plane_of(uint32_t bit)
{
    return samples_plane(samples_light_slot(0, bit))->name;
}

static const char *layer_of(uint32_t bit)
{
    return layer_name((enum layer)(1u << bit));
}

static json_t *skips_of(const struct plan_report *report)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < report->skip_count; i++)
        json_array_append_new(list, json_pack("{s:s,s:s}", "what", report->skipped[i].what, "why",
                                              report->skipped[i].why));
    return list;
}

static json_t *warnings_of(const struct plan_report *report)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < report->warning_count; i++)
        json_array_append_new(list, json_string(report->warnings[i]));
    return list;
}

static json_t *lights_of(const struct plan *plan, const struct plan_report *report)
{
    json_t *list = json_array();
    for (uint32_t k = 0; k < plan->light_count; k++) {
        const struct plan_light *light = &plan->lights[k];
        json_t *line = json_pack("{s:s,s:s,s:i,s:f,s:i}", "type", light_type_names[light->type],
                                 "from", report->lights[k].of_scene ? "scene" : "job", "index",
                                 (int)report->lights[k].index, "power", (double)light->power,
                                 "samples", (int)(light->strata_per_axis * light->strata_per_axis));
        /* A name that was cut inside a character is no UTF-8 and is left out. */
        json_t *name = report->lights[k].name[0] ? json_string(report->lights[k].name) : NULL;
        if (name) json_object_set_new(line, "name", name);
        json_array_append_new(list, line);
    }
    return list;
}

static json_t *vector_of(const float v[3])
{
    return json_pack("[f,f,f]", (double)v[0], (double)v[1], (double)v[2]);
}

/* In the scene's coordinates; without an origin to its last bit. */
static json_t *position_of(const float v[3], const double origin[3])
{
    return json_pack("[f,f,f]", origin[0] + (double)v[0], origin[1] + (double)v[1],
                     origin[2] + (double)v[2]);
}

static json_t *camera_of(const struct plan *plan, const struct plan_report *report)
{
    const struct plan_camera *c = &plan->camera;
    bool perspective = c->type == CAMERA_PERSPECTIVE;
    json_t *camera =
        json_pack("{s:s,s:o,s:o,s:o,s:b}", "type", perspective ? "perspective" : "orthographic",
                  "eye", position_of(c->eye, report->origin), "forward", vector_of(c->forward),
                  "up", vector_of(c->up), "made_by_importer", (int)report->camera_is_default);
    if (perspective)
        json_object_set_new(camera, "yfov_deg",
                            json_real(360 / M_PI * atan((double)c->half_height)));
    else
        json_object_set_new(camera, "half_height", json_real((double)c->half_height));
    if (c->aperture_radius > 0) {
        json_object_set_new(camera, "aperture_radius", json_real((double)c->aperture_radius));
        json_object_set_new(camera, "focus_distance", json_real((double)c->focus_distance));
        json_object_set_new(camera, "blades", json_integer(c->blade_count));
    }
    json_t *name = report->camera_name[0] ? json_string(report->camera_name) : NULL;
    if (name) json_object_set_new(camera, "name", name);
    return camera;
}

/* Writes the cameras by index; "" for one whose name is too long for a list. */
static json_t *cameras_of(const struct plan_report *report)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < report->camera_count; i++) {
        bool whole = strlen(report->cameras[i]) < sizeof report->cameras[0] - 1;
        json_t *name = whole ? json_string(report->cameras[i]) : NULL;
        json_array_append_new(list, name ? name : json_string(""));
    }
    return list;
}

static json_t *samples_of(const struct plan *plan)
{
    uint64_t light = 0;
    for (uint32_t k = 0; k < plan->light_count; k++)
        light += (uint64_t)plan->lights[k].strata_per_axis * plan->lights[k].strata_per_axis;
    uint64_t indirect = (uint64_t)plan->indirect_strata_per_axis * plan->indirect_strata_per_axis;
    const uint64_t lens = (uint64_t)plan->lens_strata_per_axis * plan->lens_strata_per_axis;
    const bool centres =
        plan->planes & ~(PLANES_PATH_ALL | PLANES_LENS_ALL | PLANES_LENS_SECOND_SET | PLANES_MATTE);
    json_t *samples = NULL;
    if (lens > 0)
        samples = json_pack("{s:i,s:i,s:I,s:I,s:I}", "primary", centres ? 1 : 0, "antialias", 0,
                            "light", plan->light_planes ? (json_int_t)light : 0, "indirect",
                            (json_int_t)indirect, "lens", (json_int_t)lens);
    else if (plan->paths.spp == 0)
        samples = json_pack("{s:i,s:i,s:I,s:I}", "primary", 1, "antialias", (int)plan->sub_samples,
                            "light", (json_int_t)light, "indirect", (json_int_t)indirect);
    else
        samples =
            json_pack("{s:i,s:i,s:I,s:I,s:I,s:I}", "primary", centres ? 1 : 0, "antialias",
                      (int)plan->sub_samples, "light", plan->light_planes ? (json_int_t)light : 0,
                      "indirect", (json_int_t)indirect, "paths", (json_int_t)plan->paths.spp,
                      "passes", (json_int_t)plan_pass_count(plan));
    if (samples && plan->paths.edge_digits > 0)
        json_object_set_new(samples, "paths_at_edges",
                            json_integer((json_int_t)plan->paths.spp << plan->paths.edge_digits));
    if (samples && plan->field_halved) json_object_set_new(samples, "field_scale", json_real(0.5));
    if (samples && plan->lens_extra > 0)
        json_object_set_new(samples, "lens_extra", json_integer(plan->lens_extra));
    if (samples && plan->adaptive.rays_max > 0)
        json_object_set_new(samples, "indirect_most", json_integer(plan->adaptive.rays_max));
    return samples;
}

static json_t *environment_of(const struct plan *plan, const struct plan_report *report)
{
    char map[DIGEST_HEX_BYTES];
    const struct plan_environment *e = &plan->environment;
    if (e->kind == ENVIRONMENT_NONE) return json_null();
    bool is_map = e->kind == ENVIRONMENT_MAP;
    json_t *environment = json_pack("{s:s,s:f}", "type",
                                    report->studio_light      ? "studio"
                                    : report->estimated_light ? "estimate"
                                    : is_map                  ? "map"
                                                              : "constant",
                                    "power", (double)e->power);
    if (is_map) {
        digest_to_hex(&e->map, map);
        json_object_set_new(environment, "map", json_string(map));
        json_object_set_new(environment, "intensity", json_real((double)e->radiance[0]));
    } else {
        json_object_set_new(environment, "radiance", vector_of(e->radiance));
    }
    return environment;
}

static json_t *emitters_of(const struct plan *plan, const struct plan_report *report)
{
    if (!(report->emitters.flux > 0)) return json_null();
    return json_pack("{s:I,s:f}", "instances", (json_int_t)report->emitters.instances, "power",
                     (double)plan->paths.emitter_power);
}

static json_t *tiles_of(const struct plan *plan)
{
    struct tile_grid grid;
    if (tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px) != 0)
        return json_null();
    return json_pack("{s:i,s:I}", "side_px", plan->tile_px, "count",
                     (json_int_t)tile_grid_count(&grid));
}

json_t *plan_report_json(const struct plan *plan, const struct plan_report *report)
{
    char scene[DIGEST_HEX_BYTES];
    digest_to_hex(&plan->scene, scene);
    return json_pack(
        "{s:s,s:o,s:o,s:o,s:o,s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:o,s:o,s:o,s:o,s:o,"
        "s:o,s:o,"
        "s:i,s:s,"
        "s:s,s:f,"
        "s:f,s:o,s:o,s:o}",
        "integrator", integrator_names[report->integrator], "effects",
        names_of(report->effects, effect_of), "layers", names_of(report->layers, layer_of),
        "planes", names_of(plan->planes, plane_of), "light_planes",
        names_of(plan->light_planes, light_plane_of), "filter", filter_method_name(report->method),
        "filter_why", report->filter_why, "indirect_filter",
        plan_indirect_filter_name(plan->indirect_filter), "indirect_filter_why",
        report->indirect_filter_why, "glossy_filter", plan_glossy_filter_name(plan->glossy_filter),
        "glossy_filter_why", report->glossy_filter_why, "lens_filter",
        plan_lens_filter_name(plan->lens_filter), "lens_filter_why", report->lens_filter_why,
        "residual_filter", plan_residual_filter_name(plan->residual_filter), "residual_filter_why",
        report->residual_filter_why, "lens_relight", plan_lens_relight_name(plan->lens_relight),
        "lens_relight_why", report->lens_relight_why, "skipped", skips_of(report), "lights",
        lights_of(plan, report), "environment", environment_of(plan, report), "emitters",
        emitters_of(plan, report), "camera", camera_of(plan, report), "samples", samples_of(plan),
        "tiles", tiles_of(plan), "temporal", (int)plan->temporal, "temporal_why",
        report->temporal_why, "scene", scene, "radiance_scale", (double)plan->radiance_scale,
        "length_unit", (double)plan->length_unit, "warnings", warnings_of(report), "cameras",
        cameras_of(report), "light_filters", plan_light_filters(plan, report));
}
