#pragma once
/* Follows a job on a server until it has ended, drawing its progress. */
#include "server/cli/client/client.h"
#include "server/cli/progress.h"

/* Returns 0 when the job finished. ERR_STATE: it failed or was cancelled, *fault says why. *job is
 * its last answer (new reference) in both cases, else NULL. */
int job_watch(struct client *c, const char *id, struct progress *progress, json_t **job,
              struct fault *fault);
