#include "server/http/request.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/json.h"
#include "server/http/etag.h"
#include "server/http/request_body.h"
#include "server/http/request_check.h"
#include "server/http/request_log.h"
#include "server/http/static_files.h"

struct request *request_create(struct http *http, struct connection *connection,
                               struct MHD_Connection *mhd, const char *raw)
{
    struct request *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    r->http = http;
    r->connection = connection;
    r->mhd = mhd;
    r->match.id = ROUTE_COUNT;
    r->start_us = uv_hrtime() / 1000;
    (void)target_read(raw, &r->target, &r->target_fault);
    r->next = http->requests;
    r->link = &http->requests;
    if (r->next) r->next->link = &r->next;
    http->requests = r;
    connection->request = r;
    return r;
}

static void request_free(struct request *r)
{
    upload_drop(&r->upload);
    if (r->response) MHD_destroy_response(r->response);
    target_fini(&r->target);
    free(r->body);
    free(r);
}

/* Gives back the request's share of what all requests share. */
static void give_back(struct http *http, const struct request *r)
{
    http->encodings -= r->encodes;
    http->body_room_bytes -= r->body_room_bytes;
}

void request_done(struct request *r)
{
    struct http *http = r->http;
    *r->link = r->next;
    if (r->next) r->next->link = r->link;
    if (r->connection->request == r) r->connection->request = NULL;
    if (!r->pending) give_back(http, r);
    request_count_add(&http->count, r->match.id, r->status);
    if (!r->streams && r->status)
        duration_histogram_add(&http->count.durations[r->match.id],
                               uv_hrtime() / 1000 - r->start_us);
    request_log_end(r);
    r->http = NULL;
    if (!r->pending) request_free(r);
}

void request_hold(struct request *r)
{
    r->pending = true;
    r->home = r->http;
    r->home->open_handles++;
    r->home->pending.count++;
}

bool request_back(struct request *r)
{
    struct http *home = r->home;
    const bool is_awaited = r->http && !r->overdue;
    r->pending = false;
    r->home = NULL;
    home->pending.count--;
    if (!r->http) {
        give_back(home, r);
        request_free(r);
    }
    http_release(home);
    return is_awaited;
}

void request_answer(struct request *r, unsigned status, struct MHD_Response *response)
{
    if (r->response) { /* the first answer holds */
        if (response) MHD_destroy_response(response);
        return;
    }
    if (!response) response = response_without_memory(&status);
    r->response = response;
    r->status = status;
    if (r->suspended) {
        r->suspended = false;
        MHD_resume_connection(r->mhd);
        http_kick(r->http);
    }
}

void request_json(struct request *r, unsigned status, json_t *body)
{
    request_answer(r, status, response_of_json(body, "application/json"));
    json_decref(body);
}

void request_ok(struct request *r)
{
    struct MHD_Response *response = response_of_copy("{\"status\":\"ok\"}", 15, "application/json");
    if (response) response_header(response, "Cache-Control", "no-store");
    request_answer(r, 200, response);
}

void request_problem(struct request *r, enum problem_id id, const char *detail, const char *pointer)
{
    json_t *body = problem_json(id, detail, pointer);
    struct MHD_Response *response = response_of_json(body, "application/problem+json");
    json_decref(body);
    if (response) {
        response_header(response, "Cache-Control", "no-store");
        if (id == PROBLEM_METHOD) response_header(response, "Allow", r->match.allow);
        if (problem_of(id)->status >= 503 || id == PROBLEM_QUOTA) /* it passes */
            response_header(response, "Retry-After", "5");
    }
    request_answer(r, problem_of(id)->status, response);
}

void request_trouble(struct request *r, int code, const char *detail)
{
    request_problem(r, problem_of_trouble(code), detail, NULL);
}

void request_fault(struct request *r, const struct fault *fault)
{
    enum problem_id id = problem_of_document(fault);
    const char *detail = fault->detail[0] ? fault->detail : error_text(fault->code);
    bool names_asset = id == PROBLEM_MISSING_ASSET && !fault->pointer[0];
    request_problem(r, id, detail, names_asset ? "/scene/asset" : fault->pointer);
}

const char *request_header(const struct request *r, const char *name)
{
    return MHD_lookup_connection_value(r->mhd, MHD_HEADER_KIND, name);
}

bool request_is_head(const struct request *r)
{
    return r->method == METHOD_HEAD;
}

bool request_flag(struct request *r, const char *name, bool *out)
{
    const char *value = target_parameter(&r->target, name);
    *out = value && (strcmp(value, "1") == 0 || strcmp(value, "true") == 0);
    if (!value || *out || strcmp(value, "0") == 0 || strcmp(value, "false") == 0) return true;
    char detail[96];
    snprintf(detail, sizeof detail, "%s must be 0, 1, false or true", name);
    request_problem(r, PROBLEM_MALFORMED, detail, NULL);
    return false;
}

bool request_unchanged(struct request *r, const char *etag)
{
    const char *known = request_header(r, "If-None-Match");
    if (!known || !etag_listed(known, etag)) return false;
    struct MHD_Response *response = response_empty();
    if (response) {
        response_header(response, "ETag", etag);
        response_header(response, "Cache-Control", "no-cache");
    }
    request_answer(r, 304, response);
    return true;
}

