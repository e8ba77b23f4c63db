/* Diffuse indirect light and ambient occlusion as light fields of pixel centres: their planes and
 * the filter that makes pictures of them. */
#include <math.h>
#include <stdio.h>

#include "proto/link/message.h"
#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

#define PLANES_BOUNCE                                                                              \
    (PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) |          \
     PLANE_BIT(AMBIENT_VISIBILITY))

/* Samples from which on linear fits have less error than weighted means (docs/reconstruction.md,
 * Which filter answers) in a room, and at most a tenth more in other scenes. Their error falls with
 * every step of samples. */
#define SAMPLES_LINEAR 36

/* Adaptive sampling (Mehta et al. 2013, section 5): strata an axis of the first rays; the most rays
 * of a pixel at mu = 1 and below. In the paper the latter grow with mu, and what a filter sees of
 * them becomes less, as its area falls with the square: errors in a box grow again from mu = 6 on.
 * With the square of mu they fall; and no less than what every pixel gets (indirect_adaptive.h). */
#define ADAPTIVE_FIRST 4
#define ADAPTIVE_MAX   100.0

const char plan_nothing_to_filter[] = "there is neither indirect light nor occlusion to filter";

bool plan_is_lit(const struct plan *plan, const struct plan_report *report)
{
    return plan->light_count > 0 || plan->environment.kind != ENVIRONMENT_NONE ||
           report->emitters.flux > 0 || report->emitters.any_unlit;
}

void plan_bounces(const struct job *job, struct plan *plan, struct plan_report *report)
{
    if (!plan_is_lit(plan, report)) {
        plan_skip(report, "effect indirect", "nothing lights the scene");
    } else if (job->indirect_bounces == 0) {
        plan_skip(report, "effect indirect", "effects.indirect_bounces is 0");
    } else {
        plan->bounces = job->indirect_bounces;
        report->effects |= EFFECT_INDIRECT;
    }
}

void plan_surfaces(struct plan *plan, struct plan_report *report)
{
    plan->planes |= PLANES_CENTRE | PLANE_BIT(ALBEDO) | PLANE_BIT(SUB_DEPTH) |
                    PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) | PLANE_BIT(SUB_ID);
    plan->sub_samples = LIMIT_SUB_SAMPLES;
    report->effects |= EFFECT_PRIMARY | EFFECT_ANTIALIAS;
}

/* Rays of a pixel, in both sets. */
static uint32_t adaptive_max(const struct job *job)
{
    const uint32_t first = ADAPTIVE_FIRST * ADAPTIVE_FIRST;
    const double mu = job->mu > 1.0f ? (double)job->mu : 1.0, least = first * mu * mu * mu;
    const double most = fmax(ADAPTIVE_MAX * mu * mu, least);
    if (job->indirect_spp > 0) return job->indirect_spp > first ? job->indirect_spp : first;
    return most < LIMIT_SPP ? (uint32_t)most : LIMIT_SPP;
}

static uint32_t choose_by_samples(uint32_t samples, char why[PLAN_FILTER_WHY_BYTES])
{
    const size_t n = PLAN_FILTER_WHY_BYTES;
    if (samples >= SAMPLES_LINEAR) {
        snprintf(why, n, "%u bounce rays: linear fits blur less than means do", samples);
        return INDIRECT_FILTER_LINEAR;
    }
    snprintf(why, n, "%u bounce ray%s: weighted means need the fewest", samples,
             samples > 1 ? "s" : "");
    return INDIRECT_FILTER_CONSTANT;
}

