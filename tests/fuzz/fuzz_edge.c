// sources: tests/fuzz/answers.c server/http/*.c server/http/*/*.c server/stream/*.c
// sources: server/access/*.c server/store/*.c server/metric/*.c
// archives: libserver.a
// libs: -lmicrohttpd -luv -lsqlite3 -lOpenEXR-3_1 -lOpenEXRCore-3_1 -lstdc++ -lpng -lcurl
/* The coordinator's HTTP edge with libmicrohttpd, store, streams and jobs behind it, over real
 * sockets. Input: the bytes that clients send, where 0xff and another byte make a step: the loop
 * comes to rest (0: what is sent goes in halves), no more will be sent (1), a new connection (2),
 * the next one of those there are (3), a connection broken off (4). There is one job, which waits,
 * has events and shows a picture.
 *
 * Whatever came, what came back on a connection is a row of whole answers
 * (answers.h), and nothing of its requests is left: no memory, count or file. */
#include <arpa/inet.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/http/request.h"
#include "server/stream/streams.h"
#include "tests/fuzz/answers.h"
#include "tests/fuzz/patience.h"

#define CLIENTS_MAX  4
#define RUNS_MAX     256 /* of one coordinator */
#define QUIET_ROUNDS 3
#define EPOCH        0x5ea4a7e4u
#define JOB          "01hzy0000000000000000000ab"
#define DOCUMENT                                                                                   \
    "{\"scene\":{\"asset\":\"000000000000000000000000000000000000000000000000000000000000000a\"}}"

static struct {
    uv_loop_t loop;
    char dir[64];
    struct objects objects;
    struct job_store *store;
    struct spools *spools;
    struct thread_pool *pool;
    struct streams *streams;
    struct jobs *jobs;
    struct fleet *fleet;
    struct http *http;
    struct image *image;
    int runs;
    bool is_up;
} edge;

struct client {
    int fd;
    bool reset, sent_all, ended;
    bool asked_heads; /* what it sent has the word HEAD in it */
    unsigned letters; /* of that word, at the end of what it sent */
    char *text;       /* owned: what came */
    size_t text_bytes;
};
static struct client clients[CLIENTS_MAX];
static int client_count;

#define must(holds) must_at(holds, __LINE__)
static void must_at(bool holds, int line)
{
    if (holds) return;
    fprintf(stderr, "fuzz_edge.c:%d does not hold (errno: %s)\n", line, strerror(errno));
    for (int i = 0; i < client_count; i++)
        fwrite(clients[i].text, 1, clients[i].text_bytes, stderr);
    abort();
}

/* -- the coordinator -- */

static void on_inserted(void *ctx, int error, const char *existing)
{
    (void)existing;
    must(error == 0);
    *(bool *)ctx = true;
}

static void put_job(void)
{
    const struct job_row row = {.id = JOB, .document = DOCUMENT, .state = "queued", .paused = true};
    const struct digest body = {0};
    bool done = false;
    job_store_insert(edge.store, &row, NULL, &body, on_inserted, &done);
    while (!done) uv_run(&edge.loop, UV_RUN_ONCE);
}

/* Ids of events begin with the life's epoch, which is chosen here so that inputs can name them. */
static void show_job(void)
{
    edge.streams->epoch = EPOCH;
    for (int i = 0; i < 3; i++) {
        json_t *data = json_pack("{s:i}", "tiles_done", i);
        stream_event(edge.streams, JOB, i == 1 ? "state" : "progress", data, false);
        json_decref(data);
    }
    must(image_create(1, 40, 40, &edge.image) == 0);
    stream_image(edge.streams, JOB, edge.image);
    stream_pixels(edge.streams, JOB, (struct rect){0, 0, 40, 40});
}

static void open_rooms(void)
{
    must(objects_open(&edge.objects, edge.dir, false) == 0);
    must(job_store_open(&edge.loop, edge.dir, false, &edge.store) == 0);
    job_store_set_assets(edge.store, &edge.objects, 0);
    must(spools_create(&edge.loop, edge.dir, &edge.spools) == 0);
    must(thread_pool_create(&edge.loop, "pool", 1, NULL, &edge.pool) == 0);
    must(streams_create(&edge.streams) == 0);
    struct jobs_options jobs = {.loop = &edge.loop,
                                .store = edge.store,
                                .objects = &edge.objects,
                                .spools = edge.spools,
                                .streams = edge.streams,
                                .pool = edge.pool,
                                .live_idle_ms = LIVE_IDLE_MS,
                                .import_program = "/bin/false"};
    must(jobs_create(&jobs, &edge.jobs) == 0);
    char socket_path[96];
    snprintf(socket_path, sizeof socket_path, "%s/socket", edge.dir);
    struct fleet_client client = jobs_fleet_client(edge.jobs);
    struct fleet_options fleet = {.socket_path = socket_path,
                                  .worker_program = "/bin/false",
                                  .cache_dir = edge.dir,
                                  .blob_dir = edge.dir};
    struct fault fault = {0};
    must(fleet_create(&edge.loop, &fleet, &client, &edge.fleet, &fault) == 0);
    jobs_set_fleet(edge.jobs, edge.fleet);
}

