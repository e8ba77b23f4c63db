/* Plans whether frames use samples of the frames beside them, and of how many. */
#include <stdio.h>

#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"
#include "server/reconstruct/residual/residual_history.h"

#define PLANES_FIND (PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID))

/* What auto takes. */
#define FRAMES_AUTO 2u

/* Says why a plan cannot; NULL: it can. */
static const char *obstacle_of(const struct job *job, const struct plan *plan)
{
    if (job_frame_count(job) < 2) return "the job has one frame";
    if (job->temporal == TEMPORAL_NONE) return "filter.temporal is none";
    if (plan->residual_filter == RESIDUAL_FILTER_NONE)
        return "the residual filter, which uses them, does not run";
    if (plan->paths.spp < 2) return "one path a pixel has no halves of its own";
    if (plan->residual_filter == RESIDUAL_FILTER_OIDN) return "filter.residual is oidn";
    if (plan->lens_strata_per_axis > 0) return "samples of a lens are filtered by themselves";
    if (plan_has_rounds(plan)) return "the samples of tiles differ between frames";
    return NULL;
}

/* Returns the bytes of the frames that are in work at once: as many as wait for others and one
 * more, with all their samples, and the histories of the window. */
static uint64_t window_bytes(const struct plan *plan, uint32_t frames)
{
    struct samples_layout layout;
    const int32_t side = LIMIT_TILE_SIDE_MIN_PX;
    const uint64_t pixels = (uint64_t)plan->width_px * (uint64_t)plan->height_px;
    if (samples_layout_init(&layout, plan, 0, side, side) != 0) return UINT64_MAX;
    const uint64_t each = layout.total_bytes / (LIMIT_TILE_SIDE_MIN_PX * LIMIT_TILE_SIDE_MIN_PX);
    return plan_views(plan) * pixels *
           ((frames + 2) * each + (2 * (uint64_t)frames + 2) * residual_history_pixel_bytes());
}

uint64_t plan_window_bytes(const struct plan *plan)
{
    return plan->temporal > 0 ? window_bytes(plan, plan->temporal) : 0;
}

void plan_temporal_none(const char *why, struct plan *plan, struct plan_report *report)
{
    plan->temporal = 0;
    snprintf(report->temporal_why, PLAN_FILTER_WHY_BYTES, "%s", why);
}

/* As many frames of those asked for as fit; the planes count, and stay if there are any. */
static uint32_t fit(uint32_t frames, struct plan *plan)
{
    const uint64_t others = plan->planes;
    plan->planes |= PLANES_FIND;
    while (frames > 0 && window_bytes(plan, frames) > LIMIT_WINDOW_BYTES) frames--;
    if (frames == 0) plan->planes = others;
    return frames;
}

/* What is asked for by name, runs. */
static bool asks_for_fields(const struct job *job, const struct plan *plan)
{
    return job->method != FILTER_AUTO || job->indirect != INDIRECT_AUTO ||
           job->glossy != GLOSSY_AUTO || job->lens != LENS_AUTO || job->light_spp > 0 ||
           job->indirect_spp > 0 || job->lens_spp > 0 || job->lens_extra > 0 ||
           plan_may_halve(job) || plan_asks_for_sky(job, plan);
}

/* Returns whether frames have their neighbours in memory, as far as it is known before planes of
 * layers are: it is no fault if they have not after all. */
static bool may_fit(const struct job *job, const struct plan *plan)
{
    struct plan whole = *plan;
    whole.planes |= PLANES_RESIDUAL_READ | PLANES_FIND | PLANE_BIT(PATH_RADIANCE);
    whole.paths.spp = job->spp;
    return window_bytes(&whole, 1) <= LIMIT_WINDOW_BYTES;
}

bool plan_prefers_window(const struct job *job, const struct plan *plan,
                         const struct plan_report *report, char why[PLAN_WHY_BYTES])
{
    if (!job_may_be_temporal(job) || !job_frames_follow(job) || job->spp < 2 ||
        asks_for_fields(job, plan) || !plan_residual_possible(job, report) || !may_fit(job, plan))
        return false;
    snprintf(why, PLAN_WHY_BYTES,
             "frames lend each other samples of paths, which flicker less than light fields then");
    return true;
}

void plan_temporal(const struct job *job, struct plan *plan, struct plan_report *report)
{
    char why[PLAN_FILTER_WHY_BYTES];
    const char *obstacle = obstacle_of(job, plan);
    const bool named = job->temporal == TEMPORAL_ONE || job->temporal == TEMPORAL_TWO;
    const uint32_t asked = job->temporal == TEMPORAL_ONE   ? 1
                           : job->temporal == TEMPORAL_TWO ? 2
                                                           : FRAMES_AUTO;
    if (obstacle) {
        plan_temporal_none(obstacle, plan, report);
        if (named && job_frame_count(job) > 1)
            plan_warn(report, "filter.temporal is %u, but frames are filtered one by one: %s",
                      asked, obstacle);
        return;
    }
    plan->temporal = fit(asked, plan);
    snprintf(why, sizeof why, "more frames of this size would keep more than %llu bytes in memory",
             LIMIT_WINDOW_BYTES);
    snprintf(report->temporal_why, sizeof report->temporal_why, "%s",
             plan->temporal < asked ? why
             : named                ? "filter.temporal asks for them"
                                    : "frames beside it have samples of the same light");
}
