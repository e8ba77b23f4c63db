#pragma once
/* A job file on this machine, ready to be sent: read, its scene uploaded, options applied. */
#include <jansson.h>

#include "server/cli/client.h"

/* Reads the document at `path` ("-": standard input). New reference. */
int job_file_read(const char *path, json_t **out, struct fault *fault);

/* Uploads what it names on this disk and submits it. tile_px 0: as the document says. The answer
 * (the job) is a new reference; its "id" is there. */
int job_file_submit(struct client *c, const char *path, json_t *document, long tile_px,
                    json_t **job, struct fault *fault);

/* Prints "shearwater NAME: pointer: detail" on standard error; returns 1, a failed command's exit
 * status. */
int job_file_complain(const char *command, const struct fault *fault);
