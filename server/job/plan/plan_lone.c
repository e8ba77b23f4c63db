/* Whether sub-samples that no pixel around them shows are shaded on their own. */
#include "proto/samples.h"
#include "server/job/plan/plan.h"

void plan_lone(struct plan *plan, struct plan_report *report)
{
    static const char what[] = "lone sub-samples";
    if (plan->camera.aperture_radius > 0.0f)
        plan_skip(report, what, "the camera has a lens: its samples make the picture");
    else if (plan->sub_samples == 0)
        plan_skip(report, what, "there are no sub-samples: paths go through all of a pixel");
    else if (lone_parts(plan) == 0)
        plan_skip(report, what, "no light field lights them");
    else if ((plan->planes & PLANES_COMPARED) != PLANES_COMPARED)
        plan_skip(report, what, "nothing compares them with the pixels around");
    else
        plan->planes |= PLANE_BIT(LONE);
}