/* Requests that are still served while the server shuts down: those that people watch it with. */
static bool served_while_draining(enum route_id id)
{
    return id == ROUTE_LIVEZ || id == ROUTE_READYZ || id == ROUTE_METRICS;
}

static bool find_route(struct request *r, const char *method)
{
    struct fault fault = r->target_fault;
    bool known = method_from_name(method, &r->method);
    int error = fault.code;
    if (!error) {
        bool is_file = static_files_find(r->http->files, r->target.path) != NULL;
        error = route_find(r->method, known, &r->target, is_file, &r->match, &fault);
    }
    if (error == 0) return true;
    if (error == ERR_LIMIT)
        request_problem(r, PROBLEM_URL_TOO_LONG, fault.detail, NULL);
    else if (error == ERR_NOT_FOUND)
        request_problem(r, PROBLEM_NOT_FOUND, fault.detail, NULL);
    else if (error == ERR_STATE)
        request_problem(r, PROBLEM_METHOD, fault.detail, NULL);
    else if (error == ERR_MEMORY)
        request_trouble(r, error, fault.detail);
    else
        request_problem(r, PROBLEM_MALFORMED, fault.detail, NULL);
    return false;
}

static bool check(struct request *r, const char *method, const char *version)
{
    struct body_claim claim;
    r->checked = r->close = true;
    request_log_begin(r);
    (void)method_from_name(method, &r->method);
    if (!request_check(r, version, &claim)) return false;
    r->close = claim.present;
    if (!find_route(r, method) || !access_pass(r)) return false;
    if (r->http->draining && !served_while_draining(r->match.id)) {
        request_problem(r, PROBLEM_DRAINING, "ask again when the server is back", NULL);
        return false;
    }
    return request_body_check(r, &claim);
}

static enum MHD_Result queue(struct request *r)
{
    request_log_answer(r);
    if (r->http->draining || (r->close && !r->handled))
        response_header(r->response, "Connection", "close");
    if (r->streams) {
        MHD_set_connection_option(r->mhd, MHD_CONNECTION_OPTION_TIMEOUT, 0u);
        connection_deadline(r->connection, 0);
    } else {
        connection_deadline(r->connection, r->http->upload_ms);
    }
    enum MHD_Result result = MHD_queue_response(r->mhd, r->status, r->response);
    MHD_destroy_response(r->response);
    r->response = NULL;
    return result;
}

/* Returns whether a route may wait. One that never does is answered however many others wait. */
static bool may_wait(enum route_id id)
{
    const char *path = route_of(id)->path;
    return strncmp(path, "/v1/jobs", 8) == 0 || strncmp(path, "/v1/assets", 10) == 0;
}

/* Begins the answer, whose time pending.h bounds. */
static void begin_answer(struct request *r)
{
    json_begin();
    r->handled = true;
    r->handled_ms = uv_now(r->http->options.loop);
    connection_deadline(r->connection, 0);
    const int error = r->upload ? upload_error(r->upload) : r->body_error;
    if (error)
        request_body_refuse(r, error);
    else if (may_wait(r->match.id) && !pending_has_room(r->http))
        request_problem(r, PROBLEM_BUSY, "too many requests wait for the disk", NULL);
    else
        route_of(r->match.id)->handle(r);
    if (!r->response && !r->pending) request_problem(r, PROBLEM_INTERNAL, NULL, NULL);
}

static enum MHD_Result handle(struct request *r)
{
    if (r->status && !r->response) return MHD_NO; /* cut off meanwhile */
    if (!r->handled && !r->response && r->upload && !upload_is_written(r->upload)) {
        request_body_sleep(r);
        return MHD_YES;
    }
    if (!r->handled && !r->response) begin_answer(r);
    if (r->response) return queue(r);
    r->suspended = true;
    MHD_suspend_connection(r->mhd);
    return MHD_YES;
}

/* Refuses the request. A connection whose body is not read cannot go on, so the answer is queued at
 * once; else in the next call. */
static enum MHD_Result refuse(struct request *r)
{
    if (r->close) return queue(r);
    r->handled = true;
    return MHD_YES;
}

static enum MHD_Result begin(struct request *r, const char *method, const char *version)
{
    if (!check(r, method, version)) return refuse(r);
    if (r->opens) request_body_sleep(r);
    return MHD_YES;
}

/* There is a file for the body now, or there cannot be one. */
static enum MHD_Result opened(struct request *r)
{
    const int error = upload_error(r->upload);
    r->opens = false;
    if (error && !r->response) request_body_refuse(r, error);
    return r->response ? refuse(r) : MHD_YES;
}

enum MHD_Result request_step(struct request *r, const char *method, const char *version,
                             const char *data, size_t *size_bytes)
{
    if (!r->checked) return begin(r, method, version);
    if (r->opens) return opened(r);
    if (*size_bytes == 0) return handle(r);
    return request_body_take(r, data, size_bytes);
}
