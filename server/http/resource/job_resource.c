/* /v1/jobs and /v1/jobs/{id}: submit, list, look at, cancel. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/bytes.h"
#include "proto/plan.h"
#include "server/http/resource/job_body.h"
#include "server/job/frame/state.h"
#include "server/job/job_id.h"

#define PLAN_TYPE       "application/octet-stream"
#define READ_HERE_BYTES 16384u /* of a document: half a millisecond */

static void on_submitted(void *ctx, const struct fault *fault, const char *id, bool existed)
{
    struct request *r = ctx;
    char path[64];
    if (!request_back(r)) return;
    if (fault && fault->code) {
        request_fault(r, fault);
        return;
    }
    snprintf(r->job, sizeof r->job, "%s", id);
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    json_t *body = json_pack("{s:s, s:s, s:b}", "id", id, "url", path, "existed", (int)existed);
    struct MHD_Response *response = response_of_json(body, "application/json");
    json_decref(body);
    if (response) response_header(response, "Location", path);
    request_answer(r, 202, response);
}

/* Answers with the plan as workers get it, for requests that accept only that. */
static struct MHD_Response *encoded(const struct plan *plan)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    plan_encode(&w, plan);
    struct MHD_Response *response =
        w.failed ? NULL : response_of_copy(w.data, w.size_bytes, PLAN_TYPE);
    bytes_writer_fini(&w);
    return response;
}

static void on_planned(void *ctx, const struct fault *fault, json_t *report,
                       const struct plan *plan)
{
    struct request *r = ctx;
    if (!request_back(r)) return;
    const char *accepted = request_header(r, "Accept");
    if (fault && fault->code)
        request_fault(r, fault);
    else if (accepted && strcmp(accepted, PLAN_TYPE) == 0)
        request_answer(r, 200, encoded(plan));
    else
        request_json(r, 200, json_pack("{s:O}", "plan", report));
}

/* Visible ASCII, so that it can be logged and compared byte by byte. False: a problem was sent. */
static bool read_key(struct request *r, const char **key)
{
    *key = request_header(r, "Idempotency-Key");
    if (!*key) return true;
    size_t n = strlen(*key);
    bool plain = n >= 1 && n <= LIMIT_IDEMPOTENCY_KEY_BYTES;
    for (size_t i = 0; plain && i < n; i++) plain = (*key)[i] > 0x20 && (*key)[i] < 0x7f;
    if (!plain)
        request_problem(r, PROBLEM_MALFORMED,
                        "an Idempotency-Key has 1 to 128 visible ASCII characters", NULL);
    return plain;
}

/* A document on its way into a job. A large one takes tens of milliseconds to read, a library
 * longer to load: the pool does that, while the loop serves others. */
struct reading {
    struct pool_task task;
    struct request *request;
    const char *text; /* the request's body, which stays while it is held */
    size_t size_bytes;
    bool is_read;
    struct job job;
    struct digest digest; /* of the text */
    struct fault fault;
    int error;
};

static void read_document(struct reading *d)
{
    d->error = job_read(d->text, d->size_bytes, &d->job, &d->fault);
    if (!d->error) digest_of(d->text, d->size_bytes, &d->digest);
    d->is_read = true;
}

static void reading_run(struct pool_task *task)
{
    struct reading *d = (struct reading *)task;
    if (!d->is_read) read_document(d);
    if (!d->error && jobs_needs_library(&d->job)) jobs_load_library();
}

/* Takes the job. */
static void submit(struct request *r, struct reading *d)
{
    bool dry_run;
    const char *key;
    struct jobs *jobs = r->http->options.jobs;
    if (d->error) {
        request_fault(r, &d->fault);
    } else if (!request_flag(r, "dry_run", &dry_run) || !read_key(r, &key)) {
        job_fini(&d->job);
    } else {
        request_hold(r);
        if (dry_run)
            jobs_dry_run(jobs, &r->principal, &d->job, on_planned, r);
        else
            jobs_submit(jobs, &r->principal, &d->job, key, &d->digest, on_submitted, r);
    }
}

static void reading_done(struct pool_task *task)
{
    struct reading *d = (struct reading *)task;
    if (request_back(d->request))
        submit(d->request, d);
    else if (!d->error)
        job_fini(&d->job);
    free(d);
}

void route_job_submit(struct request *r)
{
    bool dry_run;
    const char *key;
    struct reading *d = NULL;
    if (!request_flag(r, "dry_run", &dry_run) || !read_key(r, &key)) return;
    if (!(d = calloc(1, sizeof *d))) {
        request_problem(r, PROBLEM_OUT_OF_MEMORY, NULL, NULL);
        return;
    }
    d->task = (struct pool_task){.run = reading_run, .done = reading_done};
    d->request = r;
    d->text = r->body ? r->body : "";
    d->size_bytes = r->body_bytes;
    if (d->size_bytes <= READ_HERE_BYTES) read_document(d);
    if (!d->is_read || (!d->error && jobs_needs_library(&d->job))) {
        request_hold(r);
        thread_pool_submit(r->http->options.pool, &d->task);
        return;
    }
    submit(r, d);
    free(d);
}

