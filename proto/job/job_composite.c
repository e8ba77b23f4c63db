#include "proto/job/job_composite.h"

#include <stdlib.h>
#include <string.h>

#include "proto/job/job_internal.h"

#define FIELD(member) offsetof(struct job, composite.member)

static const struct json_choice fit_words[] = {{"exact", PLATE_FIT_EXACT, NULL},
                                               {"cover", PLATE_FIT_COVER, NULL},
                                               {"stretch", PLATE_FIT_STRETCH, NULL},
                                               {NULL, 0, NULL}};
/* The camera's field of view is the sequence's: nothing can be cut. */
static const struct json_choice rgbd_fit_words[] = {
    {"exact", PLATE_FIT_EXACT, NULL}, {"stretch", PLATE_FIT_STRETCH, NULL}, {NULL, 0, NULL}};
static const struct json_choice surfaces_words[] = {
    {"screen", RGBD_SCREEN, NULL}, {"fused", RGBD_FUSED, NULL}, {NULL, 0, NULL}};
static const struct json_choice light_words[] = {{"auto", RGBD_LIGHT_AUTO, NULL},
                                                 {"estimate", RGBD_LIGHT_ESTIMATE, NULL},
                                                 {"studio", RGBD_LIGHT_STUDIO, NULL},
                                                 {NULL, 0, NULL}};
static const struct json_choice color_words[] = {
    {"srgb", PLATE_COLOR_SRGB, NULL}, {"linear", PLATE_COLOR_LINEAR, NULL}, {NULL, 0, NULL}};
static const struct json_choice mode_words[] = {{"multiplicative", COMPOSITE_MULTIPLY, NULL},
                                                {"additive", COMPOSITE_ADD, NULL},
                                                {NULL, 0, NULL}};

static const struct json_member plate_members[] = {
    {.name = "asset", .read = json_member_digest, .offset = FIELD(plate), .required = true},
    {.name = "fit", .read = json_member_choice, .offset = FIELD(fit), .choices = fit_words},
    {.name = "color_space",
     .read = json_member_choice,
     .offset = FIELD(color),
     .choices = color_words},
    {.name = "file",
     .read = json_member_unsupported,
     .sentence = "a file on your machine: submit with the command line, or upload it and give its "
                 "digest as \"asset\""},
    {.name = NULL}};

static int read_document(struct json_cursor *at, const struct json_member *member,
                         const json_t *value, void *object)
{
    struct job *job = object;
    (void)member;
    int error = json_cursor_expect(at, value, JSON_STRING, "the name of one of scene.files");
    if (error) return error;
    if (json_string_length(value) >= LIMIT_PATH_BYTES)
        return json_cursor_refuse(at, ERR_LIMIT, "a name of %zu bytes is above the limit of %d",
                                  json_string_length(value), LIMIT_PATH_BYTES - 1);
    job->composite.rgbd = strdup(json_string_value(value));
    return job->composite.rgbd ? 0 : json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
}

static const struct json_member rgbd_members[] = {
    {.name = "document", .read = read_document, .required = true},
    {.name = "surfaces",
     .read = json_member_choice,
     .offset = FIELD(surfaces),
     .choices = surfaces_words},
    {.name = "light", .read = json_member_choice, .offset = FIELD(light), .choices = light_words},
    {.name = "fit", .read = json_member_choice, .offset = FIELD(fit), .choices = rgbd_fit_words},
    {.name = "color_space",
     .read = json_member_choice,
     .offset = FIELD(color),
     .choices = color_words},
    {.name = "file",
     .read = json_member_unsupported,
     .sentence = "a file on your machine: submit with the command line, or upload all files, list "
                 "them in scene.files and name this one as \"document\""},
    {.name = NULL}};

static const struct json_member ground_members[] = {{.name = "height",
                                                     .read = json_member_f32,
                                                     .offset = FIELD(ground_height),
                                                     .min = -LIMIT_COORDINATE,
                                                     .max = LIMIT_COORDINATE,
                                                     .required = true},
                                                    {.name = NULL}};

static const struct json_member catcher_members[] = {
    {.name = "ground", .read = json_member_object, .members = ground_members, .required = true},
    {.name = NULL}};

static const struct json_member mode_members[] = {
    {.name = "mode", .read = json_member_choice, .offset = FIELD(mode), .choices = mode_words},
    {.name = NULL}};

int job_plate_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                   void *object)
{
    struct job *job = object;
    (void)member;
    if (json_is_null(value)) return 0;
    job->composite.on = job->composite.has_plate = true;
    return json_cursor_members(at, value, plate_members, job);
}

int job_rgbd_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                  void *object)
{
    struct job *job = object;
    (void)member;
    if (json_is_null(value)) return 0;
    job->composite.on = true;
    return json_cursor_members(at, value, rgbd_members, job);
}

