#include "server/cli/job_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job.h"
#include "server/cli/scene_bundle.h"

int job_file_read(const char *path, json_t **out, struct fault *fault)
{
    FILE *f = strcmp(path, "-") == 0 ? stdin : fopen(path, "rb");
    if (!f) return fault_set(fault, ERR_NOT_FOUND, "", "%s: %s", path, strerror(errno));
    char *text = malloc(LIMIT_JOB_BYTES + 1);
    size_t size_bytes = text ? fread(text, 1, LIMIT_JOB_BYTES + 1, f) : 0;
    int error = text ? 0 : fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    if (!error && ferror(f)) error = fault_set(fault, ERR_IO, "", "%s: %s", path, strerror(errno));
    if (!error) error = json_read(text, size_bytes, LIMIT_JOB_BYTES, out, fault);
    if (!error && !json_is_object(*out)) {
        json_decref(*out);
        error = fault_set(fault, ERR_TYPE, "", "%s: a job is a JSON object", path);
    }
    free(text);
    if (f != stdin) fclose(f);
    return error;
}

static int set_tile(json_t *document, long tile_px)
{
    json_t *sampling = json_object_get(document, "sampling");
    if (!sampling) {
        sampling = json_object();
        if (json_object_set_new(document, "sampling", sampling) != 0) return ERR_MEMORY;
    }
    /* A "sampling" of the wrong type is the server's to refuse. */
    if (json_is_object(sampling))
        json_object_set_new(sampling, "tile_px", json_integer((json_int_t)tile_px));
    return 0;
}

int job_file_submit(struct client *c, const char *path, json_t *document, long tile_px,
                    json_t **job, struct fault *fault)
{
    int error = scene_bundle_upload(c, path, document, fault);
    if (!error && tile_px > 0) error = set_tile(document, tile_px);
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
