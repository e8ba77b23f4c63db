/* Chooses what makes a frame's picture: paths, light fields, both, or the field of the lens. */
#include <stdio.h>

#include "proto/link/message.h"
#include "server/job/plan/plan_parts.h"

/* Bounce rays beside as many paths are not worth their while: the first pass traces them all. */
#define SAMPLES_BESIDE_MAX 256

/* Paths alone: no filter runs. `indirect_why` is said of indirect light, `why` of light fields. */
static void choose_paths(const struct job *job, const char *filter_why, const char *indirect_why,
                         const char *why, struct plan_report *report)
{
    report->integrator = INTEGRATOR_PATHS;
    plan_filter_none(job, filter_why, report);
    plan_indirect_none(job, indirect_why, report);
    plan_skip(report, "light fields", "%s", why);
}

/* Returns whether there are so many paths, and unfiltered bounce rays beside them, that paths alone
 * are better: they converge in passes, over whole pixels and not at their centres. */
static bool has_enough_paths(const struct job *job, const struct plan *plan,
                             char why[PLAN_WHY_BYTES])
{
    const uint32_t l = job_strata_per_axis(job->spp), most = SAMPLES_BESIDE_MAX;
    const bool asked = job->indirect != INDIRECT_AUTO || job->method == FILTER_AVERAGE ||
                       plan_asks_for_sky(job, plan) ||
                       (job->indirect_spp > 0 && job->indirect_spp <= most);
    if (asked || l * l <= most) return false;
    snprintf(why, PLAN_WHY_BYTES, "%u samples a pixel are above %u: paths alone show little noise",
             l * l, most);
    return true;
}

/* Returns whether the residual filter makes more of whole paths than of paths beside light
 * fields of indirect light, which double the rays and have samples of their own. psnr_db at 4
 * samples beside fields, of whole paths, and of whole paths at 9, which cost the same: blocks
 * 40.5, 40.8, 44.2; under the sky 43.5, 44.1, 47.3; living room 23.6, 24.3, 26.2. What is asked
 * for by name, runs. */
static bool does_without_fields(const struct job *job, const struct plan *plan,
                                const struct plan_report *report, char why[PLAN_WHY_BYTES])
{
    const bool asked = plan_asks_for_sky(job, plan) || job->indirect != INDIRECT_AUTO ||
                       job->glossy != GLOSSY_AUTO || job->indirect_spp > 0 ||
                       job->method == FILTER_AVERAGE;
    if (asked || !plan_residual_possible(job, report)) return false;
    snprintf(why, PLAN_WHY_BYTES,
             "the residual filter cleans whole paths for fewer rays than light fields beside them");
    return true;
}

/* Light fields cannot do it alone. */
static void choose_beside(const struct job *job, const struct plan *plan, const char *why,
                          struct plan_report *report)
{
    char filter_why[PLAN_FILTER_WHY_BYTES], enough_paths[PLAN_WHY_BYTES];
    bool indirect = job->indirect_bounces > 0 && plan_is_lit(plan, report);
    bool occlusion = (report->layers & LAYER_OCCLUSION) != 0;
    if (plan_divides(job, plan, report)) {
        report->integrator = INTEGRATOR_PATHS_AND_LIGHT_FIELD;
        plan_skip(report, "light fields alone", "%s", why);
        return;
    }
    if (!indirect && !occlusion) {
        snprintf(filter_why, sizeof filter_why,
                 "paths make the picture, because light fields cannot: %s", why);
        choose_paths(job, filter_why, plan_nothing_to_filter, why, report);
        return;
    }
    if (has_enough_paths(job, plan, enough_paths)) {
        choose_paths(job, enough_paths, enough_paths, enough_paths, report);
        return;
    }
    report->whole_paths = !indirect || does_without_fields(job, plan, report, enough_paths);
    if (report->whole_paths && !occlusion) {
        plan_skip(report, "light fields of lights", "%s", why);
        choose_paths(job, enough_paths, enough_paths, enough_paths, report);
        return;
    }
    report->integrator = INTEGRATOR_PATHS_AND_LIGHT_FIELD;
    snprintf(filter_why, sizeof filter_why, "direct light comes along paths, unfiltered: %s", why);
    plan_filter_none(job, filter_why, report);
    plan_skip(report, "light fields of lights", "%s", why);
}

