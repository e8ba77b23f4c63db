#include "server/cli/job_changes.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/matte.h"

int job_changes_set(json_t *document, const char *group, const char *key, json_t *value)
{
    json_t *object = json_object_get(document, group);
    if (!object) {
        object = json_object();
        if (json_object_set_new(document, group, object) != 0) object = NULL;
    }
    if (object && !json_is_object(object)) {
        json_decref(value);
        return 0;
    }
    return json_object_set_new(object, key, value) == 0 ? 0 : ERR_MEMORY;
}

static int set_environment(const char *path, json_t *document, struct fault *fault)
{
    char *whole = realpath(path, NULL);
    if (!whole)
        return fault_set(fault, ERR_NOT_FOUND, "", "--environment: %s: %s", path, strerror(errno));
    json_t *environment = json_object_get(document, "environment");
    if (json_is_null(environment) || json_object_get(environment, "radiance"))
        json_object_del(document, "environment");
    else
        json_object_del(environment, "asset");
    int error = job_changes_set(document, "environment", "file", json_string(whole));
    free(whole);
    return error;
}

/* "640x360" */
static int set_size(const char *size, json_t *document, struct fault *fault)
{
    char *end;
    const long width = strtol(size, &end, 10), height = *end == 'x' ? strtol(end + 1, &end, 10) : 0;
    if (*end || width < 1 || height < 1 || width > LIMIT_IMAGE_SIDE_PX ||
        height > LIMIT_IMAGE_SIDE_PX)
        return fault_set(fault, ERR_RANGE, "",
                         "--size: \"%.40s\" is not two sides from 1 to %d, such as 640x360", size,
                         LIMIT_IMAGE_SIDE_PX);
    int error = job_changes_set(document, "image", "width", json_integer(width));
    return error ? error : job_changes_set(document, "image", "height", json_integer(height));
}

/* Digits are an index. */
static int set_camera(const char *camera, json_t *document)
{
    char *end;
    const long index = strtol(camera, &end, 10);
    const bool is_index = *end == '\0' && camera[0] >= '0' && camera[0] <= '9';
    return job_changes_set(document, "scene", "camera",
                           is_index ? json_integer(index) : json_string(camera));
}

static int read_number(const char *option, const char *text, json_t **out, struct fault *fault)
{
    char *end;
    const double number = strtod(text, &end);
    if (end == text || *end || !isfinite(number))
        return fault_set(fault, ERR_RANGE, "", "%s: \"%.40s\" is no number", option, text);
    *out = json_real(number);
    return 0;
}

static int set_animation(const struct job_changes *changes, json_t *document, struct fault *fault)
{
    json_t *value = NULL;
    int error = 0;
    if (changes->animation)
        error = job_changes_set(document, "scene", "animation", json_string(changes->animation));
    if (!error && changes->time) error = read_number("--time", changes->time, &value, fault);
    if (!error && changes->time) error = job_changes_set(document, "scene", "time_s", value);
    if (!error && changes->frames)
        error =
            json_object_set_new(document, "frames", json_string(changes->frames)) ? ERR_MEMORY : 0;
    if (!error && changes->fps) error = read_number("--fps", changes->fps, &value, fault);
    if (!error && changes->fps)
        error = json_object_set_new(document, "fps", value) ? ERR_MEMORY : 0;
    if (!error && changes->shutter)
        error = read_number("--shutter", changes->shutter, &value, fault);
    if (!error && changes->shutter) error = job_changes_set(document, "camera", "shutter", value);
    return error;
}

/* How the picture's files are, but for its size. */
static int set_files(const struct job_changes *changes, json_t *document, struct fault *fault)
{
    json_t *exposure = NULL;
    int error = 0;
    if (changes->view)
        error = job_changes_set(document, "image", "view", json_string(changes->view));
    if (!error && changes->exposure)
        error = read_number("--exposure", changes->exposure, &exposure, fault);
    if (!error && exposure) error = job_changes_set(document, "image", "exposure", exposure);
    if (!error && changes->png_bits > 0)
        error = job_changes_set(document, "image", "png_bits", json_integer(changes->png_bits));
    if (!error && changes->png_alpha)
        error = job_changes_set(document, "image", "png_alpha", json_true());
    if (!error && changes->compression)
        error = job_changes_set(document, "image", "exr_compression",
                                json_string(changes->compression));
    return error;
}

static bool has_label(const json_t *labels, const char *label, size_t length)
{
    size_t i;
    json_t *one;
    json_array_foreach (labels, i, one)
        if (json_string_length(one) == length && memcmp(json_string_value(one), label, length) == 0)
            return true;
    return false;
}

