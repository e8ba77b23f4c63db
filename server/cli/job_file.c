#include "server/cli/job_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "proto/job/job.h"
#include "server/cli/scene_bundle.h"

/* Says which file it is: it may be a scene. */
static int no_job(const char *path, const char *why, struct fault *fault)
{
    char said[sizeof fault->detail];
    snprintf(said, sizeof said, "%s", why);
    return fault_set(fault, ERR_SYNTAX, "",
                     "%s: %s (a job is a JSON object such as {\"scene\": {\"file\": "
                     "\"lamp.glb\"}, \"image\": {\"width\": 640, \"height\": 360}})",
                     path, said);
}

static bool is_scene(const char *path)
{
    static const char *const endings[] = {".glb", ".gltf", ".obj"};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < sizeof endings / sizeof *endings; i++)
        if (strcasecmp(dot, endings[i]) == 0) return true;
    return false;
}

/* Scatterings that light needs to come through glass, off what lies behind and back. */
#define SCENE_BOUNCES 12

/* A job of defaults for a scene; its file's name counts from the folder of `path`, as a job's. */
static int scene_job(const char *path, json_t **out, struct fault *fault)
{
    const char *slash = strrchr(path, '/');
    FILE *f = fopen(path, "rb");
    if (!f) return fault_set(fault, ERR_NOT_FOUND, "", "%s: %s", path, strerror(errno));
    fclose(f);
    *out =
        json_pack("{s:{s:s, s:s}, s:{s:i}}", "scene", "file", slash ? slash + 1 : path,
                  "default_camera", "three_quarter", "effects", "indirect_bounces", SCENE_BOUNCES);
    return *out ? 0 : fault_set(fault, ERR_SYNTAX, "", "%s: its name is not UTF-8", path);
}

int job_file_read(const char *path, json_t **out, struct fault *fault)
{
    if (is_scene(path)) return scene_job(path, out, fault);
    FILE *f = strcmp(path, "-") == 0 ? stdin : fopen(path, "rb");
    if (!f) return fault_set(fault, ERR_NOT_FOUND, "", "%s: %s", path, strerror(errno));
    char *text = malloc(LIMIT_JOB_BYTES + 1);
    size_t size_bytes = text ? fread(text, 1, LIMIT_JOB_BYTES + 1, f) : 0;
    int error = text ? 0 : fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    if (!error && ferror(f)) error = fault_set(fault, ERR_IO, "", "%s: %s", path, strerror(errno));
    if (!error) error = json_read(text, size_bytes, LIMIT_JOB_BYTES, out, fault);
    if (error == ERR_SYNTAX) error = no_job(path, fault->detail, fault);
    if (!error && !json_is_object(*out)) {
        json_decref(*out);
        error = no_job(path, "it is not an object", fault);
    }
    free(text);
    if (f != stdin) fclose(f);
    return error;
}

int job_file_prepare(struct client *c, const char *path, const struct job_changes *changes,
                     json_t *document, struct fault *fault)
{
    int error = job_changes_apply(changes, document, fault);
    return error ? error : scene_bundle_upload(c, path, document, fault);
}

int job_file_submit(struct client *c, const char *path, const struct job_changes *changes,
                    json_t *document, json_t **job, struct fault *fault)
{
    int error = job_file_prepare(c, path, changes, document, fault);
    if (!error) error = client_json(c, "POST", "/v1/jobs", document, job, fault);
    if (!error && !json_is_string(json_object_get(*job, "id"))) {
        json_decref(*job);
        error = fault_set(fault, ERR_SYNTAX, "", "the server's answer names no job");
    }
    return error;
}

int job_file_complain(const char *command, const struct fault *fault)
{
    fprintf(stderr, "shearwater %s: %s%s%s\n", command, fault->pointer,
            fault->pointer[0] ? ": " : "",
            fault->detail[0] ? fault->detail : error_text(fault->code));
    return 1;
}
