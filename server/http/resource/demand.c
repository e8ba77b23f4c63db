/* /v1/stats: the demand for workers as JSON. */
#include "server/http/resource/demand.h"

#include "server/http/request.h"

struct demand demand_now(const struct http *http)
{
    const struct fleet_load load = fleet_load(http->options.fleet);
    struct demand d = {.jobs_waiting = jobs_waiting(http->options.jobs),
                       .tiles_waiting = jobs_tiles_waiting(http->options.jobs),
                       .tiles_leased = load.tiles_leased,
                       .workers = load.workers,
                       .threads = load.threads};
    d.threads_wanted = d.jobs_waiting + d.tiles_waiting + d.tiles_leased;
    return d;
}

void route_stats(struct request *r)
{
    const struct demand d = demand_now(r->http);
    struct MHD_Response *response = NULL;
    json_t *body =
        json_pack("{s:I,s:I,s:I,s:I,s:I,s:I}", "threads_wanted", (json_int_t)d.threads_wanted,
                  "tiles_waiting", (json_int_t)d.tiles_waiting, "tiles_leased",
                  (json_int_t)d.tiles_leased, "jobs_waiting", (json_int_t)d.jobs_waiting, "workers",
                  (json_int_t)d.workers, "threads", (json_int_t)d.threads);
    if (body) response = response_of_json(body, "application/json");
    json_decref(body);
    if (response) response_header(response, "Cache-Control", "no-store");
    request_answer(r, 200, response);
}
