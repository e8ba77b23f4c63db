#pragma once
/* Changing a job of a running coordinator, as `steer` and `mark` do. */
#include "server/cli/client/client_target.h"

/* Sends the document of changes. *job becomes what the job is then; the caller owns it. The
 * client's errors, with a fault. */
int job_patch(const struct client_target *target, const char *id, json_t *patch, json_t **job,
              struct fault *fault);
