/* Chooses the shadow filter of a frame of light fields. */
#include <stdio.h>

#include "server/job/plan/plan_parts.h"

/* The sheared filter may cost this many times what tracing does, since it stands for four times as
 * many samples under the axis-aligned one (docs/reconstruction.md, Which filter answers). */
#define COST_MAX 4.0

/* Nanoseconds of CPU time: of a ray with its shading, and of the sheared filter for each pixel and
 * light, and more for each sample. Only their ratio matters. */
#define RAY_NS     50.0
#define SHEARED_NS 370.0
#define STRATUM_NS 2.5

/* Returns the strata of each rectangle under this plan, or 0 without one, and counts rectangles. */
static uint32_t rectangle_samples(const struct plan *plan, uint32_t *rectangles)
{
    uint32_t l = 0;
    *rectangles = 0;
    for (uint32_t k = 0; k < plan->light_count; k++) {
        if (plan->lights[k].type != LIGHT_RECTANGLE) continue;
        l = plan->lights[k].strata_per_axis;
        ++*rectangles;
    }
    return l * l;
}

/* Returns the CPU time of the sheared filter over that of tracing, for a pixel. */
static double relative_cost(const struct job *job, const struct plan *plan, uint32_t rectangles,
                            uint32_t samples)
{
    double bounce = job->indirect_spp ? job->indirect_spp : job->spp;
    double rays = 1 + LIMIT_SUB_SAMPLES + (double)rectangles * samples +
                  (plan->light_count - rectangles) +
                  2 * bounce * plan->bounces; /* each asks one light */
    return rectangles * (SHEARED_NS + STRATUM_NS * samples) / (rays * RAY_NS);
}

uint32_t plan_choose_filter(const struct job *job, const struct plan *plan,
                            char why[PLAN_FILTER_WHY_BYTES])
{
    const size_t n = PLAN_FILTER_WHY_BYTES;
    uint32_t rectangles, samples = rectangle_samples(plan, &rectangles);
    uint32_t most = LIMIT_PLANE_STRATA_PER_AXIS * LIMIT_PLANE_STRATA_PER_AXIS;
    if (job->method == FILTER_AVERAGE) {
        snprintf(why, n, "filter.method is average");
        return SHADOW_FILTER_NONE;
    }
    if (rectangles == 0) {
        snprintf(why, n, "no light has area: shadows are sharp");
        return SHADOW_FILTER_NONE;
    }
    if (samples > most) {
        snprintf(why, n,
                 "%u samples a light are more than the %u that travel one by one: their "
                 "plain average shows little noise",
                 samples, most);
        return SHADOW_FILTER_NONE;
    }
    if (job->method != FILTER_AUTO) {
        snprintf(why, n, "filter.method asks for it");
        return job->method == FILTER_SHEARED ? SHADOW_FILTER_SHEARED : SHADOW_FILTER_AXIS_ALIGNED;
    }
    const char *plural = samples > 1 ? "s" : "";
    double cost = relative_cost(job, plan, rectangles, samples);
    if (cost > COST_MAX) {
        snprintf(why, n,
                 "%u sample%s a light: sheared filtering would cost about %.1f times what "
                 "tracing does, above %.0f",
                 samples, plural, cost, COST_MAX);
        return SHADOW_FILTER_AXIS_ALIGNED;
    }
    snprintf(why, n, "%u sample%s a light: filtering along the slopes of shadows needs the fewest",
             samples, plural);
    return SHADOW_FILTER_SHEARED;
}

static enum filter_method method_of(uint32_t filter)
{
    if (filter == SHADOW_FILTER_SHEARED) return FILTER_SHEARED;
    return filter == SHADOW_FILTER_AXIS_ALIGNED ? FILTER_AXIS_ALIGNED : FILTER_NONE;
}

/* Reports that the filter which was asked for does not run. */
static void tell_none(const struct job *job, struct plan_report *report)
{
    plan_skip(report, "filter", "%.*s", (int)PLAN_WHY_BYTES - 1, report->filter_why);
    if (job->method == FILTER_SHEARED || job->method == FILTER_AXIS_ALIGNED)
        plan_warn(report, "filter.method is %s, but shadows are not filtered: %s",
                  filter_method_name(job->method), report->filter_why);
}

void plan_filter(const struct job *job, struct plan *plan, struct plan_report *report)
{
    plan->shadow_filter = plan_choose_filter(job, plan, report->filter_why);
    report->method = method_of(plan->shadow_filter);
    if (plan->shadow_filter == SHADOW_FILTER_NONE) tell_none(job, report);
}

void plan_filter_none(const struct job *job, const char *why, struct plan_report *report)
{
    report->method = FILTER_NONE;
    snprintf(report->filter_why, sizeof report->filter_why, "%s", why);
    tell_none(job, report);
}
