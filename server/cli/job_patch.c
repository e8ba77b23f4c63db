#include "server/cli/job_patch.h"

#include <stdio.h>

int job_patch(const struct client_target *target, const char *id, json_t *patch, json_t **job,
              struct fault *fault)
{
    struct client *client = NULL;
    char path[128];
    snprintf(path, sizeof path, "/v1/jobs/%.64s", id);
    int error = client_target_open(target, &client, fault);
    if (!error) error = client_json(client, "PATCH", path, patch, job, fault);
    client_destroy(&client);
    return error;
}
