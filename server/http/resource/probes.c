/* /livez and /readyz: is the loop alive; can a job be kept, and is there anybody to render it. */
#include "server/http/request.h"

void route_livez(struct request *r)
{
    request_ok(r);
}

void route_readyz(struct request *r)
{
    readiness_ask(r->http, r);
}
