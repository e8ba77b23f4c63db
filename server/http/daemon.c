#include "server/http/daemon.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "server/http/connection/listen.h"
#include "server/http/request.h"
#include "server/http/static_files.h"
#include "server/http/tenants.h"

#define TICK_MS                 250u
#define CONNECTION_MEMORY_BYTES 24576u
#define DESCRIPTORS_WANTED      (2u * LIMIT_HTTP_CONNECTIONS)

/* MHD's own words are about single connections and come as fast as clients send nonsense. */
static void count_log(void *ctx, const char *format, va_list arguments)
{
    struct http *http = ctx;
    (void)format;
    (void)arguments;
    http->log_lines++;
}

static void *begin_request(void *ctx, const char *uri, struct MHD_Connection *mhd)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    struct connection *connection = info ? info->socket_context : NULL;
    if (connection) (void)streams_meter(connection->http->options.streams, CPU_METER_OTHER);
    return connection ? request_create(ctx, connection, mhd, uri) : NULL;
}

static enum MHD_Result step(void *ctx, struct MHD_Connection *mhd, const char *url,
                            const char *method, const char *version, const char *data,
                            size_t *size_bytes, void **request)
{
    struct http *http = ctx;
    (void)mhd;
    (void)url;
    (void)streams_meter(http->options.streams, CPU_METER_OTHER);
    return *request ? request_step(*request, method, version, data, size_bytes) : MHD_NO;
}

static void end_request(void *ctx, struct MHD_Connection *mhd, void **request,
                        enum MHD_RequestTerminationCode code)
{
    struct http *http = ctx;
    struct request *r = *request;
    (void)mhd;
    if (!r) return;
    if (code == MHD_REQUEST_TERMINATED_COMPLETED_OK && r->close && !r->handled)
        connection_linger(r->connection);
    r->connection->served = code == MHD_REQUEST_TERMINATED_COMPLETED_OK && r->handled;
    connection_deadline(r->connection, http->request_ms);
    request_done(r);
    *request = NULL;
}

/* Runs libmicrohttpd, with CPU time charged to it or to streams. Streams switch the meter when they
 * are asked for bytes, and every other callback switches it back. */
static void run_mhd(struct http *http)
{
    streams_meter_run(http->options.streams);
    MHD_run(http->mhd);
    streams_meter_ran(http->options.streams);
}

static void run(struct http *http);

static void on_rate_limit(uv_timer_t *timer)
{
    struct http *http = timer->data;
    (void)streams_pace(http->options.streams);
    run(http);
}

static void on_run(uv_timer_t *timer)
{
    run(timer->data);
}

static void on_turn(uv_idle_t *turn)
{
    run(turn->data);
}

static void on_poll(uv_poll_t *poll, int status, int events)
{
    struct http *http = poll->data;
    (void)status;
    (void)events;
    if (!uv_is_active((uv_handle_t *)&http->turn)) run(http);
}

/* Runs MHD once a turn of the loop. While sockets take bytes it wants to run again at once, and a
 * timer of 0 ms would let nothing else run. */
static void run(struct http *http)
{
    MHD_UNSIGNED_LONG_LONG wait_ms = 0;
    uv_idle_stop(&http->turn);
    run_mhd(http);
    const bool wants = MHD_get_timeout(http->mhd, &wait_ms) == MHD_YES;
    if (wants && wait_ms > 0)
        uv_timer_start(&http->run, on_run, wait_ms, 0);
    else if (wants)
        http_kick(http);
    if (streams_wait(http->options.streams) && !uv_is_active((uv_handle_t *)&http->rate_limit))
        uv_timer_start(&http->rate_limit, on_rate_limit, RATE_LIMIT_EVERY_MS, 0);
}

void http_kick(struct http *http)
{
    if (http->mhd) uv_idle_start(&http->turn, on_turn);
}

static void on_kick(void *ctx)
{
    http_kick(ctx);
}

static void on_cut(void *ctx, enum reader_kind kind, const char *job)
{
    const struct http *http = ctx;
    const struct log_field fields[] = {{"job", job, 0},
                                       {"stream", kind == READER_PIXELS ? "pixels" : "events", 0}};
    log_write(http->options.log, LOG_INFO, "a reader that took nothing was disconnected", NULL,
              fields, 2);
}

/* Measures how late the loop is. Each of its callbacks waits about as long. Its timers are whole
 * milliseconds. */
static void measure_delay(struct http *http)
{
    const uint64_t now_ns = uv_hrtime(), due_ns = http->tick_ns + TICK_MS * 1000000u;
    if (http->tick_ns)
        duration_histogram_add(&http->delays, now_ns > due_ns ? (now_ns - due_ns) / 1000 : 0);
    http->tick_ns = now_ns;
}

