#include "server/cli/coordinator.h"

#include <assert.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include <uv.h>

#include "server/http/http.h"
#include "server/job/prepare/studio_light.h"

/* How long the coordinator goes on after its end has begun, so that viewers learn of it and answers
 * under way go out. The first is the least while clients are connected, the second the most. */
#define FAREWELL_MS      100
#define FAREWELL_MAX_MS  10000
#define FAREWELL_LOOK_MS 2

struct coordinator {
    uv_loop_t loop;
    uv_signal_t term, interrupt, hangup;
    uv_timer_t farewell;
    struct objects objects;
    struct job_store *store;
    struct spools *spools;
    struct thread_pool *pool;
    struct streams *streams;
    struct webhooks *webhooks;
    struct jobs *jobs;
    struct fleet *fleet;
    struct http *http;
    void (*stopping)(int signal);
    void (*reloaded)(size_t count, const struct fault *fault);
    uint64_t ending_ms; /* of the loop's clock: since when */
    bool ending, closed;
};

/* Closes the rooms in reverse. First no more work is given out. Then threads and store finish what
 * they have, whose answers still reach the HTTP side. Then that goes, and the workers. */
static void close_rooms(struct coordinator *c)
{
    if (c->closed) return;
    c->closed = true;
    if (c->jobs) jobs_stop(c->jobs);
    if (c->http) http_stop(c->http);
    webhooks_stop(c->webhooks);
    thread_pool_destroy(&c->pool);
    spools_destroy(&c->spools);
    job_store_close(&c->store);
    http_destroy(&c->http);
    if (c->fleet) fleet_close(c->fleet, NULL, NULL);
    c->fleet = NULL;
    uv_close((uv_handle_t *)&c->farewell, NULL);
}

static void on_farewell(uv_timer_t *timer)
{
    struct coordinator *c = timer->data;
    if (c->closed) return;
    const uint64_t spent_ms = uv_now(&c->loop) - c->ending_ms;
    const bool is_late = spent_ms >= FAREWELL_MAX_MS;
    const bool is_answered = spent_ms >= FAREWELL_MS && http_in_work(c->http) == 0;
    if (is_late || is_answered || http_connections(c->http) == 0) close_rooms(c);
}

static void on_signal(uv_signal_t *handle, int signal)
{
    struct coordinator *c = handle->data;
    if (c->ending) _exit(128 + signal);
    c->ending = true;
    if (c->stopping) c->stopping(signal);
    http_drain(c->http);
    c->ending_ms = uv_now(&c->loop);
    uv_timer_start(&c->farewell, on_farewell, FAREWELL_LOOK_MS, FAREWELL_LOOK_MS);
}

static void on_hangup(uv_signal_t *handle, int signal)
{
    struct coordinator *c = handle->data;
    struct fault fault = {0};
    size_t count = 0;
    (void)signal;
    if (c->closed) return;
    int error = http_reload_tokens(c->http, &count, &fault);
    if (c->reloaded) c->reloaded(count, error ? &fault : NULL);
}

/* Signals and the farewell do not keep the loop alive. */
static void init_loop(struct coordinator *c)
{
    int error = uv_loop_init(&c->loop);
    error |= uv_signal_init(&c->loop, &c->term);
    error |= uv_signal_init(&c->loop, &c->interrupt);
    error |= uv_signal_init(&c->loop, &c->hangup);
    error |= uv_timer_init(&c->loop, &c->farewell);
    assert(error == 0);
    c->term.data = c->interrupt.data = c->hangup.data = c->farewell.data = c;
    uv_signal_start(&c->term, on_signal, SIGTERM);
    uv_signal_start(&c->interrupt, on_signal, SIGINT);
    uv_unref((uv_handle_t *)&c->term);
    uv_unref((uv_handle_t *)&c->interrupt);
    uv_unref((uv_handle_t *)&c->hangup);
}

/* Builds before 0.1.0 kept what is in the tables asset_owners and removals as files of these
 * folders. */
static void tell_of_old_folders(const struct coordinator_options *options)
{
    static const char *const names[] = {"owners", "removals"};
    char path[DIRECTORIES_PATH_BYTES + 16];
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        snprintf(path, sizeof path, "%s/%s", options->directories->data, names[i]);
        const struct log_field field = {"detail", path, 0};
        if (access(path, F_OK) == 0)
            log_write(options->log, LOG_WARNING, "folder of an older build is ignored", NULL,
                      &field, 1);
    }
}

/* The studio light is the server's own: it is there from the start, and no asset's removal takes it
 * away. A disk that fails is told of when a job needs it. */
static void place_studio_light(const struct objects *objects)
{
    struct environment_header header;
    struct digest blob;
    struct fault ignored = {0};
    studio_light_place(objects, &header, &blob, &ignored);
}

static int open_store(struct coordinator *c, const struct coordinator_options *options,
                      struct fault *fault)
{
    const char *data = options->directories->data;
    int error = objects_open(&c->objects, data, options->ephemeral);
    if (!error) place_studio_light(&c->objects);
    if (!error) error = job_store_open(&c->loop, data, options->ephemeral, &c->store);
    if (!error) {
        tell_of_old_folders(options);
        job_store_set_assets(c->store, &c->objects, (uint64_t)options->tenant_assets_mib << 20);
        job_store_resume_removals(c->store);
    }
    if (!error) error = spools_create(&c->loop, data, &c->spools);
    return error ? fault_set(fault, error, data, "%s", error_text(error)) : 0;
}

