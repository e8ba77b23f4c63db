#include "server/job/plan.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "proto/message.h"
#include "proto/plan_check.h"
#include "proto/samples.h"

#define PLANE_BIT(plane) (1u << PLANE_##plane)

void plan_skip(struct plan_report *report, const char *what, const char *format, ...)
{
    va_list args;
    if (report->skip_count == PLAN_SKIPS) return;
    struct plan_skip *skip = &report->skipped[report->skip_count++];
    snprintf(skip->what, sizeof skip->what, "%s", what);
    va_start(args, format);
    vsnprintf(skip->why, sizeof skip->why, format, args);
    va_end(args);
}

void plan_warn(struct plan_report *report, const char *format, ...)
{
    va_list args;
    if (report->warning_count == LIMIT_WARNINGS) return;
    va_start(args, format);
    vsnprintf(report->warnings[report->warning_count++], LIMIT_DETAIL_BYTES, format, args);
    va_end(args);
}

/* The importer's warnings are the job's, too. */
static void copy_warnings(const struct scene *scene, struct plan_report *report)
{
    const char *at = scene->warnings;
    const char *end = at ? at + scene->count[SCENE_WARNINGS] : at;
    while (at < end) {
        size_t length = strnlen(at, (size_t)(end - at));
        if (length > 0) plan_warn(report, "%.*s", (int)(length < 500 ? length : 500), at);
        at += length + 1;
    }
}

static bool emits(const struct scene_material *m)
{
    return m->emission[0] > 0 || m->emission[1] > 0 || m->emission[2] > 0 ||
           (m->flags & MATERIAL_UNLIT) != 0;
}

/* What shines towards the camera, and what shines at bounces besides the lights. */
static void find_emitters(const struct scene *scene, bool *any, bool *besides_lights)
{
    *any = *besides_lights = false;
    for (uint64_t i = 0; i < scene->count[SCENE_MESHES]; i++) {
        const struct scene_mesh *mesh = &scene->meshes[i];
        if (!emits(&scene->materials[mesh->material])) continue;
        *any = true;
        if (!(mesh->flags & MESH_IS_LIGHT)) *besides_lights = true;
    }
}

static void plan_indirect(const struct job *job, bool lit, struct plan *plan,
                          struct plan_report *report)
{
    if (job->indirect_bounces == 0) {
        plan_skip(report, "effect indirect", "effects.indirect_bounces is 0");
        return;
    }
    if (!lit) {
        plan_skip(report, "effect indirect", "nothing lights the scene");
        return;
    }
    plan->bounces = job->indirect_bounces;
    plan->indirect_strata_per_axis =
        job_strata_per_axis(job->indirect_spp ? job->indirect_spp : job->spp);
    plan->planes |= PLANE_BIT(INDIRECT_MEAN);
    plan->capabilities |= CAPABILITY_INDIRECT;
    report->effects |= EFFECT_INDIRECT;
    static const char why[] = "no filter of this plan reads it";
    plan_skip(report, "plane indirect_halves", why);
    plan_skip(report, "plane reflector", why);
    plan_skip(report, "plane indirect_strata", why);
}

static void plan_direct(struct plan *plan, struct plan_report *report)
{
    bool area = false;
    uint32_t layers = report->layers;
    if (plan->light_count == 0) {
        plan_skip(report, "effect direct", "there is no light");
        return;
    }
    for (uint32_t k = 0; k < plan->light_count; k++)
        area = area || plan->lights[k].type == LIGHT_RECTANGLE;
    report->effects |= EFFECT_DIRECT | EFFECT_SHADOWS;
    plan->light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    plan->capabilities |= CAPABILITY_DIRECT;
    static const char no_reader[] = "no filter or layer of this plan reads it";
    static const char no_area[] = "no light has area";
    if (layers & LAYER_VISIBILITY)
        plan->light_planes |= 1u << LIGHT_PLANE_VISIBILITY;
    else
        plan_skip(report, "plane visibility", "%s", area ? no_reader : no_area);
    if (area && (layers & (LAYER_SLOPE_MIN | LAYER_SLOPE_MAX)))
        plan->light_planes |= 1u << LIGHT_PLANE_SLOPES;
    else
        plan_skip(report, "plane slopes", "%s", area ? no_reader : no_area);
    if (plan->light_planes & ~(1u << LIGHT_PLANE_IRRADIANCE))
        plan->capabilities |= CAPABILITY_VISIBILITY;
}

