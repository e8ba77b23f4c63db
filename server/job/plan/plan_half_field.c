/* Light fields at half resolution. */
#include <stdio.h>

#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

bool plan_may_halve(const struct job *job)
{
    return job->field_scale == FIELD_SCALE_HALF && !(job->aperture_radius > 0.0f) &&
           !(job->target_error > 0.0f);
}

/* Returns why fields have rays in all pixels, whatever the job asks for; NULL: they need not. */
static const char *obstacle_of(const struct plan *plan)
{
    const uint32_t filter = plan->indirect_filter;
    if (!(plan->planes & PLANES_BOUNCE_RAYS)) return "no light field has bounce rays";
    if (plan->planes & PLANES_LENS_ALL) return "lens samples take light of all pixel centres";
    if (plan_has_rounds(plan)) return "pixels get more rays by what they have";
    if (filter != INDIRECT_FILTER_CONSTANT && filter != INDIRECT_FILTER_LINEAR)
        return "only filter.indirect constant and linear share rays so";
    return NULL;
}

void plan_half_field(const struct job *job, struct plan *plan, struct plan_report *report)
{
    const char *obstacle = obstacle_of(plan);
    plan->field_halved = plan_may_halve(job) && !obstacle;
    if (job->field_scale == FIELD_SCALE_HALF && obstacle)
        plan_warn(report, "sampling.field_scale is 0.5, but fields have rays in all pixels: %s",
                  obstacle);
}
