/* Pixels where surfaces meet: lone sub-samples, mixed pixels, and paths at edges. */
#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

/* Up to so many paths a pixel, edges have four times as many; beyond, twice as many. */
#define EDGES_FOURFOLD_MAX 4u

void plan_lone(struct plan *plan, struct plan_report *report)
{
    static const char what[] = "lone sub-samples";
    if (plan->camera.aperture_radius > 0.0f)
        plan_skip(report, what, "the camera has a lens: its samples make the picture");
    else if (plan->sub_samples == 0)
        plan_skip(report, what, "there are no sub-samples: paths go through all of a pixel");
    else if (lone_parts(plan) == 0)
        plan_skip(report, what, "no light field brings their light");
    else if ((plan->planes & PLANES_COMPARED) != PLANES_COMPARED)
        plan_skip(report, what, "nothing compares them with the pixels around");
    else
        plan->planes |= PLANE_BIT(LONE);
}

/* Whole paths are filtered and mixed: centres tell which pixels show several surfaces. */
static void plan_mixed_paths(const char *what, struct plan *plan, struct plan_report *report)
{
    const bool whole = report->whole_paths || report->integrator == INTEGRATOR_PATHS;
    if (!whole || plan->residual_filter == RESIDUAL_FILTER_NONE)
        plan_skip(report, what, "paths go through all of a pixel");
    else
        plan->planes |= PLANES_CENTRE | PLANE_BIT(MIXED);
}

/* A tenth of the pixels, at edges, has half of the squared error: more paths there are worth more
 * than more of them everywhere (docs/reconstruction.md, Paths at edges). */
static void plan_edges(struct plan *plan)
{
    if (plan->paths.spp == 0) return;
    plan->paths.edge_digits = plan->paths.spp <= EDGES_FOURFOLD_MAX ? 2 : 1;
}

void plan_mixed(struct plan *plan, struct plan_report *report)
{
    static const char what[] = "mixed pixels";
    if (plan_has_shutter(plan)) {
        plan_skip(report, what, "shares of surfaces differ from time to time");
        return;
    }
    if (plan->camera.aperture_radius > 0.0f)
        plan_skip(report, what, "the camera has a lens: its samples make the picture");
    else if (plan->paths.spp > 0 && !report->by_lobe)
        plan_mixed_paths(what, plan, report);
    else if (plan->sub_samples == 0)
        plan_skip(report, what, "there are no sub-samples");
    else if ((plan->planes & PLANES_COMPARED) != PLANES_COMPARED)
        plan_skip(report, what, "nothing compares pixels with those around");
    else
        plan->planes |= PLANE_BIT(MIXED);
    if (plan->planes & PLANE_BIT(MIXED)) plan_edges(plan);
}
