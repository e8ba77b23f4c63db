/* Plans the light field of glossy lobes beside paths: its planes and its filter. */
#include <stdio.h>

#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

static bool may_be_gltf(const struct scene_material *m)
{
    const bool facets = m->metallic > 0 || m->specular > 0;
    const bool opaque = !(m->transmission > 0) || m->transmission_texture.texture != SCENE_NONE;
    const bool bare = !plan_has_layers(m, true);
    return m->model == MODEL_GLTF && facets && opaque && bare &&
           m->roughness * m->roughness >= GLOSSY_ALPHA_MIN;
}

/* Returns whether points of the material may have a glossy lobe. worker/shade/glossy.h decides at
 * each. */
static bool may_be_glossy(const struct scene_material *m)
{
    if (m->flags & MATERIAL_UNLIT) return false;
    return may_be_gltf(m) || m->model == MODEL_BLINN_PHONG || m->model == MODEL_BECKMANN ||
           m->model == MODEL_WARD || m->model == MODEL_KELEMEN ||
           m->model == MODEL_ASHIKHMIN_SHIRLEY || m->model == MODEL_MEASURED;
}

static bool may_be_stretched(const struct scene_material *m)
{
    if (m->model == MODEL_GLTF) return m->anisotropy > 0;
    return m->alpha_u != m->alpha_v || m->exponent_u != m->exponent_v;
}

/* Returns whether some surface may have a glossy lobe, and sets whether one may be wider one way
 * than the other. */
static bool has_glossy(const struct scene *scene, bool *stretched)
{
    bool any = false;
    *stretched = false;
    for (uint64_t i = 0; i < scene->count[SCENE_INSTANCES]; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const struct scene_material *m = &scene->materials[mesh->material];
        any |= may_be_glossy(m);
        *stretched |= may_be_glossy(m) && may_be_stretched(m);
    }
    return any;
}

/* Returns whether the filter compares how lobes lie. */
static bool knows_axes(uint32_t filter)
{
    return filter == GLOSSY_FILTER_VIRTUAL_HIT || filter == GLOSSY_FILTER_ASG;
}

/* Returns whether there is such a field. If not, `why` says so in a sentence. */
static bool is_possible(const struct job *job, const struct scene *scene, const struct plan *plan,
                        const struct plan_report *report, char why[PLAN_FILTER_WHY_BYTES])
{
    const size_t n = PLAN_FILTER_WHY_BYTES;
    const uint64_t pixels = (uint64_t)plan->width_px * (uint64_t)plan->height_px;
    const uint64_t l = job_strata_per_axis(job->lens_spp ? job->lens_spp : job->spp);
    const uint64_t lobes = l * l * sizeof(uint32_t);
    bool stretched;
    const bool lens =
        plan->lens_relight == LENS_RELIGHT_INDIRECT || plan->lens_relight == LENS_RELIGHT_SKY;
    if (report->by_lobe)
        snprintf(why, n, "paths bring what glossy lobes send on");
    else if (report->integrator != INTEGRATOR_PATHS_AND_LIGHT_FIELD && !lens)
        snprintf(why, n, "glossy lobes have a field beside paths and light fields only");
    else if (!(plan->planes & PLANES_BOUNCE_LIGHT))
        snprintf(why, n, "there is no indirect light");
    else if (!has_glossy(scene, &stretched))
        snprintf(why, n, "no surface has a glossy lobe that is bare and not too sharp");
    else if (lens && (plan_lens_bytes(job, true) + lobes) * pixels > LIMIT_LENS_BYTES)
        snprintf(why, n, "lens samples with their lobes are above %llu bytes", LIMIT_LENS_BYTES);
    else
        return true;
    return false;
}

static uint32_t choose(const struct job *job, const struct plan *plan,
                       char why[PLAN_FILTER_WHY_BYTES])
{
    const size_t n = PLAN_FILTER_WHY_BYTES;
    const bool averaged = job->glossy == GLOSSY_AUTO && job->method == FILTER_AVERAGE;
    const uint32_t l = plan->indirect_strata_per_axis;
    if (averaged || job->glossy == GLOSSY_AVERAGE) {
        snprintf(why, n, "filter.%s is average", averaged ? "method" : "glossy");
        return GLOSSY_FILTER_NONE;
    }
    if (job->glossy == GLOSSY_AUTO && plan_sky_is_averaged(job, plan)) {
        snprintf(why, n, "filter.environment is average, and the field has the sky's light, too");
        return GLOSSY_FILTER_NONE;
    }
    if (job->glossy == GLOSSY_AUTO) {
        snprintf(why, n,
                 "%u ray%s a lobe: neighbours whose lobes see the same points need the fewest",
                 l * l, l > 1 ? "s" : "");
        return GLOSSY_FILTER_VIRTUAL_HIT;
    }
    snprintf(why, n, "filter.glossy asks for it");
    return job->glossy - GLOSSY_AVERAGE;
}

const char *plan_glossy_filter_name(uint32_t filter)
{
    return filter ? glossy_method_name(GLOSSY_AVERAGE + filter) : "none";
}

static void plan_planes(const struct job *job, const struct scene *scene, struct plan *plan,
                        struct plan_report *report)
{
    bool stretched;
    plan->planes |= (PLANES_GLOSSY & ~PLANES_GLOSSY_AXES) | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) |
                    PLANE_BIT(ID);
    if (has_glossy(scene, &stretched) && stretched && knows_axes(plan->glossy_filter))
        plan->planes |= PLANES_GLOSSY_AXES;
    if (plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE) plan->planes |= PLANE_BIT(GLOSSY_SPAN);
    if (report->integrator == INTEGRATOR_LENS_FIELD) {
        plan->planes |= PLANE_BIT(LENS_LOBE);
        plan->lens_lobes_only = plan->lens_relight == LENS_RELIGHT_SKY && report->soft_sky &&
                                plan->light_count == 0 && !report->emitters.any_seen;
        plan->planes &= ~PLANE_BIT(SUB_REFLECTANCE);
        plan_skip(report, "plane sub_reflectance", "lens samples make the picture");
    }
    if (plan_wants_error(job)) return;
    plan->planes &= ~PLANE_BIT(GLOSSY_HALF);
    plan_skip(report, "plane glossy_half", "no layer and no target needs errors");
}

void plan_glossy(const struct job *job, const struct scene *scene, struct plan *plan,
                 struct plan_report *report)
{
    char *why = report->glossy_filter_why;
    const bool asked = job->glossy != GLOSSY_AUTO && job->glossy != GLOSSY_AVERAGE;
    if (is_possible(job, scene, plan, report, why)) {
        plan->glossy_filter = choose(job, plan, why);
        if (plan->glossy_filter != GLOSSY_FILTER_NONE ||
            report->integrator != INTEGRATOR_LENS_FIELD)
            plan_planes(job, scene, plan, report);
        if (plan->glossy_filter != GLOSSY_FILTER_NONE) return;
    } else {
        plan_skip(report, "planes of glossy lobes", "%.*s", (int)PLAN_WHY_BYTES - 1, why);
    }
    plan_skip(report, "filter of glossy lobes", "%.*s", (int)PLAN_WHY_BYTES - 1, why);
    if (asked)
        plan_warn(report, "filter.glossy is %s, but glossy lobes are not filtered: %s",
                  glossy_method_name(job->glossy), why);
}
