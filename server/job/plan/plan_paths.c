/* Plans paths, alone or beside light fields: spp a pixel, and the planes that layers need. */
#include <stdio.h>

#include "proto/link/message.h"
#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

#define LAYERS_PER_STRATUM (LAYER_VISIBILITY | LAYER_SLOPE_MIN | LAYER_SLOPE_MAX)

/* The layers that read each plane. Layers of the pixel's centre tell by the depth whether there is
 * a surface. */
static const struct {
    const char *name;
    uint32_t plane;
    uint32_t layers;
} readers[] = {
    {"depth", PLANE_BIT(DEPTH), LAYER_DEPTH | LAYER_NORMAL | LAYERS_PER_STRATUM | LAYERS_MOTION},
    {"normal", PLANE_BIT(NORMAL), LAYER_NORMAL},
    {"id", PLANE_BIT(ID), LAYER_ID | LAYERS_MOTION},
    {"path_m2", PLANE_BIT(PATH_M2), LAYER_ERROR},
    {"path_half_difference2", PLANE_BIT(PATH_HALF_DIFFERENCE2), LAYER_ERROR},
    {"path_emission", PLANE_BIT(PATH_EMISSION), LAYER_EMISSION},
    {"path_direct", PLANE_BIT(PATH_DIRECT), LAYER_DIRECT},
    {"path_indirect", PLANE_BIT(PATH_INDIRECT), LAYER_INDIRECT},
    {"path_diffuse_direct", PLANE_BIT(PATH_DIFFUSE_DIRECT), LAYER_DIFFUSE_DIRECT},
    {"path_diffuse_indirect", PLANE_BIT(PATH_DIFFUSE_INDIRECT), LAYER_DIFFUSE_INDIRECT},
    {"path_albedo", PLANE_BIT(PATH_ALBEDO), LAYER_ALBEDO},
    {"path_coverage", PLANE_BIT(PATH_COVERAGE), LAYER_BEAUTY},
    {"path_visibility", PLANE_BIT(PATH_VISIBILITY), LAYER_OCCLUSION},
};

/* Returns whether light fields beside the paths bring all of a plane's light. Of surfaces with
 * normal maps they bring what shines alone. */
static bool is_brought(const struct plan *plan, const struct plan_report *report, uint64_t plane)
{
    const uint64_t diffuse =
        PLANE_BIT(PATH_DIFFUSE_DIRECT) | PLANE_BIT(PATH_DIFFUSE_INDIRECT) | PLANE_BIT(PATH_ALBEDO);
    if (plane == PLANE_BIT(PATH_VISIBILITY))
        return (plan->planes & PLANE_BIT(AMBIENT_VISIBILITY)) != 0;
    if (report->by_light)
        return plane == PLANE_BIT(PATH_DIFFUSE_INDIRECT) && !report->bumpy &&
               plan->paths.without_diffuse_indirect;
    if (plan->paths.without_diffuse_direct)
        return plane == PLANE_BIT(PATH_EMISSION) || ((plane & diffuse) && !report->bumpy);
    return plane == PLANE_BIT(PATH_DIFFUSE_INDIRECT) && plan->paths.without_diffuse_indirect;
}

static void plan_planes(struct plan *plan, struct plan_report *report)
{
    char what[64];
    plan->planes |= PLANE_BIT(PATH_RADIANCE);
    for (unsigned i = 0; i < sizeof readers / sizeof readers[0]; i++) {
        const bool error = (readers[i].layers & LAYER_ERROR) && plan->target_error > 0.0f;
        const bool read = (report->layers & readers[i].layers) != 0 || error;
        const bool brought = is_brought(plan, report, readers[i].plane);
        if (plan->planes & readers[i].plane) continue;
        if (read && !brought) {
            plan->planes |= readers[i].plane;
            continue;
        }
        snprintf(what, sizeof what, "plane %s", readers[i].name);
        plan_skip(report, what,
                  read ? "a light field brings it" : "no layer of this plan reads it");
    }
}

void plan_path_lights(const struct job *job, struct plan *plan, struct plan_report *report)
{
    if (report->by_lobe) return;
    plan_strata_planes(plan, report);
    if (plan->light_planes) return;
    for (uint32_t k = 0; k < plan->light_count; k++) plan->lights[k].strata_per_axis = 1;
    if (job->light_spp)
        plan_skip(report, "sampling.light_spp", "each path takes one point of one light");
}

void plan_path_effects(struct plan *plan, struct plan_report *report)
{
    const bool environment = plan->environment.kind != ENVIRONMENT_NONE;
    report->effects |= EFFECT_PRIMARY | EFFECT_ANTIALIAS;
    if (plan->light_count > 0 || environment || report->emitters.flux > 0)
        report->effects |= EFFECT_SHADOWS;
    if (environment || report->emitters.any_seen) report->effects |= EFFECT_EMISSION;
    if (plan_is_lit(plan, report))
        report->effects |= EFFECT_DIRECT;
    else
        plan_skip(report, "effect direct", "nothing lights the scene");
}

void plan_paths(const struct job *job, struct plan *plan, struct plan_report *report)
{
    uint32_t l = job_strata_per_axis(job->spp);
    plan->paths.spp = l * l;
    plan->paths.pixel_filter = job->pixel_filter;
    const bool fields = (plan->planes & (PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) |
                                         PLANE_BIT(INDIRECT_STRATA))) != 0;
    plan->paths.without_diffuse_indirect = !fields                        ? INDIRECT_LEFT_NONE
                                           : plan_asks_for_sky(job, plan) ? INDIRECT_LEFT_SKY
                                                                          : INDIRECT_LEFT_SCATTERED;
    plan->paths.without_glossy_indirect = (plan->planes & PLANE_BIT(GLOSSY_MEAN)) != 0;
    plan->paths.without_diffuse_direct = report->by_light  ? DIRECT_LEFT_LISTED
                                         : report->by_lobe ? DIRECT_LEFT_ALL
                                                           : DIRECT_LEFT_NONE;
    plan->capabilities |= CAPABILITY_PATHS;
    plan_residual(job, plan, report);
    plan_planes(plan, report);
    plan_path_lights(job, plan, report);
    plan_path_effects(plan, report);
    if (job->indirect_spp && report->integrator == INTEGRATOR_PATHS)
        plan_skip(report, "sampling.indirect_spp", "each path goes on alone");
    if (report->layers & LAYER_OCCLUSION) {
        plan->occlusion_distance = job->occlusion_distance;
        report->effects |= EFFECT_OCCLUSION;
    }
    if ((report->layers & LAYER_ERROR) && plan->paths.spp < 2)
        plan_warn(report,
                  "one path per pixel gives no estimate of its error: the layer error is 0");
}