static void open_edge(void)
{
    struct fault fault = {0};
    signal(SIGPIPE, SIG_IGN);
    memset(&edge, 0, sizeof edge);
    snprintf(edge.dir, sizeof edge.dir, "/dev/shm/fuzz-edge-XXXXXX");
    must(mkdtemp(edge.dir) != NULL && uv_loop_init(&edge.loop) == 0);
    open_rooms();
    struct http_options http = {.loop = &edge.loop,
                                .listen = "127.0.0.1:0",
                                .objects = &edge.objects,
                                .store = edge.store,
                                .spools = edge.spools,
                                .pool = edge.pool,
                                .jobs = edge.jobs,
                                .fleet = edge.fleet,
                                .streams = edge.streams};
    must(http_create(&http, &edge.http, &fault) == 0);
    put_job();
    must(jobs_resume(edge.jobs) == 0);
    show_job();
    edge.is_up = true;
}

static void close_edge(void)
{
    if (!edge.is_up) return;
    stream_image(edge.streams, JOB, NULL);
    jobs_stop(edge.jobs);
    thread_pool_destroy(&edge.pool);
    spools_destroy(&edge.spools);
    job_store_close(&edge.store);
    http_destroy(&edge.http);
    fleet_close(edge.fleet, NULL, NULL);
    uv_run(&edge.loop, UV_RUN_DEFAULT);
    jobs_destroy(&edge.jobs);
    streams_destroy(&edge.streams);
    must(uv_loop_close(&edge.loop) == 0);
    image_destroy(&edge.image);
    objects_remove_dir(edge.dir);
    edge.is_up = false;
}

/* -- the clients -- */

static struct client *connect_one(void)
{
    if (client_count == CLIENTS_MAX) return &clients[CLIENTS_MAX - 1];
    struct client *c = &clients[client_count++];
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)http_port(edge.http)),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    *c = (struct client){.fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    must(c->fd >= 0 && is_connected(c->fd, &address));
    must(fcntl(c->fd, F_SETFL, O_NONBLOCK) == 0);
    return c;
}

/* True when something came. */
static bool receive(struct client *c)
{
    char piece[65536];
    if (c->ended || c->fd < 0) return false;
    const ssize_t got = recv(c->fd, piece, sizeof piece, 0);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return false;
    if (got <= 0) {
        c->ended = true;
        c->reset |= got < 0; /* bytes that were under way may be lost */
        return true;
    }
    c->text = realloc(c->text, c->text_bytes + (size_t)got);
    must(c->text != NULL);
    memcpy(c->text + c->text_bytes, piece, (size_t)got);
    c->text_bytes += (size_t)got;
    return true;
}

/* Threads have something that will come back. */
static bool is_at_work(void)
{
    return edge.http->pending.count > 0 || edge.loop.active_reqs.count > 0;
}

static bool turn(void)
{
    bool moved = is_at_work();
    uv_run(&edge.loop, moved ? UV_RUN_ONCE : UV_RUN_NOWAIT);
    for (int i = 0; i < client_count; i++) moved |= receive(&clients[i]);
    return moved;
}

static void settle(void)
{
    for (int quiet = 0; quiet < QUIET_ROUNDS; quiet++)
        if (turn()) quiet = -1;
}

/* Pieces are sent on their own: the word may begin in one and end in another. */
static void look_for_heads(struct client *c, const uint8_t *data, size_t size_bytes)
{
    static const char word[] = "HEAD";
    for (size_t i = 0; i < size_bytes; i++) {
        const bool goes_on = data[i] == (uint8_t)word[c->letters];
        c->letters = goes_on ? c->letters + 1 : data[i] == (uint8_t)word[0];
        if (word[c->letters]) continue;
        c->asked_heads = true;
        c->letters = 0;
    }
}