static int read_name(struct json_cursor *at, const json_t *value, json_t *names)
{
    const size_t length = json_string_length(value);
    if (length == 0) return json_cursor_refuse(at, ERR_RANGE, "it names nothing");
    if (length >= LIMIT_NAME_BYTES)
        return json_cursor_refuse(at, ERR_LIMIT, "a name of %zu bytes is above the limit of %d",
                                  length, LIMIT_NAME_BYTES - 1);
    for (size_t i = 0; i < json_array_size(names); i++)
        if (json_equal(json_array_get(names, i), value))
            return json_cursor_refuse(at, ERR_EXISTS, "\"%s\" is named twice",
                                      json_string_value(value));
    return json_array_append(names, (json_t *)(uintptr_t)value)
               ? json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted")
               : 0;
}

/* The list keeps its place, so that others keep theirs. */
static int read_ground(struct json_cursor *at, const json_t *value, struct job *job, json_t *names)
{
    if (job->composite.has_ground) return json_cursor_refuse(at, ERR_EXISTS, "there is one ground");
    job->composite.has_ground = true;
    if (json_array_append_new(names, json_null()) != 0)
        return json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
    return json_cursor_members(at, value, catcher_members, job);
}

/* Reads names, and where `grounds` is set a ground among them. */
static int read_names(struct json_cursor *at, const json_t *value, bool grounds, struct job *job,
                      json_t *names)
{
    int error = json_cursor_expect(at, value, JSON_ARRAY, "an array of names");
    if (error) return error;
    if (json_array_size(value) > LIMIT_COMPOSITE_NAMES)
        return json_cursor_refuse(at, ERR_LIMIT, "%zu names are above the limit of %d",
                                  json_array_size(value), LIMIT_COMPOSITE_NAMES);
    for (size_t i = 0; i < json_array_size(value) && !error; i++) {
        const json_t *one = json_array_get(value, i);
        const size_t length = json_cursor_enter_index(at, i);
        if (grounds && json_is_object(one))
            error = read_ground(at, one, job, names);
        else
            error = json_cursor_expect(at, one, JSON_STRING, "a name of a node or a material");
        if (!error && json_is_string(one)) error = read_name(at, one, names);
        if (!error) json_cursor_leave(at, length);
    }
    return error;
}

static int read_list(struct json_cursor *at, const json_t *value, bool grounds, struct job *job,
                     char **out)
{
    json_t *names = json_array();
    if (!names) return json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
    int error = read_names(at, value, grounds, job, names);
    if (!error && json_array_size(names) > 0) {
        *out = json_text(names, JSON_COMPACT);
        if (!*out) error = json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
    }
    if (!error && json_array_size(value) > 0) job->composite.on = true;
    json_decref(names);
    return error;
}

int job_catchers_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                      void *object)
{
    struct job *job = object;
    (void)member;
    return read_list(at, value, true, job, &job->composite.catchers);
}

int job_holdouts_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                      void *object)
{
    struct job *job = object;
    (void)member;
    return read_list(at, value, false, job, &job->composite.holdouts);
}

int job_composite_mode_read(struct json_cursor *at, const struct json_member *member,
                            const json_t *value, void *object)
{
    struct job *job = object;
    (void)member;
    job->composite.on = true;
    return json_cursor_members(at, value, mode_members, job);
}

/* Refuses a member of an object at the root. */
static int refuse_in(struct json_cursor *at, const char *object, const char *key, int code,
                     const char *why)
{
    json_cursor_enter(at, object);
    return json_cursor_refuse_member(at, key, code, "%s", why);
}

static bool has_file(const struct job *job, const char *path)
{
    for (uint32_t i = 0; i < job->file_count; i++)
        if (strcmp(job->files[i].path, path) == 0) return true;
    return false;
}

static int check_rgbd(struct json_cursor *at, const struct job *job)
{
    if (!job->composite.rgbd) return 0;
    if (job->composite.has_plate)
        return json_cursor_refuse_member(at, "backplate", ERR_EXISTS,
                                         "the frames of \"rgbd\" are backplates already");
    if (job->camera.kind != JOB_CAMERA_DEFAULT)
        return refuse_in(at, "scene", "camera", ERR_UNSUPPORTED,
                         "the camera is that of the frames of \"rgbd\"");
    if (!has_file(job, job->composite.rgbd))
        return refuse_in(at, "rgbd", "document", ERR_NOT_FOUND,
                         "it is none of the names in scene.files");
    if (job->composite.light == RGBD_LIGHT_ESTIMATE && job->environment.kind != ENVIRONMENT_NONE)
        return refuse_in(at, "rgbd", "light", ERR_EXISTS,
                         "\"environment\" is the light from around already");
    if (job->live)
        return json_cursor_refuse_member(at, "live", ERR_UNSUPPORTED,
                                         "the frames of \"rgbd\" do not move");
    if (job->layers & LAYERS_MOTION)
        return json_cursor_refuse_member(at, "layers", ERR_UNSUPPORTED,
                                         "motion is not known of the frames of \"rgbd\"");
    return 0;
}

