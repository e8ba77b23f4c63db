/* Plans the environment that a job means. */
#include <math.h>

#include "proto/link/message.h"
#include "server/job/plan/plan_parts.h"

/* Refuses a map that the job's factor makes brighter than samples can hold. */
static int check_brightness(const struct job_environment *e, const struct environment_header *map,
                            struct fault *fault)
{
    for (int c = 0; c < 3; c++) {
        double most = (double)map->maximum[c] * (double)e->intensity;
        if (most > (double)LIMIT_RADIANCE)
            return fault_set(fault, ERR_RANGE, "/environment/intensity",
                             "%.9g times the map's brightest texel, %.9g, is above %.9g",
                             (double)e->intensity, (double)map->maximum[c], (double)LIMIT_RADIANCE);
    }
    return 0;
}

static int set_map(const struct job_environment *e, const struct plan_source *source,
                   struct plan_environment *out, float mean[3], struct fault *fault)
{
    int error = check_brightness(e, source->map, fault);
    if (error) return error;
    for (int c = 0; c < 3; c++) {
        out->radiance[c] = e->intensity;
        mean[c] = source->map->mean[c] * e->intensity;
    }
    out->map = source->map_blob;
    out->rotation_rad = (float)(remainder((double)e->rotation_deg, 360) * (M_PI / 180));
    return 0;
}

/* Displays and labels shine up to 1, as white paper in a studio does, and light no scene; lamps
 * shine brighter. */
#define DISPLAY_MAX 1.0f

static bool has_lamp(const struct scene *scene)
{
    for (uint64_t i = 0; i < scene->count[SCENE_MESHES]; i++) {
        const struct scene_material *m = &scene->materials[scene->meshes[i].material];
        if (m->flags & MATERIAL_UNLIT) continue;
        for (int c = 0; c < 3; c++)
            if (m->emission[c] > DISPLAY_MAX) return true;
    }
    return false;
}

/* Returns whether a surface needs light to be seen. */
static bool has_shaded(const struct scene *scene)
{
    for (uint64_t i = 0; i < scene->count[SCENE_MESHES]; i++)
        if (!(scene->materials[scene->meshes[i].material].flags & MATERIAL_UNLIT)) return true;
    return false;
}

bool plan_may_want_studio(const struct job *job, const struct scene *scene)
{
    const bool dark = job->environment.kind == ENVIRONMENT_NONE && job->light_count == 0;
    return job->default_light && dark && (job->scene_lights || scene->count[SCENE_LIGHTS] == 0) &&
           has_shaded(scene);
}

/* Sets the studio light where nothing else lights the scene. */
static bool set_studio(const struct job *job, const struct plan_source *source, struct plan *plan,
                       struct plan_report *report, float mean[3])
{
    if (!source->studio || plan->light_count > 0) return false;
    if (!plan_may_want_studio(job, source->scene) || has_lamp(source->scene)) return false;
    plan->environment = (struct plan_environment){
        .kind = ENVIRONMENT_MAP, .radiance = {1, 1, 1}, .map = source->studio_blob};
    for (int c = 0; c < 3; c++) mean[c] = source->studio->mean[c];
    report->studio_light = report->soft_sky = true;
    report->effects |= EFFECT_ENVIRONMENT;
    plan->capabilities |= CAPABILITY_ENVIRONMENT;
    plan_warn(report, "nothing lights this scene: a neutral studio light does; scene.default_light "
                      "false turns it off");
    return true;
}

/* Sets the light that frames of colour and depth tell of, beside lights of the list. */
static bool set_estimate(const struct job *job, const struct plan_source *source, struct plan *plan,
                         struct plan_report *report, float mean[3])
{
    if (!source->estimate || job->environment.kind != ENVIRONMENT_NONE) return false;
    for (int c = 0; c < 3; c++) mean[c] = source->estimate->mean[c];
    if (!(plan_luminance(mean) > 0)) return false;
    plan->environment = (struct plan_environment){
        .kind = ENVIRONMENT_MAP, .radiance = {1, 1, 1}, .map = source->estimate_blob};
    report->estimated_light = true;
    report->soft_sky = plan_luminance(source->estimate->maximum) <=
                       (double)PLAN_SKY_SOFT_TIMES * plan_luminance(mean);
    report->effects |= EFFECT_ENVIRONMENT;
    plan->capabilities |= CAPABILITY_ENVIRONMENT;
    return true;
}

int plan_set_environment(const struct job *job, const struct plan_source *source, struct plan *plan,
                         struct plan_report *report, float mean[3], struct fault *fault)
{
    const struct job_environment *e = &job->environment;
    struct plan_environment out = {.kind = e->kind};
    for (int c = 0; c < 3; c++) mean[c] = 0;
    plan->environment = (struct plan_environment){.kind = ENVIRONMENT_NONE};
    if (set_estimate(job, source, plan, report, mean)) return 0;
    if (set_studio(job, source, plan, report, mean)) return 0;
    if (e->kind == ENVIRONMENT_NONE) {
        plan_skip(report, "effect environment", "the job has none");
        return 0;
    }
    if (e->kind == ENVIRONMENT_MAP) {
        int error = set_map(e, source, &out, mean, fault);
        if (error) return error;
    } else {
        for (int c = 0; c < 3; c++) out.radiance[c] = mean[c] = e->radiance[c];
    }
    if (!(plan_luminance(mean) > 0)) {
        plan_skip(report, "effect environment", "its radiance is black");
        return 0;
    }
    plan->environment = out;
    report->soft_sky = e->kind != ENVIRONMENT_MAP ||
                       plan_luminance(source->map->maximum) <=
                           (double)PLAN_SKY_SOFT_TIMES * plan_luminance(source->map->mean);
    report->effects |= EFFECT_ENVIRONMENT;
    plan->capabilities |= CAPABILITY_ENVIRONMENT;
    return 0;
}

bool plan_asks_for_sky(const struct job *job, const struct plan *plan)
{
    return job->environment_filter != ENVIRONMENT_AUTO &&
           plan->environment.kind != ENVIRONMENT_NONE;
}

bool plan_sky_is_averaged(const struct job *job, const struct plan *plan)
{
    return plan_asks_for_sky(job, plan) && job->environment_filter == ENVIRONMENT_AVERAGE &&
           !(plan->camera.aperture_radius > 0);
}

void plan_tell_sky(const struct job *job, const struct plan *plan, struct plan_report *report)
{
    const uint32_t layers =
        LAYER_DIRECT | LAYER_INDIRECT | LAYER_DIFFUSE_DIRECT | LAYER_DIFFUSE_INDIRECT;
    const char *name = environment_method_name(job->environment_filter);
    if (job->environment_filter == ENVIRONMENT_AUTO) return;
    if (plan->environment.kind == ENVIRONMENT_NONE)
        plan_warn(report, "filter.environment is %s, but there is no environment", name);
    else if (!plan_sky_in_fields(plan))
        plan_warn(report,
                  "filter.environment is %s, but paths bring the environment's light: fields need "
                  "effects.indirect_bounces from 1 on, a box as pixel filter, no alpha blending, "
                  "shutter, photograph or filter.method none",
                  name);
    else if (job->environment_filter == ENVIRONMENT_AXIS_ALIGNED &&
             plan->indirect_filter == INDIRECT_FILTER_NONE)
        plan_warn(report,
                  "filter.environment is %s, but the field that has its light is not "
                  "filtered: %s",
                  name, report->indirect_filter_why);
    else if (report->layers & layers)
        plan_warn(report,
                  "filter.environment is %s: in layers the environment's soft light is indirect",
                  name);
}
