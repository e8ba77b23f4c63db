/* /livez and /readyz: is the loop alive, is there anybody to render. */
#include "server/http/request.h"

static void answer_ok(struct request *r)
{
    struct MHD_Response *response = response_of_copy("{\"status\":\"ok\"}", 15, "application/json");
    if (response) response_header(response, "Cache-Control", "no-store");
    request_answer(r, 200, response);
}

void route_livez(struct request *r)
{
    answer_ok(r);
}

void route_readyz(struct request *r)
{
    if (r->http->draining)
        request_problem(r, PROBLEM_DRAINING, "the server is shutting down", NULL);
    else if (fleet_count(r->http->options.fleet) == 0)
        request_problem(r, PROBLEM_NO_WORKER, "jobs are accepted, and wait for a worker", NULL);
    else
        answer_ok(r);
}
