/* /v1/workers: the roster, and draining a worker. */
#include <string.h>

#include "server/http/request.h"

/* The jobs that a worker holds tiles of; the fleet knows frames as numbers only. */
#define WORK_LISTED 16

static json_t *work_of(struct request *r, uint64_t worker)
{
    struct fleet_work work[WORK_LISTED];
    char id[JOB_ID_BYTES];
    int32_t number;
    json_t *list = json_array();
    unsigned count = fleet_work(r->http->options.fleet, worker, work, WORK_LISTED);
    for (unsigned i = 0; i < count; i++) {
        if (!jobs_find_work(r->http->options.jobs, &r->principal, work[i].frame_id, id, &number))
            continue;
        json_array_append_new(list, json_pack("{s:s,s:i,s:i}", "job", id, "frame", (int)number,
                                              "tiles", (int)work[i].tiles));
    }
    return list;
}

static json_t *roster_of(struct request *r)
{
    size_t i;
    json_t *worker;
    json_t *roster = fleet_roster(r->http->options.fleet);
    json_array_foreach (roster, i, worker) {
        uint64_t id = (uint64_t)json_integer_value(json_object_get(worker, "id"));
        json_object_set_new(worker, "work", work_of(r, id));
    }
    return roster;
}

void route_worker_list(struct request *r)
{
    struct MHD_Response *response = NULL;
    json_t *body = json_pack("{s:o}", "workers", roster_of(r));
    if (body) response = response_of_json(body, "application/json");
    json_decref(body);
    if (response) response_header(response, "Cache-Control", "no-store");
    request_answer(r, 200, response);
}

/* {"drain": true or false} and nothing else. */
static int read_patch(const struct request *r, bool *drain, struct fault *fault)
{
    json_t *body = NULL;
    const char *name;
    json_t *value;
    int error = json_read(r->body ? r->body : "", r->body_bytes, LIMIT_JOB_BYTES, &body, fault);
    if (error) return error;
    if (!json_is_object(body)) error = fault_set(fault, ERR_TYPE, "", "the body must be an object");
    json_object_foreach (body, name, value) {
        if (error) break;
        char pointer[64];
        snprintf(pointer, sizeof pointer, "/%.60s", name);
        if (strcmp(name, "drain") != 0)
            error = fault_set(fault, ERR_UNKNOWN_MEMBER, pointer, "the only member is drain");
        else if (!json_is_boolean(value))
            error = fault_set(fault, ERR_TYPE, pointer, "drain must be true or false");
        *drain = json_is_true(value);
    }
    if (!error && json_object_size(body) == 0)
        error = fault_set(fault, ERR_MISSING, "/drain", "drain is required");
    json_decref(body);
    return error;
}

static json_t *find_worker(const json_t *roster, uint64_t id)
{
    size_t i;
    json_t *worker;
    json_array_foreach (roster, i, worker)
        if ((uint64_t)json_integer_value(json_object_get(worker, "id")) == id) return worker;
    return NULL;
}

void route_worker_patch(struct request *r)
{
    struct fault fault = {0};
    bool drain = false;
    if (read_patch(r, &drain, &fault) != 0) {
        request_fault(r, &fault);
        return;
    }
    int error = fleet_drain(r->http->options.fleet, r->match.worker, drain);
    if (error == ERR_NOT_FOUND) {
        request_problem(r, PROBLEM_NOT_FOUND, "there is no such worker", NULL);
        return;
    }
    if (error) {
        request_trouble(r, error, error_text(error));
        return;
    }
    json_t *roster = roster_of(r);
    json_t *worker = json_incref(find_worker(roster, r->match.worker));
    json_decref(roster);
    if (worker)
        request_json(r, 200, worker);
    else
        request_problem(r, PROBLEM_NOT_FOUND, "the worker has just left", NULL);
}