/* Ends streams of users that have signed out, since they would go on for as long as their readers
 * like. All other answers that have begun may end, the one to signing out among them. */
static void cut_signed_out(struct http *http)
{
    for (struct request *r = http->requests; r; r = r->next)
        if (r->streams && !access_sign_in_holds(r)) (void)shutdown(r->connection->fd, SHUT_RDWR);
}

static void on_tick(uv_timer_t *timer)
{
    struct http *http = timer->data;
    measure_delay(http);
    uint64_t now = uv_now(http->options.loop);
    for (struct connection *p = http->open; p; p = p->next)
        if (p->deadline_ms && p->deadline_ms <= now) connection_expire(p);
    cut_signed_out(http);
    linger_tick(&http->linger);
    readiness_tick(http);
    pending_tick(http);
    upload_tick(http);
    streams_tick(http->options.streams);
}

/* Milliseconds from the environment, so that tests need not wait for the real ones. */
static uint64_t ms_from_env(const char *name, uint64_t usual)
{
    const char *text = getenv(name);
    uint64_t ms = text ? strtoull(text, NULL, 10) : 0;
    return ms >= 1 && ms <= 86400000 ? ms : usual;
}

/* Idle clients must not take the descriptors that files, workers and children need. */
static unsigned connections_max(void)
{
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files) != 0) return LIMIT_HTTP_CONNECTIONS / 4;
    if (files.rlim_cur < DESCRIPTORS_WANTED) {
        files.rlim_cur = files.rlim_max < DESCRIPTORS_WANTED ? files.rlim_max : DESCRIPTORS_WANTED;
        if (setrlimit(RLIMIT_NOFILE, &files) != 0) getrlimit(RLIMIT_NOFILE, &files);
    }
    rlim_t half = files.rlim_cur / 2;
    return half < LIMIT_HTTP_CONNECTIONS ? (unsigned)half : LIMIT_HTTP_CONNECTIONS;
}

static int start_mhd(struct http *http, int listen_fd)
{
    const struct tls *tls = &http->tls;
    struct MHD_OptionItem guarded[] = {
        {MHD_OPTION_HTTPS_MEM_CERT, 0, tls->certificate},
        {MHD_OPTION_HTTPS_MEM_KEY, 0, tls->key},
        {MHD_OPTION_HTTPS_PRIORITIES, 0, (void *)(uintptr_t)TLS_PRIORITIES},
        {MHD_OPTION_END, 0, NULL},
    };
    if (!tls->key) guarded[0] = guarded[3];
    http->connections_max = connections_max();
    http->linger.most =
        http->connections_max / 4 < LINGER_MAX ? http->connections_max / 4 : LINGER_MAX;
    http->mhd = MHD_start_daemon(
        MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG | (tls->key ? MHD_USE_TLS : 0),
        0, NULL, NULL, step, http, MHD_OPTION_EXTERNAL_LOGGER, count_log,
        http,                                               /* first, as MHD demands */
        MHD_OPTION_ARRAY, guarded,                          /**/
        MHD_OPTION_LISTEN_SOCKET, listen_fd,                /**/
        MHD_OPTION_CONNECTION_LIMIT, http->connections_max, /**/
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)CONNECTION_MEMORY_BYTES,
        MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)((http->request_ms + 999) / 1000),
        /* What it would refuse is refused by request_check.c and target.c, with answers of ours. */
        MHD_OPTION_STRICT_FOR_CLIENT, 0,                  /**/
        MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1,             /* files go by sendfile */
        MHD_OPTION_URI_LOG_CALLBACK, begin_request, http, /**/
        MHD_OPTION_NOTIFY_COMPLETED, end_request, http,   /**/
        MHD_OPTION_NOTIFY_CONNECTION, connection_changed, http, MHD_OPTION_END);
    return http->mhd ? 0 : ERR_IO;
}

static int start_handles(struct http *http)
{
    uv_loop_t *loop = http->options.loop;
    const union MHD_DaemonInfo *info = MHD_get_daemon_info(http->mhd, MHD_DAEMON_INFO_EPOLL_FD);
    if (!info || uv_poll_init(loop, &http->poll, info->epoll_fd) != 0) return ERR_IO;
    uv_idle_init(loop, &http->turn);
    uv_timer_init(loop, &http->run);
    uv_timer_init(loop, &http->tick);
    uv_timer_init(loop, &http->rate_limit);
    http->poll.data = http->turn.data = http->run.data = http;
    http->tick.data = http->rate_limit.data = http;
    http->open_handles = 5;
    readiness_open(http);
    uv_poll_start(&http->poll, UV_READABLE, on_poll);
    uv_timer_start(&http->tick, on_tick, TICK_MS, TICK_MS);
    return 0;
}