/* Adds labels, parted by commas, to those that are there. */
static int add_labels(const char *list, json_t *document, struct fault *fault)
{
    json_t *labels = json_object_get(document, "labels");
    if (!labels && json_object_set_new(document, "labels", labels = json_array()))
        return ERR_MEMORY;
    if (!json_is_array(labels)) return 0;
    for (const char *at = list, *end; at; at = *end ? end + 1 : NULL) {
        end = strchrnul(at, ',');
        const size_t length = (size_t)(end - at);
        if (has_label(labels, at, length)) continue;
        json_t *label = json_stringn(at, length);
        if (!label) return fault_set(fault, ERR_RANGE, "", "--label: \"%.40s\" is no UTF-8", list);
        if (json_array_append_new(labels, label)) return ERR_MEMORY;
    }
    return 0;
}

static int set_text(const char *option, const char *text, json_t *document, struct fault *fault)
{
    json_t *value = json_string(text);
    if (!value) return fault_set(fault, ERR_RANGE, "", "--%s: it is no UTF-8", option);
    return json_object_set_new(document, option, value) ? ERR_MEMORY : 0;
}

static int set_marks(const struct job_changes *changes, json_t *document, struct fault *fault)
{
    int error = 0;
    if (changes->name) error = set_text("name", changes->name, document, fault);
    if (!error && changes->comment) error = set_text("comment", changes->comment, document, fault);
    for (size_t i = 0; i < changes->labels.count && !error; i++)
        error = add_labels(changes->labels.values[i], document, fault);
    if (!error && changes->webhook) {
        json_object_del(document, "webhook");
        error = job_changes_set(document, "webhook", "url", json_string(changes->webhook));
    }
    return error;
}

static bool has(const json_t *document, const char *key)
{
    const json_t *value = json_object_get(document, key);
    return json_is_object(value) || json_array_size(value) > 0;
}

/* Makes the layers that a document without any has. */
static json_t *default_layers(const json_t *document)
{
    if (has(document, "backplate") || has(document, "rgbd"))
        return json_pack("[s, s, s]", "beauty", "composite", "catcher");
    const bool composed =
        has(document, "catchers") || has(document, "holdouts") || has(document, "composite");
    return composed ? json_pack("[s, s]", "beauty", "catcher") : json_pack("[s]", "beauty");
}

static bool has_layer(const json_t *layers, const char *name)
{
    size_t i;
    json_t *one;
    json_array_foreach (layers, i, one)
        if (json_is_string(one) && strcmp(json_string_value(one), name) == 0) return true;
    return false;
}

static int add_mattes(json_t *document)
{
    static const char *const names[] = {MATTE_OBJECT_LAYER, MATTE_MATERIAL_LAYER};
    json_t *layers = json_object_get(document, "layers");
    if (!layers && json_object_set_new(document, "layers", layers = default_layers(document)))
        return ERR_MEMORY;
    for (int k = 0; k < 2 && json_is_array(layers); k++)
        if (!has_layer(layers, names[k]) && json_array_append_new(layers, json_string(names[k])))
            return ERR_MEMORY;
    return 0;
}

int job_changes_apply(const struct job_changes *changes, json_t *document, struct fault *fault)
{
    int error = 0;
    if (changes->size) error = set_size(changes->size, document, fault);
    if (!error) error = set_files(changes, document, fault);
    if (!error && changes->camera) error = set_camera(changes->camera, document);
    if (!error && changes->variant)
        error = job_changes_set(document, "scene", "variant", json_string(changes->variant));
    if (!error) error = set_animation(changes, document, fault);
    if (!error) error = set_marks(changes, document, fault);
    if (!error && changes->no_default_light)
        error = job_changes_set(document, "scene", "default_light", json_false());
    if (!error && changes->environment)
        error = set_environment(changes->environment, document, fault);
    if (!error) error = job_changes_photograph(changes, document, fault);
    if (!error && changes->cryptomatte) error = add_mattes(document);
    if (!error && changes->method)
        error = job_changes_set(document, "filter", "method", json_string(changes->method));
    if (!error && changes->environment_filter)
        error = job_changes_set(document, "filter", "environment",
                                json_string(changes->environment_filter));
    if (!error && changes->indirect)
        error = job_changes_set(document, "filter", "indirect", json_string(changes->indirect));
    if (!error && changes->glossy)
        error = job_changes_set(document, "filter", "glossy", json_string(changes->glossy));
    if (!error && changes->lens)
        error = job_changes_set(document, "filter", "lens", json_string(changes->lens));
    if (!error && changes->residual)
        error = job_changes_set(document, "filter", "residual", json_string(changes->residual));
    if (!error && changes->temporal)
        error = job_changes_set(document, "filter", "temporal", json_string(changes->temporal));
    if (!error && changes->bounces >= 0)
        error = job_changes_set(document, "effects", "indirect_bounces",
                                json_integer(changes->bounces));
    if (!error && changes->spp > 0)
        error = job_changes_set(document, "sampling", "spp", json_integer(changes->spp));
    if (!error && changes->tile_px > 0)
        error = job_changes_set(document, "sampling", "tile_px", json_integer(changes->tile_px));
    if (error == ERR_MEMORY) fault_set(fault, error, "", "memory is exhausted");
    return error;
}
