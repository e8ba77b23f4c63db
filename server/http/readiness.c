#include "server/http/readiness.h"

#include "server/http/request.h"

#define FRESH_MS 1000u
#define STUCK_MS 2000u

static void answer(struct request *r, int error)
{
    if (r->http->draining)
        request_problem(r, PROBLEM_DRAINING, "the server is shutting down", NULL);
    else if (error)
        request_trouble(r, error, "nothing new can be kept in the data folder");
    else if (fleet_count(r->http->options.fleet) == 0)
        request_problem(r, PROBLEM_NO_WORKER, "jobs are accepted, and wait for a worker", NULL);
    else
        request_ok(r);
}

/* Looks at the disk, on a thread of its own. */
static void run(void *ctx)
{
    struct readiness *d = ctx;
    d->result = objects_probe(d->http->options.objects);
    uv_async_send(&d->over);
}

static void on_closed(uv_handle_t *handle)
{
    http_release(handle->data);
}

static void on_over(uv_async_t *over)
{
    struct http *http = over->data;
    struct readiness *d = &http->readiness;
    struct request *r = d->waiting;
    if (!d->busy) return;
    uv_thread_join(&d->thread);
    d->busy = false;
    d->waiting = NULL;
    d->error = d->result;
    if (d->closing) uv_close((uv_handle_t *)over, on_closed);
    if (r && request_back(r)) answer(r, d->error);
}

void readiness_open(struct http *http)
{
    struct readiness *d = &http->readiness;
    d->http = http;
    d->over.data = http;
    d->open = uv_async_init(http->options.loop, &d->over, on_over) == 0;
    http->open_handles += d->open;
}

void readiness_close(struct http *http)
{
    struct readiness *d = &http->readiness;
    d->closing = true;
    if (d->open && !d->busy) uv_close((uv_handle_t *)&d->over, on_closed);
}

static bool start(struct http *http)
{
    struct readiness *d = &http->readiness;
    d->asked_ms = uv_now(http->options.loop);
    d->busy = d->open && uv_thread_create(&d->thread, run, d) == 0;
    return d->busy;
}

/* Answers now, or when the disk has. */
void route_readyz(struct request *r)
{
    struct http *http = r->http;
    struct readiness *d = &http->readiness;
    const uint64_t age_ms = uv_now(http->options.loop) - d->asked_ms;
    if (http->draining) {
        answer(r, 0);
    } else if (d->busy) {
        answer(r, age_ms > STUCK_MS ? ERR_IO : d->error);
    } else if (d->asked_ms && age_ms < FRESH_MS) {
        answer(r, d->error);
    } else if (start(http)) {
        request_hold(r);
        d->waiting = r;
    } else {
        answer(r, ERR_MEMORY);
    }
}

void route_livez(struct request *r)
{
    request_ok(r);
}

void readiness_tick(struct http *http)
{
    struct readiness *d = &http->readiness;
    struct request *r = d->waiting;
    if (!r || uv_now(http->options.loop) - d->asked_ms <= STUCK_MS) return;
    d->waiting = NULL;
    d->error = ERR_IO;
    if (request_back(r)) answer(r, ERR_IO);
}
