/* Plans the residual filter of paths: whether it runs, and the planes that it reads. */
#include <stdio.h>

#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

#define LAYERS_FILTERED (LAYER_BEAUTY | LAYER_DIFFUSE_DIRECT | LAYER_DIFFUSE_INDIRECT)

bool plan_residual_possible(const struct job *job, const struct plan_report *report)
{
    if (job->residual == RESIDUAL_OIDN) return (report->layers & LAYER_BEAUTY) != 0;
    return job->residual != RESIDUAL_NONE && (report->layers & LAYERS_FILTERED) != 0;
}

static uint32_t choose_oidn(const struct plan_report *report, char why[PLAN_FILTER_WHY_BYTES])
{
    const bool shown = (report->layers & LAYER_BEAUTY) != 0;
    snprintf(why, PLAN_FILTER_WHY_BYTES, "%s",
             shown ? "filter.residual is oidn, whose bytes differ from machine to machine"
                   : "oidn filters the layer beauty alone");
    return shown ? RESIDUAL_FILTER_OIDN : RESIDUAL_FILTER_NONE;
}

static uint32_t choose(const struct job *job, const struct plan_report *report,
                       char why[PLAN_FILTER_WHY_BYTES])
{
    const size_t n = PLAN_FILTER_WHY_BYTES;
    if (job->residual == RESIDUAL_OIDN) return choose_oidn(report, why);
    if (job->residual == RESIDUAL_NONE)
        snprintf(why, n, "filter.residual is none");
    else if (job->residual == RESIDUAL_AUTO &&
             (job->method == FILTER_NONE || job->method == FILTER_AVERAGE))
        snprintf(why, n, "filter.method is %s", filter_method_name(job->method));
    else if (!(report->layers & LAYERS_FILTERED))
        snprintf(why, n, "no layer shows what it filters");
    else {
        snprintf(why, n,
                 job->residual == RESIDUAL_AUTO
                     ? "light that no light field covers comes along paths and is noisy"
                     : "filter.residual is halves");
        return RESIDUAL_FILTER_HALVES;
    }
    return RESIDUAL_FILTER_NONE;
}

void plan_residual(const struct job *job, struct plan *plan, struct plan_report *report)
{
    plan->residual_filter = choose(job, report, report->residual_filter_why);
    if (plan->residual_filter == RESIDUAL_FILTER_NONE) return;
    if (plan->residual_filter == RESIDUAL_FILTER_OIDN) {
        plan->planes |= PLANES_OIDN_READ;
        return;
    }
    plan->planes |= PLANES_RESIDUAL_READ;
    /* Surfaces with normal maps are paths' alone. */
    if (plan->paths.without_diffuse_indirect && !(report->by_lobe && report->bumpy)) return;
    if (plan->bounces > 0 || (report->layers & LAYER_DIFFUSE_INDIRECT))
        plan->planes |= PLANE_BIT(PATH_HALF_INDIRECT) | PLANE_BIT(PATH_DIFFUSE_INDIRECT);
}

void plan_residual_none(struct plan_report *report)
{
    snprintf(report->residual_filter_why, PLAN_FILTER_WHY_BYTES, "no light comes along paths");
}

const char *plan_residual_filter_name(uint32_t filter)
{
    if (filter == RESIDUAL_FILTER_OIDN) return residual_method_name(RESIDUAL_OIDN);
    return filter == RESIDUAL_FILTER_HALVES ? residual_method_name(RESIDUAL_HALVES) : "none";
}
