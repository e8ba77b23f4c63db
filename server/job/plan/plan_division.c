/* How light fields and paths divide the light of a scene that fields alone do not cover: by lobe,
 * and by light. */
#include "server/job/plan/plan_parts.h"

/* Fields of diffuse lobes beside paths keep some bias, and whole paths converge
 * (docs/reconstruction.md, Division of lobes and Division by light). psnr_db by fields and paths,
 * and by whole paths, at 16, 36 and 64 samples: blocks of glTF's default material 49.2 and 48.1,
 * 50.2 and 50.7, 50.8 and 53.1; beside a constant sky they cross there, too. */
#define DIVIDED_MAX 36

/* Maps and odd emitters are noise for longer: at 100 samples blocks have 51.9 and 49.4 beside a
 * map, 47.7 and 47.4 beside a ball that shines. */
#define DIVIDED_NOISY_MAX 100

/* Paths take each light without area exactly, too: spheres under a sun and a map have 34.7 and 34.5
 * at 4 samples, 37.6 and 37.5 at 16, 40.1 and 40.2 at 36. */
#define DIVIDED_POINTS_MAX 16

/* Returns whether something shines besides the lights of the list. */
static bool shines_beside(const struct plan *plan, const struct plan_report *report)
{
    return plan->environment.kind != ENVIRONMENT_NONE || report->emitters.flux > 0;
}

static uint32_t most_samples(const struct plan *plan, const struct plan_report *report)
{
    const bool noisy = plan->environment.kind == ENVIRONMENT_MAP || report->emitters.flux > 0;
    if (shines_beside(plan, report) && !plan_has_rectangle(plan)) return DIVIDED_POINTS_MAX;
    return noisy ? DIVIDED_NOISY_MAX : DIVIDED_MAX;
}

/* Returns whether there is what both divisions ask for: that no filter is named that would change
 * who brings what, and that rectangles' light is filtered, in a picture whose paths are. Volumes
 * dim paths alone. */
static bool is_possible(const struct job *job, const struct plan *plan,
                        const struct plan_report *report)
{
    const bool asked = job->indirect != INDIRECT_AUTO || job->glossy != GLOSSY_AUTO ||
                       plan_asks_for_sky(job, plan);
    const uint32_t l = job_strata_per_axis(job->spp);
    char why[PLAN_FILTER_WHY_BYTES];
    return !asked && !report->volumes && l * l <= most_samples(plan, report) &&
           plan->light_count > 0 && !(job->target_error > 0.0f) &&
           (l == 1 || plan_residual_possible(job, report)) &&
           (!plan_has_rectangle(plan) || plan_choose_filter(job, plan, why) != SHADOW_FILTER_NONE);
}

bool plan_divides(const struct job *job, const struct plan *plan, struct plan_report *report)
{
    const bool beside = shines_beside(plan, report);
    /* Unlit surfaces light others along bounce rays alone, where paths do not. */
    const bool unlit = !beside && report->emitters.any_unlit && job->indirect_bounces == 0;
    if (unlit || !is_possible(job, plan, report)) return false;
    report->by_lobe = true;
    report->by_light = beside;
    /* The filter of paths makes more of indirect light than fields beside them do, by 1.6 and 1.9
     * dB at 4 samples in two scenes. */
    report->whole_paths = beside && plan_residual_possible(job, report);
    return true;
}
