#include "proto/job/job.h"

#include <stdlib.h>
#include <string.h>

#include "proto/job/job_internal.h"
#include "proto/scene/matte.h"

const struct json_choice job_layer_words[] = {
    {"beauty", LAYER_BEAUTY, NULL},
    {"direct", LAYER_DIRECT, NULL},
    {"indirect", LAYER_INDIRECT, NULL},
    {"albedo", LAYER_ALBEDO, NULL},
    {"normal", LAYER_NORMAL, NULL},
    {"depth", LAYER_DEPTH, NULL},
    {"samples", LAYER_SAMPLES, NULL},
    {"visibility", LAYER_VISIBILITY, NULL},
    {"slope_min", LAYER_SLOPE_MIN, NULL},
    {"slope_max", LAYER_SLOPE_MAX, NULL},
    {"emission", LAYER_EMISSION, NULL},
    {"id", LAYER_ID, NULL},
    {"filter_width", LAYER_FILTER_WIDTH, NULL},
    {"error", LAYER_ERROR, NULL},
    {"occlusion", LAYER_OCCLUSION, NULL},
    {"diffuse_direct", LAYER_DIFFUSE_DIRECT, NULL},
    {"diffuse_indirect", LAYER_DIFFUSE_INDIRECT, NULL},
    {"motion.backward", LAYER_MOTION_BACKWARD, NULL},
    {"motion.forward", LAYER_MOTION_FORWARD, NULL},
    {"composite", LAYER_COMPOSITE, NULL},
    {"catcher", LAYER_CATCHER, NULL},
    {"overlay", LAYER_OVERLAY, NULL},
    {MATTE_OBJECT_LAYER, LAYER_CRYPTO_OBJECT, NULL},
    {MATTE_MATERIAL_LAYER, LAYER_CRYPTO_MATERIAL, NULL},
    {"backplate", LAYER_BACKPLATE, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_method_words[] = {
    {"auto", FILTER_AUTO, NULL},
    {"sheared", FILTER_SHEARED, NULL},
    {"axis_aligned", FILTER_AXIS_ALIGNED, NULL},
    {"average", FILTER_AVERAGE, NULL},
    {"none", FILTER_NONE, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_environment_words[] = {
    {"auto", ENVIRONMENT_AUTO, NULL},
    {"average", ENVIRONMENT_AVERAGE, NULL},
    {"axis_aligned", ENVIRONMENT_AXIS_ALIGNED, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_indirect_words[] = {
    {"auto", INDIRECT_AUTO, NULL},         {"average", INDIRECT_AVERAGE, NULL},
    {"constant", INDIRECT_CONSTANT, NULL}, {"linear", INDIRECT_LINEAR, NULL},
    {"blend", INDIRECT_BLEND, NULL},       {"adaptive", INDIRECT_ADAPTIVE, NULL},
    {"sheared", INDIRECT_SHEARED, NULL},   {NULL, 0, NULL},
};

const struct json_choice job_glossy_words[] = {
    {"auto", GLOSSY_AUTO, NULL},
    {"average", GLOSSY_AVERAGE, NULL},
    {"virtual_hit", GLOSSY_VIRTUAL_HIT, NULL},
    {"bandlimit", GLOSSY_BANDLIMIT, NULL},
    {"sg", GLOSSY_SG, NULL},
    {"sg_mixture", GLOSSY_SG_MIXTURE, NULL},
    {"asg", GLOSSY_ASG, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_residual_words[] = {
    {"auto", RESIDUAL_AUTO, NULL},
    {"none", RESIDUAL_NONE, NULL},
    {"halves", RESIDUAL_HALVES, NULL},
    {"oidn", RESIDUAL_OIDN, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_temporal_words[] = {
    {"auto", TEMPORAL_AUTO, NULL},
    {"none", TEMPORAL_NONE, NULL},
    {"1", TEMPORAL_ONE, NULL},
    {"2", TEMPORAL_TWO, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_lens_words[] = {
    {"auto", LENS_AUTO, NULL},
    {"average", LENS_AVERAGE, NULL},
    {"axis_aligned", LENS_AXIS_ALIGNED, NULL},
    {"sheared", LENS_SHEARED, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_pixel_type_words[] = {
    {"float", PIXEL_FLOAT, NULL},
    {"half", PIXEL_HALF, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_view_words[] = {
    {"front", JOB_VIEW_FRONT, NULL},
    {"three_quarter", JOB_VIEW_THREE_QUARTER, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_pixel_filter_words[] = {
    {"box", PIXEL_FILTER_BOX, NULL},
    {"tent", PIXEL_FILTER_TENT, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_exr_codec_words[] = {
    {"none", EXR_CODEC_NONE, NULL}, {"zips", EXR_CODEC_ZIPS, NULL}, {"zip", EXR_CODEC_ZIP, NULL},
    {"piz", EXR_CODEC_PIZ, NULL},   {"dwaa", EXR_CODEC_DWAA, NULL}, {NULL, 0, NULL},
};

const struct json_choice job_view_curve_words[] = {
    {"linear", VIEW_LINEAR, NULL},
    {"filmic", VIEW_FILMIC, NULL},
    {"agx", VIEW_AGX, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_light_type_words[] = {
    {"point", LIGHT_POINT, NULL},
    {"spot", LIGHT_SPOT, NULL},
    {"directional", LIGHT_DIRECTIONAL, NULL},
    {"rectangle", LIGHT_RECTANGLE, NULL},
    {NULL, 0, NULL},
};

const struct json_choice job_profile_words[] = {
    {"uniform", PROFILE_UNIFORM, NULL},
    {"gaussian", PROFILE_GAUSSIAN, NULL},
    {NULL, 0, NULL},
};

_Static_assert(INDIRECT_ADAPTIVE - INDIRECT_AVERAGE == INDIRECT_FILTER_ADAPTIVE &&
                   INDIRECT_SHEARED - INDIRECT_AVERAGE == INDIRECT_FILTER_SHEARED &&
                   GLOSSY_ASG - GLOSSY_AVERAGE == GLOSSY_FILTER_ASG &&
                   LENS_SHEARED - LENS_AVERAGE == LENS_FILTER_SHEARED,
               "the plan's filters are in the order of the job's");

const char *job_word(const struct json_choice *words, uint32_t value)
{
    for (; words->name; words++)
        if (words->value == value) return words->name;
    return NULL;
}

const char *layer_name(enum layer layer)
{
    return job_word(job_layer_words, layer);
}

uint32_t layer_from_name(const char *name)
{
    for (const struct json_choice *w = job_layer_words; w->name; w++)
        if (strcmp(w->name, name) == 0) return w->value;
    return 0;
}

bool view_curve_from_name(const char *name, enum view_curve *out)
{
    for (const struct json_choice *w = job_view_curve_words; w->name; w++) {
        if (strcmp(w->name, name) != 0) continue;
        *out = (enum view_curve)w->value;
        return true;
    }
    return false;
}

const char *view_curve_name(enum view_curve curve)
{
    return job_word(job_view_curve_words, curve);
}

const char *filter_method_name(enum filter_method method)
{
    return job_word(job_method_words, method);
}

const char *environment_method_name(enum environment_method method)
{
    return job_word(job_environment_words, method);
}

const char *indirect_method_name(enum indirect_method method)
{
    return job_word(job_indirect_words, method);
}

const char *glossy_method_name(enum glossy_method method)
{
    return job_word(job_glossy_words, method);
}

const char *residual_method_name(enum residual_method method)
{
    return job_word(job_residual_words, method);
}

const char *temporal_method_name(enum temporal_method method)
{
    return job_word(job_temporal_words, method);
}

const char *lens_method_name(enum lens_method method)
{
    return job_word(job_lens_words, method);
}

bool job_may_be_temporal(const struct job *job)
{
    return job->temporal != TEMPORAL_NONE && job_frame_count(job) > 1 &&
           job->residual != RESIDUAL_NONE && job->residual != RESIDUAL_OIDN &&
           !(job->target_error > 0.0f) && !job->live;
}

uint32_t job_strata_per_axis(uint32_t spp)
{
    uint32_t l = 1;
    while (l * l < spp && l < LIMIT_STRATA_PER_AXIS) l++;
    return l;
}

void job_fini(struct job *job)
{
    for (uint32_t i = 0; i < job->file_count; i++) free(job->files[i].path);
    free(job->files);
    job->files = NULL;
    job->file_count = 0;
    job_composite_fini(&job->composite);
    job_marks_fini(&job->marks);
}

int job_copy(const struct job *job, struct job *out)
{
    *out = *job;
    out->file_count = 0;
    out->files = calloc((size_t)job->file_count + 1, sizeof *out->files);
    for (uint32_t i = 0; out->files && i < job->file_count; i++) {
        out->files[i].asset = job->files[i].asset;
        out->files[i].path = strdup(job->files[i].path);
        if (!out->files[i].path) break;
        out->file_count++;
    }
    int error = job_marks_copy(&job->marks, &out->marks);
    const int composite_error = job_composite_copy(&job->composite, &out->composite);
    if (composite_error) error = composite_error;
    if (!error && out->files && out->file_count == job->file_count) return 0;
    job_fini(out);
    return ERR_MEMORY;
}
