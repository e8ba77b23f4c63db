/* The job document's tables. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job_internal.h"

#define SEED_MAX   9007199254740992.0 /* 2^53: exact in every JSON reader */
#define FPS_MIN    0.001
#define FPS_MAX    1000
#define TARGET_MAX 1000.0

/* What Blender calls both layers of motion together. */
#define MOTION_ALIAS "vector"

#define JOB(member) offsetof(struct job, member)

static int read_file(struct json_cursor *at, const char *path, const json_t *v, struct job *job)
{
    struct job_file *file = &job->files[job->file_count];
    if (!relative_path_is_inside(path))
        return json_cursor_refuse(at, ERR_RANGE,
                                  "the path does not stay inside the scene's folder");
    const int error = json_cursor_digest(at, v, &file->asset);
    if (error) return error;
    file->path = strdup(path);
    if (!file->path) return json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
    job->file_count++;
    return 0;
}

static int file_order(const void *a, const void *b)
{
    return strcmp(((const struct job_file *)a)->path, ((const struct job_file *)b)->path);
}

static int read_files(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    struct job *job = o;
    const char *path;
    json_t *child;
    int error = json_cursor_expect(at, v, JSON_OBJECT, "an object of digests");
    (void)m;
    if (error) return error;
    const size_t count = json_object_size(v);
    if (count > LIMIT_SCENE_FILES)
        return json_cursor_refuse(at, ERR_LIMIT, "%zu files are above the limit of %d", count,
                                  LIMIT_SCENE_FILES);
    if (count == 0) return 0;
    job->files = calloc(count, sizeof *job->files);
    if (!job->files) return json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
    json_object_foreach ((json_t *)(uintptr_t)v, path, child) {
        const size_t length = json_cursor_enter(at, path);
        error = read_file(at, path, child, job);
        if (error) return error;
        json_cursor_leave(at, length);
    }
    qsort(job->files, job->file_count, sizeof *job->files, file_order);
    return 0;
}

static const struct json_member occlusion_members[] = {{.name = "distance",
                                                        .read = json_member_f32,
                                                        .offset = JOB(occlusion_distance),
                                                        .min = 0,
                                                        .max = LIMIT_COORDINATE,
                                                        .required = true},
                                                       {.name = NULL}};

static int read_ambient_occlusion(struct json_cursor *at, const struct json_member *m,
                                  const json_t *v, void *o)
{
    struct job *job = o;
    (void)m;
    if (json_is_false(v)) return 0;
    if (json_is_true(v))
        return json_cursor_refuse(at, ERR_TYPE,
                                  "true does not say how far to look: give {\"distance\": ...}, in "
                                  "scene units, or false");
    int error = json_cursor_expect(at, v, JSON_OBJECT, "false or an object with a distance");
    if (!error) error = json_cursor_members(at, v, occlusion_members, job);
    if (!error && !(job->occlusion_distance > 0.0f))
        error = json_cursor_refuse_member(at, "distance", ERR_RANGE, "%.9g is not above 0",
                                          (double)job->occlusion_distance);
    return error;
}

static int read_layers(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o)
{
    static const struct json_member layer = {.read = json_member_choice,
                                             .choices = job_layer_words};
    uint32_t layers = 0;
    int error = json_cursor_expect(at, v, JSON_ARRAY, "an array of layer names");
    (void)m;
    if (error) return error;
    if (json_array_size(v) == 0) return json_cursor_refuse(at, ERR_RANGE, "it names no layer");
    for (size_t i = 0; i < json_array_size(v); i++) {
        uint32_t bits = 0;
        const json_t *name = json_array_get(v, i);
        const size_t length = json_cursor_enter_index(at, i);
        if (json_is_string(name) && strcmp(json_string_value(name), MOTION_ALIAS) == 0)
            bits = LAYERS_MOTION;
        else
            error = layer.read(at, &layer, name, &bits);
        if (error) return error;
        if (layers & bits)
            return json_cursor_refuse(at, ERR_EXISTS, "\"%s\" is named twice",
                                      json_string_value(name));
        layers |= bits;
        json_cursor_leave(at, length);
    }
    ((struct job *)o)->layers = layers;
    return 0;
}

