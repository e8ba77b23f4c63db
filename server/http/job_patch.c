/* PATCH /v1/jobs/{id}: what of a job may change while it lives. */
#include "server/http/request.h"

static void refuse(struct request *r, const struct fault *fault)
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
        refuse(r, fault);
    else
        request_json(r, 200, json_incref(body));
}

void route_job_patch(struct request *r)
{
    request_hold(r);
    jobs_move(r->http->options.jobs, r->match.job, r->body ? r->body : "", r->body_bytes, on_moved,
              r);
}