/* The query of a listing, checked. */
static bool read_listing(struct request *r, struct job_listing *out)
{
    const char *limit = target_parameter(&r->target, "limit"), *fault = NULL;
    enum job_state state;
    *out = (struct job_listing){0};
    out->cursor = target_parameter(&r->target, "cursor");
    out->state = target_parameter(&r->target, "state");
    out->text = target_parameter(&r->target, "text");
    out->name = target_parameter(&r->target, "name");
    out->label = target_parameter(&r->target, "label");
    out->limit = LIMIT_LIST_ROWS / 2;
    if (limit) {
        size_t digits = strspn(limit, "0123456789");
        out->limit = digits >= 1 && digits <= 4 && !limit[digits] ? (size_t)atoi(limit) : 0;
    }
    if (out->limit < 1 || out->limit > LIMIT_LIST_ROWS)
        fault = "limit must be a number from 1 to 100";
    else if (out->state && !job_state_from_name(out->state, &state))
        fault = "state must be queued, importing, running, resting, finished, failed or cancelled";
    else if (out->cursor && !job_id_is_valid(out->cursor))
        fault = "cursor must be the next of an earlier page";
    else if (out->text && (!out->text[0] || strlen(out->text) > LIMIT_LIST_TEXT_BYTES))
        fault = "text must have 1 to 128 bytes";
    else if (out->name && (!out->name[0] || strlen(out->name) > LIMIT_LIST_TEXT_BYTES))
        fault = "name must have 1 to 128 bytes";
    else if (out->label && job_label_fault(out->label))
        fault = "label must be a label: 1 to 64 characters, none of them a comma or a control";
    if (fault) request_problem(r, PROBLEM_MALFORMED, fault, NULL);
    return !fault;
}

/* Every byte that is no letter or digit as %XX: three times the bytes and an end. */
static void escape(const char *text, char *out)
{
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        bool plain =
            (*c >= '0' && *c <= '9') || (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z');
        out += sprintf(out, plain ? "%c" : "%%%02X", *c);
    }
}

/* Adds "&key=value" to an address; nothing without a value. */
static void add_parameter(char *link, size_t capacity, const char *key, const char *value)
{
    char escaped[3 * 4 * LIMIT_JOB_LABEL + 1]; /* of the longest value that read_listing lets in */
    if (!value) return;
    const size_t length = strlen(link);
    escape(value, escaped);
    snprintf(link + length, capacity - length, "&%s=%s", key, escaped);
}
_Static_assert(4 * LIMIT_JOB_LABEL >= LIMIT_LIST_TEXT_BYTES, "a text fits, too");

/* RFC 8288: where the next page is. */
static void add_next_link(struct request *r, struct MHD_Response *response, const char *next)
{
    struct job_listing listing;
    char link[256 + 3 * (2 * LIMIT_LIST_TEXT_BYTES + 4 * LIMIT_JOB_LABEL)];
    if (!next || !read_listing(r, &listing)) return;
    snprintf(link, sizeof link, "</v1/jobs?limit=%zu&cursor=%.64s", listing.limit, next);
    add_parameter(link, sizeof link, "state", listing.state);
    add_parameter(link, sizeof link, "text", listing.text);
    add_parameter(link, sizeof link, "name", listing.name);
    add_parameter(link, sizeof link, "label", listing.label);
    strcat(link, ">; rel=\"next\"");
    response_header(response, "Link", link);
}

static void on_listed(void *ctx, int error, json_t *body)
{
    struct request *r = ctx;
    if (!request_back(r)) return;
    if (error == ERR_STATE) {
        request_problem(r, PROBLEM_BUSY, "another search for a text is running", NULL);
        return;
    }
    if (error) {
        job_body_error(r, error);
        return;
    }
    struct MHD_Response *response = job_body_tagged(r, body);
    if (!response) return;
    add_next_link(r, response, json_string_value(json_object_get(body, "next")));
    request_answer(r, 200, response);
}

void route_job_list(struct request *r)
{
    struct job_listing listing;
    if (!read_listing(r, &listing)) return;
    request_hold(r);
    jobs_list(r->http->options.jobs, &r->principal, &listing, on_listed, r);
}

static void on_got(void *ctx, int error, json_t *body)
{
    struct request *r = ctx;
    if (request_back(r)) job_body_send(r, error, body);
}

void route_job_get(struct request *r)
{
    request_hold(r);
    jobs_get(r->http->options.jobs, &r->principal, r->match.job, on_got, r);
}

static void on_cancelled(void *ctx, int error)
{
    struct request *r = ctx;
    const char *purge = NULL;
    if (!request_back(r)) return;
    purge = target_parameter(&r->target, "purge");
    bool purged = purge && (*purge == '1' || *purge == 't');
    if (error == ERR_STATE)
        request_problem(r, PROBLEM_ENDED, "it can only be removed now, with purge=1", NULL);
    else if (error)
        job_body_error(r, error);
    else if (purged)
        request_answer(r, 204, response_empty());
    else
        request_json(r, 202, json_pack("{s:s, s:b}", "id", r->match.job, "cancelled", 1));
}

void route_job_delete(struct request *r)
{
    bool purge;
    if (!request_flag(r, "purge", &purge)) return;
    request_hold(r);
    jobs_cancel(r->http->options.jobs, &r->principal, r->match.job, purge, on_cancelled, r);
}
