#include "server/cli/job_watch.h"

#include <stdio.h>
#include <string.h>

struct watch {
    struct progress *progress;
    char state[32];
};

static bool is_end(const char *state)
{
    return strcmp(state, "finished") == 0 || strcmp(state, "failed") == 0 ||
           strcmp(state, "cancelled") == 0;
}

/* Takes one event; false when the job has ended. */
static bool on_event(void *ctx, const char *name, const json_t *data)
{
    struct watch *w = ctx;
    /* Other events have states of their own: a frame's is not the job's. */
    const bool of_job = strcmp(name, "state") == 0 || strcmp(name, "snapshot") == 0;
    const char *state = of_job ? json_string_value(json_object_get(data, "state")) : NULL;
    if (state) snprintf(w->state, sizeof w->state, "%s", state);
    if (state && json_is_true(json_object_get(data, "paused")))
        snprintf(w->state, sizeof w->state, "paused");
    if (strcmp(name, "progress") == 0)
        progress_show(w->progress, w->state, data);
    else if (strcmp(name, "snapshot") == 0)
        progress_show(w->progress, w->state, json_object_get(data, "progress"));
    else if (state && !is_end(state))
        progress_show(w->progress, w->state, NULL);
    return !is_end(w->state);
}

static int outcome(const char *id, const json_t *job, struct fault *fault)
{
    const char *state = json_string_value(json_object_get(job, "state"));
    if (state && strcmp(state, "finished") == 0) return 0;
    const json_t *error = json_object_get(job, "error");
    const char *pointer = json_string_value(json_object_get(error, "pointer"));
    const char *detail = json_string_value(json_object_get(error, "detail"));
    if (detail) return fault_set(fault, ERR_STATE, pointer ? pointer : "", "%s", detail);
    return fault_set(fault, ERR_STATE, "", "job %s is %s", id, state ? state : "unknown");
}

int job_watch(struct client *c, const char *id, struct progress *progress, json_t **job,
              struct fault *fault)
{
    struct watch w = {.progress = progress};
    char path[64];
    *job = NULL;
    int error = client_events(c, id, on_event, &w, fault);
    if (error) return error;
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    error = client_json(c, "GET", path, NULL, job, fault);
    return error ? error : outcome(id, *job, fault);
}
