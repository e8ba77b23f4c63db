#include "server/http/request_log.h"

#include <strings.h>

#include "server/http/request.h"

struct header_find {
    const char *value;
    unsigned count;
};

static enum MHD_Result find_parent(void *ctx, enum MHD_ValueKind kind, const char *name,
                                   const char *value)
{
    struct header_find *found = ctx;
    (void)kind;
    if (strcasecmp(name, "traceparent") == 0) {
        found->value = value;
        found->count++;
    }
    return MHD_YES;
}

/* Begins a request's trace. A request with two traceparents begins its own, as neither is valid. */
void request_log_begin(struct request *r)
{
    struct header_find found = {0};
    MHD_get_connection_values(r->mhd, MHD_HEADER_KIND, find_parent, &found);
    trace_context_begin(&r->http->traces, found.count == 1 ? found.value : NULL, &r->trace);
    r->principal.trace = r->trace;
}

void request_log_answer(struct request *r)
{
    char parent[TRACE_CONTEXT_PARENT_BYTES];
    trace_context_write(&r->trace, parent);
    response_header(r->response, "X-Request-Id", r->trace.request);
    response_header(r->response, "traceparent", parent);
}

static bool is_asked_all_the_time(enum route_id id)
{
    return id == ROUTE_LIVEZ || id == ROUTE_READYZ || id == ROUTE_METRICS || id == ROUTE_INDEX ||
           id == ROUTE_FILE || id == ROUTE_OPENAPI;
}

/* 503 and 507 are said on purpose and pass. */
static enum log_level level_of(unsigned status)
{
    return status == 500 ? LOG_ERROR : status > 500 ? LOG_WARNING : LOG_INFO;
}

/* Logs the route's pattern in place of the target, which may hold anything, secrets, too. */
void request_log_end(const struct request *r)
{
    const bool known = r->match.id < ROUTE_COUNT;
    if (is_asked_all_the_time(r->match.id) && r->status < 500) return;
    const uint64_t now_us = uv_hrtime() / 1000;
    const struct log_field fields[] = {
        {"method", known ? method_name(r->method) : "", 0},
        {"route", known ? route_of(r->match.id)->path : "none", 0},
        {"status", NULL, r->status},
        {"duration_seconds", NULL, (double)(now_us - r->start_us) * 1e-6},
        {"job", r->job[0] ? r->job : r->match.job, 0},
        {"owner", r->principal.owner, 0},
    };
    log_write(r->http->options.log, level_of(r->status), "request",
              r->trace.request[0] ? &r->trace : NULL, fields, sizeof fields / sizeof fields[0]);
}