/* Reads the name of a part of the scene, LIMIT_NAME_BYTES of it; null is none. */
static int read_name(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    if (json_is_null(v)) return 0;
    int error = json_cursor_expect(at, v, JSON_STRING, "a name or null");
    if (error) return error;
    if (json_string_length(v) == 0) return json_cursor_refuse(at, ERR_RANGE, "it names nothing");
    if (json_string_length(v) >= LIMIT_NAME_BYTES)
        return json_cursor_refuse(at, ERR_LIMIT, "a name of %zu bytes is above the limit of %d",
                                  json_string_length(v), LIMIT_NAME_BYTES - 1);
    memcpy((char *)o + m->offset, json_string_value(v), json_string_length(v) + 1);
    return 0;
}

static int read_f64(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    return json_cursor_number(at, v, m->min, m->max, (double *)(void *)((char *)o + m->offset));
}

/* null leaves the time to the frames. */
static int read_time(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    struct job *job = o;
    job->stands = !json_is_null(v);
    return job->stands ? read_f64(at, m, v, o) : 0;
}

#define NUMBER(member, reader, field, least, most)                                                 \
    {                                                                                              \
        .name = (member), .read = (reader), .offset = JOB(field), .min = (least), .max = (most)    \
    }
#define LATER(member, text)                                                                        \
    {                                                                                              \
        .name = (member), .read = json_member_unsupported, .sentence = (text)                      \
    }
#define WORD(member, field, words)                                                                 \
    {                                                                                              \
        .name = (member), .read = json_member_choice, .offset = JOB(field), .choices = (words)     \
    }

static const struct json_member scene_members[] = {
    {.name = "asset", .read = json_member_digest, .offset = JOB(scene), .required = true},
    {.name = "files", .read = read_files},
    {.name = "camera", .read = job_camera_read},
    {.name = "variant", .read = read_name, .offset = JOB(variant)},
    {.name = "animation", .read = read_name, .offset = JOB(animation)},
    NUMBER("time_s", read_time, time_s, -LIMIT_TIME_S, LIMIT_TIME_S),
    {.name = "moves", .read = job_moves_read},
    {.name = "lights", .read = json_member_bool, .offset = JOB(scene_lights)},
    {.name = "default_light", .read = json_member_bool, .offset = JOB(default_light)},
    WORD("default_camera", default_camera, job_view_words),
    LATER("file", "a file of yours: submit by command line, or upload it and give \"asset\""),
    {.name = NULL}};

static const struct json_member effects_members[] = {
    NUMBER("indirect_bounces", json_member_u32, indirect_bounces, 0, LIMIT_INDIRECT_BOUNCES),
    {.name = "ambient_occlusion", .read = read_ambient_occlusion},
    {.name = NULL}};

static const struct json_member sampling_members[] = {
    NUMBER("spp", json_member_u32, spp, 1, LIMIT_SPP),
    NUMBER("light_spp", json_member_u32, light_spp, 0, LIMIT_SPP),
    NUMBER("indirect_spp", json_member_u32, indirect_spp, 0, LIMIT_SPP),
    NUMBER("lens_spp", json_member_u32, lens_spp, 0, LIMIT_SPP),
    NUMBER("lens_extra", json_member_u32, lens_extra, 0,
           PLAN_LENS_EXTRA_STRATA *PLAN_LENS_EXTRA_STRATA),
    {.name = "field_scale", .read = job_field_scale_read},
    NUMBER("seed", json_member_u64, seed, 0, SEED_MAX),
    NUMBER("tile_px", json_member_i32, tile_px, LIMIT_TILE_SIDE_MIN_PX, LIMIT_TILE_SIDE_PX),
    NUMBER("target_error", json_member_f32, target_error, 0, TARGET_MAX),
    NUMBER("max_spp", json_member_u32, max_spp, 0, LIMIT_SPP),
    {.name = NULL}};

static const struct json_member filter_members[] = {
    WORD("method", method, job_method_words),
    WORD("environment", environment_filter, job_environment_words),
    WORD("indirect", indirect, job_indirect_words),
    WORD("glossy", glossy, job_glossy_words),
    WORD("lens", lens, job_lens_words),
    WORD("residual", residual, job_residual_words),
    WORD("temporal", temporal, job_temporal_words),
    NUMBER("mu", json_member_f32, mu, 0, LIMIT_FILTER_MU),
    {.name = NULL}};

