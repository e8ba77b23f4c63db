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

static void run(uv_work_t *work)
{
    struct readiness *d = work->data;
    d->result = objects_probe(d->http->options.objects);
}

static void done(uv_work_t *work, int status)
{
    struct readiness *d = work->data;
    struct http *http = d->http;
    struct request *r = d->waiting;
    d->busy = false;
    d->waiting = NULL;
    d->error = status ? ERR_IO : d->result;
    if (r && request_back(r)) answer(r, d->error);
    http_release(http);
}

static bool start(struct http *http)
{
    struct readiness *d = &http->readiness;
    d->http = http;
    d->work.data = d;
    d->asked_ms = uv_now(http->options.loop);
    if (uv_queue_work(http->options.loop, &d->work, run, done) != 0) return false;
    d->busy = true;
    http->open_handles++;
    return true;
}

void readiness_ask(struct http *http, struct request *r)
{
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

void readiness_tick(struct http *http)
{
    struct readiness *d = &http->readiness;
    struct request *r = d->waiting;
    if (!r || uv_now(http->options.loop) - d->asked_ms <= STUCK_MS) return;
    d->waiting = NULL;
    d->error = ERR_IO;
    if (request_back(r)) answer(r, ERR_IO);
}
