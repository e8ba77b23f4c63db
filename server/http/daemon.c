#include "server/http/daemon.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "server/http/crowd.h"
#include "server/http/listen.h"
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

void peer_deadline(struct peer *peer, uint64_t ms)
{
    peer->deadline_ms = ms ? uv_now(peer->http->options.loop) + ms : 0;
}

void peer_abort(struct peer *peer, unsigned status)
{
    enum problem_id id = status == 413   ? PROBLEM_TOO_LARGE
                         : status == 503 ? PROBLEM_BUSY
                                         : PROBLEM_TIMEOUT;
    const struct problem *p = problem_of(id);
    peer->deadline_ms = 0;
    if (peer->http->tls.key) { /* plain words would be noise there */
        (void)shutdown(peer->fd, SHUT_RDWR);
        return;
    }
    char body[256], text[640];
    int body_bytes =
        snprintf(body, sizeof body,
                 "{\"type\":\"urn:shearwater:problem:%s\",\"title\":\"%s\",\"status\":%u}", p->slug,
                 p->title, p->status);
    int text_bytes = snprintf(text, sizeof text,
                              "HTTP/1.1 %u %s\r\nContent-Type: application/problem+json\r\n"
                              "Content-Length: %d\r\nCache-Control: no-store\r\n"
                              "Connection: close\r\n\r\n%s",
                              p->status, p->title, body_bytes, body);
    (void)send(peer->fd, text, (size_t)text_bytes, MSG_DONTWAIT | MSG_NOSIGNAL);
    lingering_add(&peer->http->lingering, peer->fd);
    (void)shutdown(peer->fd, SHUT_RDWR);
}

/* A request that has begun is told why; one that has not is only closed. */
static void expire(struct peer *peer)
{
    struct request *r = peer->request;
    if (r && r->status == 0) {
        r->status = 408;
        peer_abort(peer, 408);
        return;
    }
    (void)shutdown(peer->fd, SHUT_RDWR);
    peer->deadline_ms = 0;
}

static void *begin_request(void *ctx, const char *uri, struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    struct peer *peer = info ? info->socket_context : NULL;
    return peer ? request_create(ctx, peer, connection, uri) : NULL;
}

static enum MHD_Result step(void *ctx, struct MHD_Connection *connection, const char *url,
                            const char *method, const char *version, const char *data,
                            size_t *size_bytes, void **request)
{
    (void)ctx;
    (void)connection;
    (void)url;
    return *request ? request_step(*request, method, version, data, size_bytes) : MHD_NO;
}

static void end_request(void *ctx, struct MHD_Connection *connection, void **request,
                        enum MHD_RequestTerminationCode code)
{
    struct http *http = ctx;
    struct request *r = *request;
    (void)connection;
    if (!r) return;
    if (code == MHD_REQUEST_TERMINATED_COMPLETED_OK && r->close && !r->handled)
        lingering_add(&http->lingering, r->peer->fd);
    r->peer->served = code == MHD_REQUEST_TERMINATED_COMPLETED_OK && r->handled;
    peer_deadline(r->peer, http->request_ms);
    request_done(r);
    *request = NULL;
}

static void begin_peer(struct http *http, struct MHD_Connection *connection, void **context)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    struct peer *peer = info ? calloc(1, sizeof *peer) : NULL;
    *context = peer;
    if (!peer) return; /* its requests are refused */
    peer->http = http;
    peer->fd = info->connect_fd;
    peer->next = http->peers;
    peer->link = &http->peers;
    if (peer->next) peer->next->link = &peer->next;
    http->peers = peer;
    http->connections++;
    peer_deadline(peer, http->request_ms);
    crowd_make_room(http);
}

static bool has_unread(int fd)
{
    char byte;
    return recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) > 0;
}

/* What MHD refuses by itself (a request line that is too long) it answers and closes at once. */
static void end_peer(struct http *http, struct peer *peer)
{
    if (!peer) return;
    if (!peer->served || has_unread(peer->fd)) lingering_add(&http->lingering, peer->fd);
    if (peer->request) request_done(peer->request);
    *peer->link = peer->next;
    if (peer->next) peer->next->link = peer->link;
    http->connections--;
    free(peer);
}

static void connection_changed(void *ctx, struct MHD_Connection *connection, void **context,
                               enum MHD_ConnectionNotificationCode code)
{
    if (code == MHD_CONNECTION_NOTIFY_STARTED)
        begin_peer(ctx, connection, context);
    else
        end_peer(ctx, *context);
}

static void run(struct http *http);

static void on_pace(uv_timer_t *timer)
{
    struct http *http = timer->data;
    (void)streams_pace(http->options.streams);
    run(http);
}

static void on_run(uv_timer_t *timer)
{
    run(timer->data);
}

