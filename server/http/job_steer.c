/* PATCH /v1/jobs/{id}: steering a job that has not ended. */
#include <stdlib.h>

#include "server/http/job_body.h"
#include "server/job/state.h"
#include "server/job/steering.h"

/* A request on its way: looked at beside the job, then in force, then answered with the job. */
struct patch {
    struct request *r;
    struct steering steering;
};

static void on_got(void *ctx, int error, json_t *body)
{
    struct request *r = ctx;
    if (request_back(r)) job_body_send(r, error, body);
}

static void on_steered(void *ctx, int error)
{
    struct request *r = ctx;
    if (!request_back(r)) return;
    if (error) {
        job_body_error(r, error);
        return;
    }
    request_hold(r);
    jobs_get(r->http->options.jobs, r->match.job, on_got, r);
}

/* Somebody else may have changed it since the client looked (RFC 9110, section 13.1.1). */
static bool is_stale(const struct request *r, const json_t *body)
{
    const char *wanted = request_header(r, "If-Match");
    char etag[ETAG_BYTES];
    if (!wanted) return false;
    return job_body_tag(body, etag, NULL) != 0 || !etag_matches(wanted, etag);
}

static bool has_ended(const json_t *body)
{
    const char *name = json_string_value(json_object_get(body, "state"));
    enum job_state state;
    return name && job_state_from_name(name, &state) && job_state_is_final(state);
}

static int check_picture(const struct steering *s, const json_t *body, struct fault *fault)
{
    const json_t *image = json_object_get(json_object_get(body, "document"), "image");
    const json_int_t width = json_integer_value(json_object_get(image, "width"));
    const json_int_t height = json_integer_value(json_object_get(image, "height"));
    return steering_check(s, (int32_t)width, (int32_t)height, fault);
}

static void on_seen(void *ctx, int error, json_t *body)
{
    struct patch *patch = ctx;
    struct request *r = patch->r;
    const struct steering steering = patch->steering;
    struct fault fault = {0};
    free(patch);
    if (!request_back(r)) return;
    if (error || !body) {
        job_body_error(r, error ? error : ERR_NOT_FOUND);
    } else if (is_stale(r, body)) {
        request_problem(r, PROBLEM_STALE, "the job is not as If-Match says any more", NULL);
    } else if (has_ended(body)) {
        job_body_error(r, ERR_STATE);
    } else if (check_picture(&steering, body, &fault) != 0) {
        request_fault(r, &fault);
    } else {
        request_hold(r);
        jobs_steer(r->http->options.jobs, r->match.job, &steering, on_steered, r);
    }
}

void route_job_patch(struct request *r)
{
    struct fault fault = {0};
    struct steering steering;
    if (steering_read(r->body ? r->body : "", r->body_bytes, &steering, &fault) != 0) {
        request_fault(r, &fault);
        return;
    }
    struct patch *patch = malloc(sizeof *patch);
    if (!patch) {
        job_body_error(r, ERR_MEMORY);
        return;
    }
    *patch = (struct patch){.r = r, .steering = steering};
    request_hold(r);
    jobs_get(r->http->options.jobs, r->match.job, on_seen, patch);
}
