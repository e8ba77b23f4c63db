#pragma once
/* A job file on this machine, ready to be sent: read, options applied, its files uploaded. */
#include <jansson.h>

#include "server/cli/client/client.h"
#include "server/cli/job_changes.h"

/* Reads the document at `path` ("-": standard input). *out is a new reference. */
int job_file_read(const char *path, json_t **out, struct fault *fault);

/* Changes the document and uploads the files on this disk that it then names. */
int job_file_prepare(struct client *c, const char *path, const struct job_changes *changes,
                     json_t *document, struct fault *fault);

/* Does the same, and submits the document. The answer (the job) is a new reference; its "id" is
 * there. */
int job_file_submit(struct client *c, const char *path, const struct job_changes *changes,
                    json_t *document, json_t **job, struct fault *fault);

/* Prints "shearwater NAME: pointer: detail" on standard error; returns 1, a failed command's exit
 * status. */
int job_file_complain(const char *command, const struct fault *fault);