uint32_t plan_choose_indirect_filter(const struct job *job, const struct plan *plan,
                                     char why[PLAN_FILTER_WHY_BYTES])
{
    const size_t n = PLAN_FILTER_WHY_BYTES;
    const uint32_t l = plan->indirect_strata_per_axis;
    if (!(plan->planes & PLANES_BOUNCE)) {
        snprintf(why, n, "%s", plan_nothing_to_filter);
        return INDIRECT_FILTER_NONE;
    }
    if (job->indirect == INDIRECT_AVERAGE ||
        (job->indirect == INDIRECT_AUTO && job->method == FILTER_AVERAGE)) {
        snprintf(why, n, "filter.%s is average",
                 job->indirect == INDIRECT_AVERAGE ? "indirect" : "method");
        return INDIRECT_FILTER_NONE;
    }
    if (plan_sky_is_averaged(job, plan)) {
        snprintf(why, n, "filter.environment is average, and the field has the sky's light, too");
        return INDIRECT_FILTER_NONE;
    }
    /* What is asked for by shear, but has no strata. */
    const bool parts = (plan->planes & PLANE_BIT(INDIRECT_STRATA)) != 0;
    const uint32_t rays = plan_may_halve(job) ? (l * l + 3) / 4 : l * l;
    if (job->indirect == INDIRECT_AUTO || (job->indirect == INDIRECT_SHEARED && !parts))
        return choose_by_samples(rays, why);
    if (job->indirect == INDIRECT_ADAPTIVE)
        snprintf(why, n,
                 "filter.indirect asks for it: %u rays a pixel, then as many as their distances "
                 "call for, %u at most",
                 l * l, adaptive_max(job));
    else
        snprintf(why, n, "filter.indirect asks for it");
    return job->indirect - INDIRECT_AVERAGE;
}

const char *plan_indirect_filter_name(uint32_t filter)
{
    return filter ? indirect_method_name(INDIRECT_AVERAGE + filter) : "none";
}

/* Reports that the filter which was asked for does not run. */
static void tell_none(const struct job *job, struct plan_report *report)
{
    plan_skip(report, "filter of indirect light", "%.*s", (int)PLAN_WHY_BYTES - 1,
              report->indirect_filter_why);
    if (job->indirect != INDIRECT_AUTO && job->indirect != INDIRECT_AVERAGE)
        plan_warn(report, "filter.indirect is %s, but indirect light is not filtered: %s",
                  indirect_method_name(job->indirect), report->indirect_filter_why);
}

void plan_indirect_none(const struct job *job, const char *why, struct plan_report *report)
{
    snprintf(report->indirect_filter_why, sizeof report->indirect_filter_why, "%s", why);
    tell_none(job, report);
}

/* mu raises the number of rays and narrows the filters of indirect light. */
static void plan_adaptive(const struct job *job, struct plan *plan, struct plan_report *report)
{
    const uint32_t first = ADAPTIVE_FIRST * ADAPTIVE_FIRST;
    plan->adaptive = (struct plan_adaptive){.mu = job->mu, .rays_max = adaptive_max(job)};
    plan->planes |= PLANE_BIT(BOUNCE_DISTANCE_MAX);
    plan->capabilities |= CAPABILITY_STRATA_MAPS;
    if (job->indirect_spp > 0 && job->indirect_spp < first)
        plan_warn(
            report,
            "sampling.indirect_spp is the most rays of a pixel under adaptive sampling, which "
            "begins with %u: every pixel has these and no more",
            first);
}

/* Occlusion has rays where indirect light has none, and looking at it must not change the light. */
static void plan_ambient_distance(struct plan *plan, struct plan_report *report)
{
    const uint64_t both = PLANE_BIT(AMBIENT_VISIBILITY) | PLANE_BIT(BOUNCE_DISTANCE_MIN);
    if ((plan->planes & both) == both && (plan->planes & PLANES_BOUNCE_LIGHT))
        plan->planes |= PLANE_BIT(AMBIENT_DISTANCE_MIN);
    else
        plan_skip(report, "plane ambient_distance_min", "no filter of this plan reads it");
}