/* There is a lens. Where the camera goes, what is blurred has no samples in other frames: nothing
 * tells how it moves. */
static void choose_lens(const struct job *job, const struct plan *plan, bool camera_stands,
                        struct plan_report *report)
{
    char why[PLAN_WHY_BYTES], filter_why[PLAN_FILTER_WHY_BYTES];
    if (camera_stands && plan_prefers_window(job, plan, report, why)) {
        choose_paths(job, why, why, why, report);
        plan_lens_none(job, why, report);
        return;
    }
    if (!plan_lens_possible(job, plan, why)) {
        snprintf(filter_why, sizeof filter_why,
                 "paths make the picture, because light fields cannot: %s", why);
        choose_paths(job, filter_why, filter_why, why, report);
        plan_lens_none(job, why, report);
        return;
    }
    report->integrator = INTEGRATOR_LENS_FIELD;
}

/* Frames use each other's paths. Occlusion, which is no light, has bounce rays all the same. */
static void choose_window(const struct job *job, const char *why, struct plan_report *report)
{
    report->whole_paths = true;
    if (!(report->layers & LAYER_OCCLUSION)) {
        choose_paths(job, why, why, why, report);
        return;
    }
    report->integrator = INTEGRATOR_PATHS_AND_LIGHT_FIELD;
    plan_filter_none(job, why, report);
    plan_skip(report, "light fields of lights", "%s", why);
}

/* Without one. */
static void choose_pinhole(const struct job *job, const struct scene *scene,
                           const struct plan *plan, struct plan_report *report)
{
    char why[PLAN_WHY_BYTES], filter_why[PLAN_FILTER_WHY_BYTES];
    plan_lens_none(job, "the camera is a pinhole", report);
    if (!plan_light_field_possible(job, scene, why)) {
        snprintf(filter_why, sizeof filter_why,
                 "paths make the picture, because light fields cannot: %s", why);
        choose_paths(job, filter_why, filter_why, why, report);
    } else if (plan_prefers_window(job, plan, report, why)) {
        choose_window(job, why, report);
    } else if (!plan_light_field_covers(job, scene, plan, &report->emitters, why)) {
        report->bumpy = plan_has_bumps(scene);
        report->volumes = plan_has_volumes(scene);
        choose_beside(job, plan, why, report);
    } else {
        report->integrator = INTEGRATOR_LIGHT_FIELD;
        plan_skip(report, "paths", "light fields cover the scene and the layers");
    }
}

/* The views of a composite must differ by the objects alone. */
static void choose_views(const struct job *job, const struct plan_source *source, struct plan *plan,
                         struct plan_report *report)
{
    static const char why[] = "the picture is composed with a photograph: its views are of paths";
    choose_paths(job, why, why, why, report);
    plan_lens_none(job, why, report);
    plan->composite = 1;
    /* Measured depth is too rough to look for points in a frame: errors grow by a third. */
    if (!job->composite.rgbd) plan->photograph = source->photograph;
    plan->capabilities |= CAPABILITY_VIEWS;
}

void plan_choose(const struct job *job, const struct plan_source *source, struct plan *plan,
                 struct plan_report *report)
{
    static const char none[] = "filter.method is none: samples are averaged";
    static const char moves[] = "samples have times of their own while the shutter is open, which "
                                "light fields of pixel centres have not";
    if (job->composite.on) {
        choose_views(job, source, plan, report);
    } else if (job->method == FILTER_NONE) {
        choose_paths(job, none, none, "filter.method is none: every sample is a path", report);
        plan_lens_none(job, none, report);
    } else if (plan_has_shutter(plan)) {
        choose_paths(job, moves, moves, moves, report);
        plan_lens_none(job, moves, report);
    } else if (plan->camera.aperture_radius > 0) {
        choose_lens(job, plan, source->camera_stands, report);
    } else {
        choose_pinhole(job, source->scene, plan, report);
    }
}