#define OBJECT(member, table)                                                                      \
    {                                                                                              \
        .name = (member), .read = json_member_object, .members = (table)                           \
    }

static const struct json_member job_members[] = {
    {.name = "scene", .read = json_member_object, .members = scene_members, .required = true},
    OBJECT("image", job_image_members),
    {.name = "lights", .read = job_lights_read},
    {.name = "environment", .read = job_environment_read},
    OBJECT("camera", job_shutter_members),
    {.name = "lens", .read = job_lens_read},
    OBJECT("effects", effects_members),
    OBJECT("sampling", sampling_members),
    OBJECT("filter", filter_members),
    {.name = "layers", .read = read_layers},
    {.name = "frames", .read = job_frames_read},
    NUMBER("fps", read_f64, fps, FPS_MIN, FPS_MAX),
    NUMBER("start_time_s", read_f64, start_time_s, -LIMIT_TIME_S, LIMIT_TIME_S),
    NUMBER("priority", json_member_i32, priority, -LIMIT_PRIORITY, LIMIT_PRIORITY),
    {.name = "live", .read = json_member_bool, .offset = JOB(live)},
    {.name = "backplate", .read = job_plate_read},
    {.name = "rgbd", .read = job_rgbd_read},
    {.name = "catchers", .read = job_catchers_read},
    {.name = "holdouts", .read = job_holdouts_read},
    {.name = "composite", .read = job_composite_mode_read},
    {.name = "name", .read = job_name_read},
    {.name = "comment", .read = job_comment_read},
    {.name = "labels", .read = job_labels_read},
    {.name = "webhook", .read = job_webhook_read},
    {.name = NULL}};

static void set_defaults(struct job *job)
{
    *job = (struct job){.camera = {.kind = JOB_CAMERA_DEFAULT},
                        .width_px = 720,
                        .height_px = 720,
                        .pixel_type = PIXEL_FLOAT,
                        .exr_compression = EXR_CODEC_ZIP,
                        .view = VIEW_AGX,
                        .png_bits = 8,
                        .scene_lights = true,
                        .default_light = true,
                        .indirect_bounces = 1,
                        .spp = 9,
                        .seed = 1,
                        .method = FILTER_AUTO,
                        .environment_filter = ENVIRONMENT_AUTO,
                        .indirect = INDIRECT_AUTO,
                        .glossy = GLOSSY_AUTO,
                        .lens = LENS_AUTO,
                        .residual = RESIDUAL_AUTO,
                        .temporal = TEMPORAL_AUTO,
                        .mu = 1.0f,
                        .layers = LAYER_BEAUTY,
                        .frames = {{1, 1, 1}},
                        .frame_run_count = 1,
                        .fps = 24,
                        .tile_px = 64};
}

static uint32_t round_up_to_square(uint32_t spp)
{
    const uint32_t l = job_strata_per_axis(spp);
    return l * l;
}

static void finish_sampling(struct job *job)
{
    job->spp = round_up_to_square(job->spp);
    if (job->light_spp) job->light_spp = round_up_to_square(job->light_spp);
    if (job->indirect_spp) job->indirect_spp = round_up_to_square(job->indirect_spp);
    if (job->lens_spp) job->lens_spp = round_up_to_square(job->lens_spp);
    if (job->target_error > 0.0f && job->max_spp == 0)
        job->max_spp = job->spp > JOB_MAX_SPP ? job->spp : JOB_MAX_SPP;
}

int job_read(const char *text, size_t size_bytes, struct job *out, struct fault *fault)
{
    struct json_cursor at;
    json_t *document;
    int error = json_read(text, size_bytes, LIMIT_JOB_BYTES, &document, fault);
    if (error) return error;
    json_cursor_init(&at, fault);
    set_defaults(out);
    error = json_cursor_members(&at, document, job_members, out);
    if (!error) {
        finish_sampling(out);
        job_composite_defaults(out, json_object_get(document, "layers"),
                               json_object_get(json_object_get(document, "image"), "view"));
        error = job_relations_check(&at, out);
    }
    json_decref(document);
    if (error) job_fini(out);
    return error;
}