int job_composite_check(struct json_cursor *at, const struct job *job)
{
    const uint32_t made = job->layers & LAYERS_COMPOSITE;
    if (made && !job->composite.on)
        return json_cursor_refuse_member(at, "layers", ERR_MISSING,
                                         "composite, catcher, overlay and backplate are of "
                                         "pictures with a \"backplate\" or \"catchers\"");
    if (!job->composite.on) return 0;
    if ((made & (LAYER_COMPOSITE | LAYER_BACKPLATE)) && !job_composite_has_plate(&job->composite))
        return json_cursor_refuse_member(
            at, "layers", ERR_MISSING,
            "composite and backplate need the photograph: give \"backplate\" or "
            "\"rgbd\"");
    const int error = check_rgbd(at, job);
    if (error) return error;
    if (job->target_error > 0.0f)
        return refuse_in(at, "sampling", "target_error", ERR_UNSUPPORTED,
                         "the error of a composite is not known: give spp");
    if (job->spp > LIMIT_COMPOSITE_SPP)
        return refuse_in(at, "sampling", "spp", ERR_LIMIT,
                         "a composite has at most 16384 samples a pixel");
    return 0;
}

static enum rgbd_estimate estimate_of(const struct job *job)
{
    const bool dark = job->environment.kind == ENVIRONMENT_NONE && job->light_count == 0;
    if (!job->composite.rgbd || job->composite.light == RGBD_LIGHT_STUDIO)
        return RGBD_ESTIMATE_NONE;
    if (job->composite.light == RGBD_LIGHT_ESTIMATE) return RGBD_ESTIMATE_ALWAYS;
    return dark && job->default_light ? RGBD_ESTIMATE_UNLESS_LIT : RGBD_ESTIMATE_NONE;
}

void job_composite_defaults(struct job *job, bool has_layers, bool has_view)
{
    const bool has_plate = job_composite_has_plate(&job->composite);
    if (!job->composite.on) return;
    job->composite.estimate = estimate_of(job);
    if (!has_layers) job->layers = LAYER_CATCHER | (has_plate ? LAYER_COMPOSITE : 0);
    job->layers |= LAYER_BEAUTY; /* the objects, of which all others are made */
    if (!has_view && has_plate) job->view = VIEW_LINEAR;
}

static json_t *write_plate(const struct job_composite *c)
{
    char hex[DIGEST_HEX_BYTES];
    if (!c->has_plate) return json_null();
    digest_to_hex(&c->plate, hex);
    return json_pack("{s:s,s:s,s:s}", "asset", hex, "fit", job_word(fit_words, c->fit),
                     "color_space", job_word(color_words, c->color));
}

static json_t *write_rgbd(const struct job_composite *c)
{
    if (!c->rgbd) return json_null();
    return json_pack("{s:s,s:s,s:s,s:s,s:s}", "document", c->rgbd, "surfaces",
                     job_word(surfaces_words, c->surfaces), "light",
                     job_word(light_words, c->light), "fit", job_word(rgbd_fit_words, c->fit),
                     "color_space", job_word(color_words, c->color));
}

static json_t *write_names(const char *names)
{
    json_t *list = NULL;
    if (!names) return json_array();
    (void)json_read(names, strlen(names), LIMIT_JOB_BYTES, &list, NULL);
    return list;
}

static json_t *write_catchers(const struct job_composite *c)
{
    json_t *list = write_names(c->catchers);
    for (size_t i = 0; i < json_array_size(list); i++) {
        if (!json_is_null(json_array_get(list, i))) continue;
        json_t *ground =
            json_pack("{s:{s:o}}", "ground", "height", job_number_write(c->ground_height));
        if (ground && json_array_set_new(list, i, ground) == 0) continue;
        json_decref(list);
        return NULL;
    }
    return list;
}

int job_composite_write(const struct job *job, json_t *document)
{
    const struct job_composite *c = &job->composite;
    if (!c->on) return 0;
    int failures = json_object_set_new(document, "backplate", write_plate(c)) != 0;
    failures += json_object_set_new(document, "rgbd", write_rgbd(c)) != 0;
    failures += json_object_set_new(document, "catchers", write_catchers(c)) != 0;
    failures += json_object_set_new(document, "holdouts", write_names(c->holdouts)) != 0;
    failures += json_object_set_new(document, "composite",
                                    json_pack("{s:s}", "mode", job_word(mode_words, c->mode))) != 0;
    return failures;
}

void job_composite_fini(struct job_composite *composite)
{
    free(composite->catchers);
    free(composite->holdouts);
    free(composite->rgbd);
    composite->catchers = composite->holdouts = composite->rgbd = NULL;
}

int job_composite_copy(const struct job_composite *from, struct job_composite *out)
{
    *out = *from;
    out->catchers = from->catchers ? strdup(from->catchers) : NULL;
    out->holdouts = from->holdouts ? strdup(from->holdouts) : NULL;
    out->rgbd = from->rgbd ? strdup(from->rgbd) : NULL;
    if (!from->catchers == !out->catchers && !from->holdouts == !out->holdouts &&
        !from->rgbd == !out->rgbd)
        return 0;
    job_composite_fini(out);
    return ERR_MEMORY;
}