/* Tests do not wait for half an hour. */
static uint64_t live_idle_ms(void)
{
    const char *text = getenv("SHEARWATER_LIVE_IDLE_MS");
    const uint64_t ms = text ? strtoull(text, NULL, 10) : 0;
    return ms >= 1 && ms <= 86400000 ? ms : LIVE_IDLE_MS;
}

static int open_webhooks(struct coordinator *c, const struct coordinator_options *options,
                         struct fault *fault)
{
    const struct webhooks_options webhooks = {.loop = &c->loop,
                                              .log = options->log,
                                              .store = c->store,
                                              .hosts = options->webhook_hosts,
                                              .key_path = options->webhook_key};
    return options->webhook_hosts ? webhooks_create(&webhooks, &c->webhooks, fault) : 0;
}

static int open_jobs(struct coordinator *c, const struct coordinator_options *options,
                     struct fault *fault)
{
    int error = thread_pool_create(&c->loop, "pool", options->pool_threads, NULL, &c->pool);
    if (!error) error = streams_create(&c->streams);
    struct jobs_options jobs = {.loop = &c->loop,
                                .log = options->log,
                                .tenant_jobs_max = options->tenant_jobs,
                                .live_idle_ms = live_idle_ms(),
                                .store = c->store,
                                .webhooks = c->webhooks,
                                .objects = &c->objects,
                                .spools = options->ephemeral ? NULL : c->spools,
                                .streams = c->streams,
                                .unwatched = options->unwatched,
                                .pool = c->pool,
                                .import_program = options->directories->import};
    if (!error) error = jobs_create(&jobs, &c->jobs);
    return error ? fault_set(fault, error, "", "%s", error_text(error)) : 0;
}

static int open_fleet(struct coordinator *c, const struct coordinator_options *options,
                      struct fault *fault)
{
    struct fleet_client client = jobs_fleet_client(c->jobs);
    struct fleet_options fleet = {.socket_path = options->directories->socket,
                                  .listen = options->worker_listen,
                                  .key_path = options->worker_key,
                                  .worker_program = options->directories->worker,
                                  .log = options->log,
                                  .cache_dir = options->directories->cache,
                                  .blob_dir = options->directories->blobs,
                                  .local_workers = options->workers,
                                  .worker_threads = options->worker_threads};
    int error = fleet_create(&c->loop, &fleet, &client, &c->fleet, fault);
    if (!error) jobs_set_fleet(c->jobs, c->fleet);
    return error;
}

/* One thread sends for all streams, and has other things to do. */
static int64_t stream_us_per_s(const struct coordinator_options *options)
{
    const int64_t most_us = 500000;
    const int64_t us = INT64_C(10000) * options->stream_share_percent * options->pool_threads;
    return us < most_us ? us : most_us;
}

static int open_http(struct coordinator *c, const struct coordinator_options *options,
                     struct fault *fault)
{
    struct http_options http = {
        .loop = &c->loop,
        .log = options->log,
        .listen = options->listen,
        .tokens_path = options->tokens,
        .certificate_path = options->certificate,
        .key_path = options->key,
        .web_dir = options->directories->web,
        .openapi_path = options->directories->openapi[0] ? options->directories->openapi : NULL,
        .objects = &c->objects,
        .store = c->store,
        .spools = c->spools,
        .pool = c->pool,
        .jobs = c->jobs,
        .webhooks = c->webhooks,
        .fleet = c->fleet,
        .streams = c->streams,
        .feed_bytes_per_s = options->feed_mb_per_s * INT64_C(1000000),
        .stream_us_per_s = stream_us_per_s(options)};
    int error = http_create(&http, &c->http, fault);
    c->reloaded = options->reloaded;
    /* Without tokens a hangup ends the process only when its terminal is gone. */
    if (!error && (options->tokens || !isatty(STDIN_FILENO)))
        uv_signal_start(&c->hangup, on_hangup, SIGHUP);
    return error;
}

int coordinator_create(const struct coordinator_options *options, struct coordinator **out,
                       struct fault *fault)
{
    struct coordinator *c = calloc(1, sizeof *c);
    if (!c) return fault_set(fault, ERR_MEMORY, "", "no memory to start");
    init_loop(c);
    int error = open_store(c, options, fault);
    if (!error) error = open_webhooks(c, options, fault);
    if (!error) error = open_jobs(c, options, fault);
    if (!error) error = open_fleet(c, options, fault);
    if (!error) error = open_http(c, options, fault);
    if (!error && (error = jobs_resume(c->jobs)) != 0)
        fault_set(fault, error, options->directories->data, "unfinished jobs could not be read");
    if (error)
        coordinator_destroy(&c);
    else
        *out = c;
    return error;
}

int coordinator_http_port(const struct coordinator *c)
{
    return http_port(c->http);
}

int coordinator_worker_port(const struct coordinator *c)
{
    return fleet_port(c->fleet);
}

void coordinator_run(struct coordinator *c, void (*stopping)(int signal))
{
    c->stopping = stopping;
    uv_run(&c->loop, UV_RUN_DEFAULT);
}

void coordinator_destroy(struct coordinator **coordinator)
{
    struct coordinator *c = *coordinator;
    *coordinator = NULL;
    if (!c) return;
    close_rooms(c);
    uv_run(&c->loop, UV_RUN_DEFAULT);
    uv_close((uv_handle_t *)&c->term, NULL);
    uv_close((uv_handle_t *)&c->interrupt, NULL);
    uv_close((uv_handle_t *)&c->hangup, NULL);
    uv_run(&c->loop, UV_RUN_DEFAULT);
    jobs_destroy(&c->jobs);
    webhooks_destroy(&c->webhooks);
    streams_destroy(&c->streams);
    int error = uv_loop_close(&c->loop);
    assert(error == 0);
    free(c);
}
