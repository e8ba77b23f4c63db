/* Plans the time that the shutter is open. */
#include <string.h>

#include "server/job/plan/plan_parts.h"

/* Says why samples are all of one moment; NULL: they are not. */
static const char *obstacle_of(const struct job *job, const struct scene *scene, bool camera_moves)
{
    if (!(job->shutter_fraction > 0.0f)) return "camera.shutter is none";
    if (job->stands) return "scene.time_s makes the scene stand";
    if (!(scene->info->flags & SCENE_MOVES)) return "the scene has no animation";
    if (scene->count[SCENE_MOVERS] > 0 || camera_moves) return NULL;
    return "nothing moves while the shutter is open, or things appear meanwhile";
}

void plan_shutter(const struct job *job, const struct scene *scene, struct plan *plan,
                  struct plan_report *report)
{
    const char *obstacle = obstacle_of(job, scene, plan_find_poses(job, scene, plan));
    if (obstacle) {
        plan_skip(report, "effect motion_blur", "%s", obstacle);
        memset(plan->poses, 0, sizeof plan->poses);
        return;
    }
    plan->pose_count = SHUTTER_STEPS;
    plan->capabilities |= CAPABILITY_SHUTTER;
    report->effects |= EFFECT_MOTION_BLUR;
}