static void send_all(struct client *c, const uint8_t *data, size_t size_bytes)
{
    while (size_bytes > 0 && c->fd >= 0 && !c->sent_all && !c->ended) {
        const ssize_t sent = send(c->fd, data, size_bytes, MSG_NOSIGNAL);
        if (sent < 0 && errno != EAGAIN && errno != EINTR) return;
        if (sent < 0) (void)turn();
        if (sent > 0) {
            look_for_heads(c, data, (size_t)sent);
            data += sent;
            size_bytes -= (size_t)sent;
        }
    }
}

static void finish_sending(struct client *c)
{
    if (c->fd >= 0) (void)shutdown(c->fd, SHUT_WR);
    c->sent_all = true;
}

static void break_off(struct client *c)
{
    const struct linger at_once = {.l_onoff = 1};
    if (c->fd < 0) return;
    (void)setsockopt(c->fd, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    close(c->fd);
    c->fd = -1;
    c->ended = c->reset = true;
}

static void send_input(const uint8_t *data, size_t size_bytes)
{
    struct client *c = connect_one();
    while (size_bytes > 0) {
        const uint8_t *step = memchr(data, 0xff, size_bytes);
        const size_t bytes = step ? (size_t)(step - data) : size_bytes;
        send_all(c, data, bytes);
        const size_t used = bytes + (step ? 2 : 0);
        if (used >= size_bytes) return;
        data += used;
        size_bytes -= used;
        switch (data[-1]) {
        case 0:
            settle();
            break;
        case 1:
            finish_sending(c);
            break;
        case 2:
            c = connect_one();
            break;
        case 3:
            c = &clients[(c - clients + 1) % client_count];
            break;
        case 4:
            break_off(c);
            break;
        default:
            send_all(c, data - 2, 2);
        }
    }
}

static size_t bytes_received(void)
{
    size_t sum = 0;
    for (int i = 0; i < client_count; i++) sum += clients[i].text_bytes;
    return sum;
}

/* Nobody sends any more, and streams are told to end: what was asked is answered. A connection
 * whose client has only said that it will send no more may wait for its deadline; here it is broken
 * off. */
static void await_answers(void)
{
    size_t before_bytes;
    for (int i = 0; i < client_count; i++) finish_sending(&clients[i]);
    settle();
    do { /* behind a stream that ends another one may begin, which was asked for meanwhile */
        before_bytes = bytes_received();
        streams_end_all(edge.streams);
        settle();
    } while (bytes_received() != before_bytes);
}

/* -- what must hold -- */

static bool folder_is_empty(const char *name)
{
    char path[96];
    bool empty = true;
    snprintf(path, sizeof path, "%s/%s", edge.dir, name);
    DIR *folder = opendir(path);
    must(folder != NULL);
    for (const struct dirent *e; (e = readdir(folder));) empty &= e->d_name[0] == '.';
    closedir(folder);
    return empty;
}

static bool nothing_is_left(void)
{
    const struct http *h = edge.http;
    return h->connections == 0 && !h->requests && !h->open && h->uploads == 0 && !is_at_work();
}

static void check_end(void)
{
    const struct http *h = edge.http;
    const uint64_t begin_ms = uv_now(&edge.loop);
    while (!nothing_is_left()) {
        streams_end_all(edge.streams);
        (void)turn();
        must(uv_now(&edge.loop) - begin_ms < (uint64_t)patience_ms());
    }
    must(h->encodings == 0 && h->body_room_bytes == 0);
    must(folder_is_empty("tmp"));
}

static bool changes_something(void)
{
    static const enum route_id routes[] = {ROUTE_ASSET_PUT, ROUTE_ASSET_DELETE, ROUTE_JOB_SUBMIT,
                                           ROUTE_JOB_PATCH, ROUTE_JOB_DELETE,   ROUTE_WORKER_PATCH};
    for (size_t i = 0; i < sizeof routes / sizeof *routes; i++)
        for (unsigned status = 200; status < 300; status++)
            if (edge.http->count.ended[routes[i]][status - STATUS_FIRST]) return true;
    return false;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    static bool is_registered;
    if (!is_registered) is_registered = atexit(close_edge) == 0;
    if (!edge.is_up) open_edge();
    send_input(data, size_bytes);
    await_answers();
    for (int i = 0; i < client_count; i++) {
        struct client *c = &clients[i];
        must(answers_are_whole(c->text, c->text_bytes, c->asked_heads, c->reset));
        break_off(c);
    }
    for (int i = 0; i < client_count; i++) free(clients[i].text);
    client_count = 0;
    check_end();
    if (++edge.runs >= RUNS_MAX || changes_something()) close_edge();
    return 0;
}