static void plan_filter_planes(const struct job *job, struct plan *plan, struct plan_report *report)
{
    plan->indirect_filter = plan_choose_indirect_filter(job, plan, report->indirect_filter_why);
    if (plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE)
        plan_adaptive(job, plan, report);
    else
        plan_skip(report, "plane bounce_distance_max", "no filter of this plan reads it");
    const bool axes = plan->indirect_filter != INDIRECT_FILTER_SHEARED;
    if (plan->indirect_filter == INDIRECT_FILTER_NONE) tell_none(job, report);
    if (job->indirect == INDIRECT_SHEARED && plan_wants_error(job) &&
        plan->indirect_filter != INDIRECT_FILTER_NONE)
        plan_warn(report,
                  "filter.indirect is sheared, which does not tell of errors: the filter is %s",
                  plan_indirect_filter_name(plan->indirect_filter));
    else if (job->indirect == INDIRECT_SHEARED && axes &&
             plan->indirect_filter != INDIRECT_FILTER_NONE)
        plan_warn(report,
                  "filter.indirect is sheared, which takes single rays of indirect light, at most "
                  "%d a pixel: the filter is %s",
                  LIMIT_PLANE_STRATA_PER_AXIS * LIMIT_PLANE_STRATA_PER_AXIS,
                  plan_indirect_filter_name(plan->indirect_filter));
    /* Errors are smoothed over surfaces, too. */
    if (plan->indirect_filter != INDIRECT_FILTER_NONE ||
        (plan->planes & PLANE_BIT(INDIRECT_HALVES)))
        plan->planes |= PLANE_BIT(BOUNCE_DISTANCE_MIN);
    else
        plan_skip(report, "plane bounce_distance_min", "no filter of this plan reads it");
    plan_ambient_distance(plan, report);
}

/* Single rays for the filter that reads them, else means, and halves that tell of their error. What
 * is made of halves is rounded otherwise than the mean, so that both travel where a layer asks for
 * errors: looking changes no bit of the picture. Under a target halves alone are mixed. */
static void plan_light(const struct job *job, uint32_t l, struct plan *plan,
                       struct plan_report *report)
{
    const bool error = plan_wants_error(job);
    const bool parts =
        job->indirect == INDIRECT_SHEARED && l <= LIMIT_PLANE_STRATA_PER_AXIS && !error;
    if (plan->bounces == 0) {
        plan_skip(report, "plane indirect_mean", "there is no indirect light");
        return;
    }
    if (report->whole_paths) {
        plan_skip(report, "plane indirect_mean", "whole paths bring it");
        return;
    }
    plan_surfaces(plan, report);
    plan->planes |= parts ? PLANE_BIT(INDIRECT_STRATA) : PLANE_BIT(INDIRECT_MEAN);
    if (error) plan->planes |= PLANE_BIT(INDIRECT_HALVES);
    if (job->target_error > 0.0f) plan->planes &= ~PLANE_BIT(INDIRECT_MEAN);
    if (parts) plan->capabilities |= CAPABILITY_STRATA;
    if (!(plan->planes & PLANE_BIT(INDIRECT_MEAN)))
        plan_skip(report, "plane indirect_mean", "it is made of the %s",
                  parts ? "strata" : "halves");
    if (!error) plan_skip(report, "plane indirect_halves", "no layer and no target needs errors");
    if (!parts) plan_skip(report, "plane indirect_strata", "no filter of this plan reads it");
    if (error && l < 2)
        plan_warn(report, "one bounce ray per pixel gives no estimate of its error");
}

static void plan_occlusion(const struct job *job, struct plan *plan, struct plan_report *report)
{
    if (!(report->layers & LAYER_OCCLUSION)) {
        plan_skip(report, "plane open", "no layer of this plan reads it");
        return;
    }
    plan->occlusion_distance = job->occlusion_distance;
    plan->planes |= PLANES_CENTRE | PLANE_BIT(AMBIENT_VISIBILITY);
    report->effects |= EFFECT_PRIMARY | EFFECT_OCCLUSION;
}

void plan_indirect(const struct job *job, struct plan *plan, struct plan_report *report)
{
    const uint32_t l = job->indirect == INDIRECT_ADAPTIVE
                           ? ADAPTIVE_FIRST
                           : job_strata_per_axis(job->indirect_spp ? job->indirect_spp : job->spp);
    /* Shadows keep their widths, also where nothing bounces but a layer's rays. */
    if (job->indirect == INDIRECT_ADAPTIVE) plan->mu = 1.0f;
    plan_light(job, l, plan, report);
    plan_occlusion(job, plan, report);
    if (plan->planes & PLANES_BOUNCE) {
        plan->indirect_strata_per_axis = l;
        plan->capabilities |= CAPABILITY_INDIRECT;
    } else if (job->indirect_spp) {
        plan_skip(report, "sampling.indirect_spp", "there is neither indirect light nor occlusion");
    }
    plan_filter_planes(job, plan, report);
}