static int check_strata(const struct job *job, const struct plan *plan, struct fault *fault)
{
    uint32_t l = job_strata_per_axis(job->light_spp ? job->light_spp : job->spp);
    if (plan->light_planes <= 1u << LIGHT_PLANE_IRRADIANCE || l <= LIMIT_PLANE_STRATA_PER_AXIS)
        return 0;
    return fault_set(fault, ERR_LIMIT, job->light_spp ? "/sampling/light_spp" : "/sampling/spp",
                     "%u samples a light: the layers visibility and slope_* take at most %d", l * l,
                     LIMIT_PLANE_STRATA_PER_AXIS * LIMIT_PLANE_STRATA_PER_AXIS);
}

/* A tile's samples must fit one frame on the wire: many lights ask for smaller tiles. */
static int fit_tile(struct plan *plan, struct plan_report *report, struct fault *fault)
{
    struct samples_layout layout;
    int32_t asked = plan->tile_px;
    while (samples_layout_init(&layout, plan, 0, plan->tile_px, plan->tile_px) != 0) {
        plan->tile_px /= 2;
        if (plan->tile_px < LIMIT_TILE_SIDE_MIN_PX)
            return fault_set(fault, ERR_LIMIT, "/sampling/spp",
                             "the samples of the smallest tile do not fit a message");
    }
    if (plan->tile_px != asked)
        plan_warn(report, "tiles of %d px would hold too many samples; they are %d px", asked,
                  plan->tile_px);
    return 0;
}

static void plan_surfaces(bool emission, struct plan *plan, struct plan_report *report)
{
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ALBEDO) | PLANE_BIT(ID) |
                   PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) |
                   PLANE_BIT(SUB_ID);
    plan->sub_samples = LIMIT_SUB_SAMPLES;
    report->effects = EFFECT_PRIMARY | EFFECT_ANTIALIAS;
    if (emission) {
        plan->planes |= PLANE_BIT(EMISSION);
        report->effects |= EFFECT_EMISSION;
    } else {
        plan_skip(report, "plane emission", "no material emits light");
    }
}

static void plan_filter(const struct job *job, struct plan_report *report)
{
    report->method = FILTER_NONE;
    if (job->method == FILTER_NONE)
        plan_skip(report, "filter", "filter.method is none: samples are averaged");
    else
        plan_skip(report, "filter", "this version has no filter yet: auto means none");
}

int plan_make(const struct job *job, const struct scene *scene, const struct digest *blob,
              int32_t frame, struct plan *plan, struct plan_report *report, struct fault *fault)
{
    struct fault inner = {0};
    bool emission, emission_besides_lights;
    *plan = (struct plan){.scene = *blob,
                          .width_px = job->width_px,
                          .height_px = job->height_px,
                          .tile_px = job->tile_px,
                          .pattern = {.seed = job->seed, .frame = (uint32_t)frame}};
    memset(report, 0, sizeof *report);
    report->layers = job->layers;
    copy_warnings(scene, report);
    int error = plan_resolve_camera(job, scene, &plan->camera, report, fault);
    if (!error) error = plan_gather_lights(job, scene, plan, report, fault);
    if (error) return error;
    find_emitters(scene, &emission, &emission_besides_lights);
    plan_filter(job, report);
    plan_surfaces(emission, plan, report);
    plan_direct(plan, report);
    plan_indirect(job, plan->light_count > 0 || emission_besides_lights, plan, report);
    if (plan->light_count == 0 && !emission)
        plan_warn(report, "nothing lights this scene: the picture will be black; add \"lights\"");
    error = check_strata(job, plan, fault);
    if (!error) error = fit_tile(plan, report, fault);
    if (!error && plan_check(plan, &inner) != 0)
        error = fault_set(fault, inner.code, "", "%s: %s", inner.pointer, inner.detail);
    return error;
}
