/* What members of a job document ask of each other. Cursors stand at the root. */
#include "proto/job/job_internal.h"
#include "proto/scene/matte.h"

#define TARGET_MIN 1e-5f

#define LAYERS_PER_STRATUM (LAYER_VISIBILITY | LAYER_SLOPE_MIN | LAYER_SLOPE_MAX)

/* Open Image Denoise takes a whole picture and gives one back. */
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

static int check_oidn(struct json_cursor *at, const struct job *job)
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

/* What layers ask of other members. */
static int check_layers(struct json_cursor *at, const struct job *job)
{
    const uint32_t spp = job->light_spp ? job->light_spp : job->spp;
    const uint32_t l_max = LIMIT_PLANE_STRATA_PER_AXIS;
    if ((job->layers & LAYERS_PER_STRATUM) && spp > l_max * l_max) {
        json_cursor_enter(at, "sampling");
        return json_cursor_refuse_member(
            at, job->light_spp ? "light_spp" : "spp", ERR_RANGE,
            "%u is above %u, the most with layers visibility and slope", spp, l_max * l_max);
    }
    if ((job->layers & LAYER_FILTER_WIDTH) && job->method == FILTER_NONE) {
        json_cursor_enter(at, "filter");
        return json_cursor_refuse_member(
            at, "method", ERR_RANGE, "none filters nothing that the layer filter_width could show");
    }
    if ((job->layers & LAYER_OCCLUSION) && !(job->occlusion_distance > 0.0f)) {
        json_cursor_enter(at, "effects");
        return json_cursor_refuse_member(
            at, "ambient_occlusion", ERR_MISSING,
            "the layer occlusion needs {\"distance\": ...}: how far to look, in scene units");
    }
    if ((job->layers & LAYERS_CRYPTO) && job->exr_compression == EXR_CODEC_DWAA) {
        json_cursor_enter(at, "image");
        return json_cursor_refuse_member(
            at, "exr_compression", ERR_RANGE,
            "dwaa changes numbers, and ids of the layers " MATTE_OBJECT_LAYER
            " and " MATTE_MATERIAL_LAYER " must stay what they are");
    }
    return 0;
}

/* Checks a stop at a target error. */
static int check_target(struct json_cursor *at, const struct job *job)
{
    const uint32_t indirect = job->indirect_spp ? job->indirect_spp : job->spp;
    const uint32_t most = job->spp > indirect ? job->spp : indirect;
    if (job->target_error == 0.0f && job->max_spp == 0) return 0;
    const size_t length = json_cursor_enter(at, "sampling");
    if (job->target_error == 0.0f)
        return json_cursor_refuse_member(at, "target_error", ERR_MISSING,
                                         "max_spp is the most that a target_error may take");
    if (!(job->target_error >= TARGET_MIN))
        return json_cursor_refuse_member(at, "target_error", ERR_RANGE, "%.9g is below %g",
                                         (double)job->target_error, (double)TARGET_MIN);
    if (job->spp < JOB_TARGET_SPP_MIN || indirect < JOB_TARGET_SPP_MIN)
        return json_cursor_refuse_member(
            at, job->indirect_spp ? "indirect_spp" : "spp", ERR_RANGE,
            "fewer than %d samples tell too little of their error to aim at one",
            JOB_TARGET_SPP_MIN);
    if (job->max_spp < most)
        return json_cursor_refuse_member(at, "max_spp", ERR_RANGE,
                                         "%u is below the %u samples that sampling begins with",
                                         job->max_spp, most);
    json_cursor_leave(at, length);
    if (job->layers & LAYER_BEAUTY) return 0;
    return json_cursor_refuse_member(at, "layers", ERR_MISSING,
                                     "sampling.target_error is of the layer beauty");
}

/* Rays that are dealt out by what the first of them met tell nothing of their error. */
static int check_adaptive(struct json_cursor *at, const struct job *job)
{
    const bool target = job->target_error > 0.0f, error = job->layers & LAYER_ERROR;
    if (job->indirect != INDIRECT_ADAPTIVE || (!target && !error)) return 0;
    json_cursor_enter(at, "filter");
    return json_cursor_refuse_member(at, "indirect", ERR_UNSUPPORTED,
                                     "adaptive sampling does not know its error, which %s asks for",
                                     target ? "sampling.target_error" : "the layer error");
}

/* Refuses what makes no sense for a picture that begins anew with each move of the camera. */
static int check_live(struct json_cursor *at, const struct job *job)
{
    if (!job->live) return 0;
    if (job->shutter_fraction > 0.0f) {
        json_cursor_enter(at, "camera");
        return json_cursor_refuse_member(at, "shutter", ERR_UNSUPPORTED,
                                         "a live job shows single moments: leave it out");
    }
    if (job_frame_count(job) > 1)
        return json_cursor_refuse_member(
            at, "frames", ERR_UNSUPPORTED,
            "a live job has one frame, not %u: its camera is moved by hand", job_frame_count(job));
    if (!(job->target_error > 0.0f)) return 0;
    json_cursor_enter(at, "sampling");
    return json_cursor_refuse_member(
        at, "target_error", ERR_UNSUPPORTED,
        "a live job begins anew with each move and aims at no error: give spp");
}

int job_relations_check(struct json_cursor *at, const struct job *job)
{
    const int64_t pixels = (int64_t)job->width_px * job->height_px;
    if (pixels > LIMIT_IMAGE_PIXELS) {
        json_cursor_enter(at, "image");
        return json_cursor_refuse(at, ERR_LIMIT, "%lld pixels are above the limit of %d",
                                  (long long)pixels, LIMIT_IMAGE_PIXELS);
    }
    if (!(job->mu > 0.0f)) {
        json_cursor_enter(at, "filter");
        return json_cursor_refuse_member(at, "mu", ERR_RANGE, "%g is not above 0", (double)job->mu);
    }
    int error = check_target(at, job);
    if (!error) error = check_adaptive(at, job);
    if (!error) error = check_oidn(at, job);
    if (!error) error = check_live(at, job);
    if (!error) error = job_composite_check(at, job);
    return error ? error : check_layers(at, job);
}
