/* The canonical job document: every member, in one order, defaults spelled out. */
#include "proto/job/job_internal.h"

/* jansson's setters take NULL for a failed allocation and say so, hence the sums of failures. */
static int set(json_t *object, const char *key, json_t *value)
{
    return json_object_set_new(object, key, value) != 0;
}

static json_t *checked(json_t *object, int failures)
{
    if (failures == 0) return object;
    json_decref(object);
    return NULL;
}

static json_t *write_digest(const struct digest *digest)
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(digest, hex);
    return json_string(hex);
}

static json_t *write_files(const struct job *job)
{
    json_t *object = json_object();
    int failures = 0;
    for (uint32_t i = 0; i < job->file_count; i++)
        failures += set(object, job->files[i].path, write_digest(&job->files[i].asset));
    return checked(object, failures);
}

static json_t *write_scene(const struct job *job)
{
    json_t *object = json_object();
    int failures = set(object, "asset", write_digest(&job->scene));
    failures += set(object, "files", write_files(job));
    failures += set(object, "camera", job_camera_write(&job->camera));
    failures += set(object, "variant", job->variant[0] ? json_string(job->variant) : json_null());
    failures +=
        set(object, "animation", job->animation[0] ? json_string(job->animation) : json_null());
    failures += set(object, "time_s", job->stands ? json_real(job->time_s) : json_null());
    failures += set(object, "moves", job_moves_write(&job->moves));
    failures += set(object, "lights", json_boolean(job->scene_lights));
    failures += set(object, "default_light", json_boolean(job->default_light));
    failures +=
        set(object, "default_camera", json_string(job_word(job_view_words, job->default_camera)));
    return checked(object, failures);
}

static json_t *write_effects(const struct job *job)
{
    json_t *object = json_object();
    json_t *occlusion =
        job->occlusion_distance > 0.0f
            ? json_pack("{s:o}", "distance", job_number_write(job->occlusion_distance))
            : json_false();
    int failures = set(object, "indirect_bounces", json_integer(job->indirect_bounces));
    failures += set(object, "ambient_occlusion", occlusion);
    return checked(object, failures);
}

static json_t *write_sampling(const struct job *job)
{
    json_t *object = json_object();
    int failures = set(object, "spp", json_integer(job->spp));
    failures += set(object, "light_spp", json_integer(job->light_spp));
    failures += set(object, "indirect_spp", json_integer(job->indirect_spp));
    failures += set(object, "lens_spp", json_integer(job->lens_spp));
    failures += set(object, "lens_extra", json_integer(job->lens_extra));
    failures += set(object, "field_scale", job_field_scale_write(job->field_scale));
    failures += set(object, "target_error", job_number_write(job->target_error));
    failures += set(object, "max_spp", json_integer(job->max_spp));
    failures += set(object, "seed", json_integer((json_int_t)job->seed));
    failures += set(object, "tile_px", json_integer(job->tile_px));
    return checked(object, failures);
}

static json_t *write_filter(const struct job *job)
{
    json_t *object = json_object();
    int failures = set(object, "method", json_string(filter_method_name(job->method)));
    failures +=
        set(object, "environment", json_string(environment_method_name(job->environment_filter)));
    failures += set(object, "indirect", json_string(indirect_method_name(job->indirect)));
    failures += set(object, "glossy", json_string(glossy_method_name(job->glossy)));
    failures += set(object, "lens", json_string(lens_method_name(job->lens)));
    failures += set(object, "residual", json_string(residual_method_name(job->residual)));
    failures += set(object, "temporal", json_string(temporal_method_name(job->temporal)));
    failures += set(object, "mu", job_number_write(job->mu));
    return checked(object, failures);
}

static json_t *write_layers(const struct job *job)
{
    json_t *array = json_array();
    int failures = 0;
    for (const struct json_choice *w = job_layer_words; w->name; w++)
        if (job->layers & w->value)
            failures += json_array_append_new(array, json_string(w->name)) != 0;
    return checked(array, failures);
}

json_t *job_write(const struct job *job)
{
    json_t *object = json_object();
    int failures = set(object, "scene", write_scene(job));
    failures += set(object, "image", job_image_write(job));
    failures += set(object, "lights", job_lights_write(job));
    failures += set(object, "environment", job_environment_write(&job->environment));
    failures += set(object, "camera", job_shutter_write(job));
    failures += set(object, "lens", job_lens_write(job));
    failures += set(object, "effects", write_effects(job));
    failures += set(object, "sampling", write_sampling(job));
    failures += set(object, "filter", write_filter(job));
    failures += set(object, "layers", write_layers(job));
    failures += set(object, "frames", job_frames_write(job));
    failures += set(object, "fps", json_real(job->fps));
    failures += set(object, "start_time_s", json_real(job->start_time_s));
    failures += set(object, "priority", json_integer(job->priority));
    failures += set(object, "live", json_boolean(job->live));
    failures += job_composite_write(job, object);
    failures += set(object, "name", job_text_write(job->marks.name));
    failures += set(object, "comment", job_text_write(job->marks.comment));
    failures += set(object, "labels", job_labels_write(&job->marks));
    failures += set(object, "webhook", job_webhook_write(job->marks.webhook));
    return checked(object, failures);
}
