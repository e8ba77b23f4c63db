/* PATCH /v1/jobs/{id}: steering a job that has not ended, moving the camera of a live one, or
 * changing the marks of any. */
#include <stdlib.h>

#include "proto/job/job_marks.h"
#include "proto/json.h"
#include "proto/limits.h"
#include "server/http/resource/job_body.h"
#include "server/job/frame/state.h"
#include "server/job/steering.h"

/* A request on its way: looked at beside the job, then in force, then answered. */
struct patch {
    struct request *r;
    bool moves;    /* else it marks or steers */
    json_t *marks; /* owned; NULL: it steers */
    struct steering steering;
};

/* ---- in force ---- */

static void on_got(void *ctx, int error, json_t *body)
{
    struct request *r = ctx;
    if (request_back(r)) job_body_send(r, error, body);
}

static void refuse_stale(struct request *r)
{
    request_problem(r, PROBLEM_STALE, "the job no longer is the one that If-Match names", NULL);
}

static void on_changed(void *ctx, int error)
{
    struct request *r = ctx;
    if (!request_back(r)) return;
    if (error == ERR_MISMATCH) {
        refuse_stale(r);
        return;
    }
    if (error) {
        job_body_error(r, error);
        return;
    }
    request_hold(r);
    jobs_get(r->http->options.jobs, &r->principal, r->match.job, on_got, r);
}

static void refuse_move(struct request *r, const struct fault *fault)
{
    const bool whole = fault->pointer[0] == '\0';
    if (whole && fault->code == ERR_NOT_FOUND)
        request_problem(r, PROBLEM_NOT_FOUND, fault->detail, NULL);
    else if (whole && fault->code == ERR_STATE)
        request_problem(r, PROBLEM_STATE, fault->detail, NULL);
    else
        request_fault(r, fault);
}

static void on_moved(void *ctx, const struct fault *fault, json_t *body)
{
    struct request *r = ctx;
    if (!request_back(r)) return;
    if (fault)
        refuse_move(r, fault);
    else
        request_json(r, 200, json_incref(body));
}

static void move(struct request *r)
{
    request_hold(r);
    jobs_move(r->http->options.jobs, &r->principal, r->match.job, r->body ? r->body : "",
              r->body_bytes, on_moved, r);
}

/* ---- beside the job ---- */

/* Compares the client's tag. ERR_STATE: the job has changed since the client looked (RFC 9110,
 * section 13.1.1). ERR_MEMORY. */
static int compare_tags(const struct request *r, const json_t *body)
{
    const char *wanted = request_header(r, "If-Match");
    char etag[ETAG_BYTES];
    if (!wanted) return 0;
    const int error = job_body_tag(body, etag, NULL);
    if (error) return error;
    return etag_matches(wanted, etag) ? 0 : ERR_STATE;
}

/* 0: the client does not ask for one. */
static uint64_t revision_of(const struct request *r, const json_t *body)
{
    if (!request_header(r, "If-Match")) return 0;
    return (uint64_t)json_integer_value(json_object_get(body, "revision"));
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

static void steer(struct request *r, const struct steering *steering, const json_t *body)
{
    struct fault fault = {0};
    if (has_ended(body)) {
        job_body_error(r, ERR_STATE);
    } else if (check_picture(steering, body, &fault) != 0) {
        request_fault(r, &fault);
    } else {
        request_hold(r);
        jobs_steer(r->http->options.jobs, &r->principal, r->match.job, revision_of(r, body),
                   steering, on_changed, r);
    }
}

static void mark(struct request *r, const json_t *marks, const json_t *body)
{
    request_hold(r);
    jobs_mark(r->http->options.jobs, &r->principal, r->match.job, revision_of(r, body), marks,
              on_changed, r);
}

static void go_on(const struct patch *seen, int error, const json_t *body)
{
    struct request *r = seen->r;
    if (!request_back(r)) return;
    if (error || !body) {
        job_body_error(r, error ? error : ERR_NOT_FOUND);
        return;
    }
    error = compare_tags(r, body);
    if (error == ERR_STATE)
        refuse_stale(r);
    else if (error)
        job_body_error(r, error);
    else if (seen->moves)
        move(r);
    else if (seen->marks)
        mark(r, seen->marks, body);
    else
        steer(r, &seen->steering, body);
}

static void on_seen(void *ctx, int error, json_t *body)
{
    struct patch *patch = ctx;
    go_on(patch, error, body);
    json_decref(patch->marks);
    free(patch);
}

/* Finds what the body asks for. That it asks for more than one is found when it is read.
 * ERR_MEMORY. */
static int look(const struct request *r, bool *moves, bool *marks)
{
    struct fault ignored;
    json_t *root = NULL;
    const int error =
        json_read(r->body ? r->body : "", r->body_bytes, LIMIT_JOB_BYTES, &root, &ignored);
    *moves = json_object_get(root, "camera") || json_object_get(root, "lens") ||
             json_object_get(root, "moves");
    *marks = json_object_get(root, "name") || json_object_get(root, "comment") ||
             json_object_get(root, "labels");
    json_decref(root);
    return error == ERR_MEMORY ? error : 0;
}

static int read_change(struct patch *asked, bool marks, struct fault *fault)
{
    const struct request *r = asked->r;
    const char *text = r->body ? r->body : "";
    if (asked->moves) return 0; /* jobs_move reads it */
    return marks ? job_marks_read_change(text, r->body_bytes, &asked->marks, fault)
                 : steering_read(text, r->body_bytes, &asked->steering, fault);
}

void route_job_patch(struct request *r)
{
    struct fault fault = {0};
    struct patch asked = {.r = r};
    bool marks = false;
    if (look(r, &asked.moves, &marks) != 0) {
        job_body_error(r, ERR_MEMORY);
        return;
    }
    if (asked.moves && !request_header(r, "If-Match")) {
        move(r); /* a viewer waits for the picture, so the store is not read */
        return;
    }
    if (read_change(&asked, marks, &fault) != 0) {
        request_fault(r, &fault);
        return;
    }
    struct patch *patch = malloc(sizeof *patch);
    if (!patch) {
        json_decref(asked.marks);
        job_body_error(r, ERR_MEMORY);
        return;
    }
    *patch = asked;
    request_hold(r);
    jobs_get(r->http->options.jobs, &r->principal, r->match.job, on_seen, patch);
}