static int open_guards(struct http *http, struct fault *fault)
{
    const struct http_options *o = &http->options;
    int error = 0;
    if (o->certificate_path) error = tls_read(&http->tls, o->certificate_path, o->key_path, fault);
    if (!error) error = access_open(&http->access, o->tokens_path, o->key_path != NULL, fault);
    return error ? error : tenants_share(http, fault);
}

static int open_socket(struct http *http, int *fd, struct fault *fault)
{
    const struct listen_guards guards = {.tokens = http->access.path != NULL,
                                         .tls = http->tls.key != NULL};
    int error = listen_open(http->options.listen, &guards, fd, &http->port, fault);
    if (!error) access_name_cookie(&http->access, http->port);
    return error;
}

static void close_guards(struct http *http)
{
    access_close(&http->access);
    tls_fini(&http->tls);
}

static void init_clocks(struct http *http)
{
    http->started_s = (uint64_t)time(NULL);
    http->start_ns = uv_hrtime() ^ ((uint64_t)getpid() << 48);
    http->request_ms = ms_from_env("SHEARWATER_REQUEST_MS", LIMIT_REQUEST_MS);
    http->upload_ms = ms_from_env("SHEARWATER_UPLOAD_MS", LIMIT_UPLOAD_MS);
    http->pending.answer_ms = ms_from_env("SHEARWATER_ANSWER_MS", LIMIT_ANSWER_MS);
}

static void join_streams(struct http *http)
{
    const struct http_options *options = &http->options;
    const struct streams_limits limits = {.feed_bytes_per_s = options->feed_bytes_per_s,
                                          .cpu_us_per_s = options->stream_us_per_s,
                                          .stuck_ms =
                                              ms_from_env("SHEARWATER_STUCK_MS", LIMIT_STUCK_MS)};
    streams_set_kick(options->streams, on_kick, http);
    streams_set_told_cut(options->streams, on_cut);
    streams_limit(options->streams, &limits);
}

int http_create(const struct http_options *options, struct http **out, struct fault *fault)
{
    int fd = -1, error;
    struct http *http = calloc(1, sizeof *http);
    if (!http) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    http->options = *options;
    trace_context_source_init(&http->traces);
    init_clocks(http);
    error = static_files_load(options->web_dir, options->openapi_path, &http->files, fault);
    if (!error) error = open_guards(http, fault);
    if (!error) error = open_socket(http, &fd, fault);
    if (error) goto fail;
    error = start_mhd(http, fd);
    if (error) {
        close(fd);
        fault_set(fault, error, "listen", "the HTTP server did not start");
        goto fail;
    }
    error = start_handles(http);
    if (error) {
        MHD_stop_daemon(http->mhd);
        fault_set(fault, error, "", "the HTTP server could not join the loop");
        goto fail;
    }
    join_streams(http);
    *out = http;
    return 0;
fail:
    close_guards(http);
    static_files_destroy(&http->files);
    free(http);
    return error;
}

int http_port(const struct http *http)
{
    return http->port;
}

unsigned http_in_work(const struct http *http)
{
    unsigned count = 0;
    for (const struct request *r = http->requests; r; r = r->next) count += r->checked;
    return count;
}

unsigned http_connections(const struct http *http)
{
    return http->connections + http->linger.count;
}

void http_drain(struct http *http)
{
    http->draining = true;
    streams_end_all(http->options.streams);
    http_kick(http);
}

void http_stop(struct http *http)
{
    http->options.pool = NULL;
}

void http_release(struct http *http)
{
    if (--http->open_handles == 0) free(http);
}

static void on_closed(uv_handle_t *handle)
{
    http_release(handle->data);
}

/* MHD stops only when no connection sleeps: those that wait for an answer get one. */
static void release_requests(struct http *http)
{
    for (struct request *r = http->requests; r; r = r->next)
        if (r->suspended && !r->response)
            request_problem(r, PROBLEM_DRAINING, "the server has stopped", NULL);
}

void http_destroy(struct http **http)
{
    struct http *h = *http;
    if (!h) return;
    h->draining = true;
    streams_set_kick(h->options.streams, NULL, NULL);
    streams_set_told_cut(h->options.streams, NULL);
    streams_end_all(h->options.streams);
    release_requests(h);
    run_mhd(h);
    uv_poll_stop(&h->poll);
    MHD_stop_daemon(h->mhd);
    h->mhd = NULL;
    linger_close_all(&h->linger);
    static_files_destroy(&h->files);
    close_guards(h);
    readiness_close(h);
    uv_close((uv_handle_t *)&h->poll, on_closed);
    uv_close((uv_handle_t *)&h->turn, on_closed);
    uv_close((uv_handle_t *)&h->run, on_closed);
    uv_close((uv_handle_t *)&h->tick, on_closed);
    uv_close((uv_handle_t *)&h->rate_limit, on_closed);
    *http = NULL;
}