static void on_poll(uv_poll_t *poll, int status, int events)
{
    (void)status;
    (void)events;
    run(poll->data);
}

static void run(struct http *http)
{
    MHD_UNSIGNED_LONG_LONG wait_ms;
    MHD_run(http->mhd);
    if (MHD_get_timeout(http->mhd, &wait_ms) == MHD_YES)
        uv_timer_start(&http->run, on_run, wait_ms, 0);
    if (streams_wait(http->options.streams) && !uv_is_active((uv_handle_t *)&http->pace))
        uv_timer_start(&http->pace, on_pace, PACE_EVERY_MS, 0);
}

void http_kick(struct http *http)
{
    if (http->mhd) uv_timer_start(&http->run, on_run, 0, 0);
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
    log_write(http->options.log, LOG_INFO, "a reader that took nothing was cut", NULL, fields, 2);
}

/* How late the loop is: what comes to any of its callbacks waits about as long. Its timers are
 * whole milliseconds. */
static void measure_delay(struct http *http)
{
    const uint64_t now_ns = uv_hrtime(), due_ns = http->tick_ns + TICK_MS * 1000000u;
    if (http->tick_ns)
        duration_histogram_add(&http->delays, now_ns > due_ns ? (now_ns - due_ns) / 1000 : 0);
    http->tick_ns = now_ns;
}

/* Streams would go on for as long as their readers like, also of who has signed out. All else that
 * has begun is let end: the answer to signing out among it. */
static void cut_signed_out(struct http *http)
{
    for (struct request *r = http->requests; r; r = r->next)
        if (r->streams && !access_sign_in_holds(r)) (void)shutdown(r->peer->fd, SHUT_RDWR);
}

static void on_tick(uv_timer_t *timer)
{
    struct http *http = timer->data;
    measure_delay(http);
    uint64_t now = uv_now(http->options.loop);
    for (struct peer *p = http->peers; p; p = p->next)
        if (p->deadline_ms && p->deadline_ms <= now) expire(p);
    cut_signed_out(http);
    lingering_tick(&http->lingering);
    readiness_tick(http);
    held_tick(http);
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
static unsigned connections_most(void)
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
    http->connections_most = connections_most();
    http->mhd = MHD_start_daemon(
        MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG | (tls->key ? MHD_USE_TLS : 0),
        0, NULL, NULL, step, http, MHD_OPTION_EXTERNAL_LOGGER, count_log,
        http,                                                /* first, as MHD demands */
        MHD_OPTION_ARRAY, guarded,                           /**/
        MHD_OPTION_LISTEN_SOCKET, listen_fd,                 /**/
        MHD_OPTION_CONNECTION_LIMIT, http->connections_most, /**/
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)CONNECTION_MEMORY_BYTES,
        MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)((http->request_ms + 999) / 1000),
        MHD_OPTION_STRICT_FOR_CLIENT, 1,                  /**/
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
    uv_timer_init(loop, &http->run);
    uv_timer_init(loop, &http->tick);
    uv_timer_init(loop, &http->pace);
    http->poll.data = http->run.data = http->tick.data = http->pace.data = http;
    http->open_handles = 4;
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

int http_create(const struct http_options *options, struct http **out, struct fault *fault)
{
    int fd = -1, error;
    struct http *http = calloc(1, sizeof *http);
    if (!http) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    http->options = *options;
    trace_source_init(&http->traces);
    http->started_s = (uint64_t)time(NULL);
    http->start_ns = uv_hrtime() ^ ((uint64_t)getpid() << 48);
    http->request_ms = ms_from_env("SHEARWATER_REQUEST_MS", LIMIT_REQUEST_MS);
    http->upload_ms = ms_from_env("SHEARWATER_UPLOAD_MS", LIMIT_UPLOAD_MS);
    http->held.answer_ms = ms_from_env("SHEARWATER_ANSWER_MS", LIMIT_ANSWER_MS);
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
    streams_set_kick(options->streams, on_kick, http);
    streams_set_told_cut(options->streams, on_cut);
    streams_limit(options->streams, options->feed_bytes_per_s,
                  ms_from_env("SHEARWATER_STUCK_MS", LIMIT_STUCK_MS));
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

void http_drain(struct http *http)
{
    http->draining = true;
    streams_end_all(http->options.streams);
    http_kick(http);
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
    MHD_run(h->mhd);
    uv_poll_stop(&h->poll);
    MHD_stop_daemon(h->mhd);
    h->mhd = NULL;
    lingering_close_all(&h->lingering);
    static_files_destroy(&h->files);
    close_guards(h);
    uv_close((uv_handle_t *)&h->poll, on_closed);
    uv_close((uv_handle_t *)&h->run, on_closed);
    uv_close((uv_handle_t *)&h->tick, on_closed);
    uv_close((uv_handle_t *)&h->pace, on_closed);
    *http = NULL;
}
