/* Open Image Denoise takes a whole picture and gives one back: what it cannot go together with. */
#include "proto/job/job_internal.h"

static const char *obstacle_to_oidn(const struct job *job)
{
    if (job->target_error > 0.0f)
        return "oidn does not know its error, which sampling.target_error asks for: leave one out";
    if (job->layers & LAYER_ERROR)
        return "oidn does not know its error, which the layer error asks for: leave one out";
    if (job->composite.on)
        return "oidn filters one picture, and photographs are composed with three: take auto";
    return NULL;
}

int job_oidn_check(struct json_cursor *at, const struct job *job)
{
    const int64_t pixels = (int64_t)job->width_px * job->height_px;
    const char *obstacle = obstacle_to_oidn(job);
    if (job->residual != RESIDUAL_OIDN || (!obstacle && pixels <= LIMIT_OIDN_PIXELS)) return 0;
    json_cursor_enter(at, "filter");
    if (obstacle) return json_cursor_refuse_member(at, "residual", ERR_UNSUPPORTED, "%s", obstacle);
    return json_cursor_refuse_member(at, "residual", ERR_LIMIT,
                                     "oidn takes at most %d pixels, not %lld", LIMIT_OIDN_PIXELS,
                                     (long long)pixels);
}
