/* Many clients that follow one job, in one process that costs as little as can be: viewers of its
 * events, feeds of its pixels, and of each some that are stuck, which never read.
 *
 *   watchers port=N job=ID [viewers=N] [feeds=N] [stuck=N] [poke_ms=N]
 *
 * Prints "ready" when all have their answers' heads. Every poke_ms it gives the job another
 * priority and takes the time until each viewer is told. When the job's streams have ended all who
 * read it prints one JSON line of what came: delays in ms, and whether each feed has the whole
 * picture in its last state, which is compared with the feed of the ended job. Those that are stuck
 * stay until standard input ends. */
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "tests/load/watched.h"

#define CLIENTS_MAX  4096
#define EVENTS_MAX   65536
#define POKES_MAX    1024
#define BUFFER_BYTES (256u << 10)
#define LINE_BYTES   8192u
#define HASHED_EVERY 16 /* feeds whose pixels are compared */
#define TOO_LONG_MS  600000.0
#define STUCK_BYTES  4096 /* of a stuck reader's receive buffer */

enum kind { VIEWER, FEED, STUCK };
enum body { IN_HEAD, IN_SIZE, IN_DATA, IN_END, IN_NOTHING };

struct client {
    enum kind kind;
    int fd; /* -1: over */
    enum body body;
    uint64_t chunk_left;
    uint64_t bytes; /* of the body */
    bool begun;
    char line[LINE_BYTES]; /* of head, chunk size or event */
    size_t line_bytes;
    /* a viewer */
    uint64_t event;
    unsigned events;
    int poked; /* the last of which it was told */
    bool saw_end;
    struct watched_feed feed; /* of a feed */
};

static struct {
    int port, epoll;
    const char *job;
    struct client *client;
    int clients, begun, open;
    uint64_t first_id[EVENTS_MAX];
    double first_ms[EVENTS_MAX]; /* when an event came to anybody */
    double poke_ms[POKES_MAX];
    int pokes, poke_fd;
    struct delays spread, poked;
    char buffer[BUFFER_BYTES];
} all;

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* ---- viewers ---- */

static void on_id(struct client *c, const char *text)
{
    const char *dash = strchr(text, '-');
    if (!dash) return;
    c->event = strtoull(dash + 1, NULL, 10);
}

/* The first whom an event comes to has it as soon as it can be had; snapshots are of one alone. */
static void on_data(struct client *c, const char *text)
{
    const double now = now_ms();
    const size_t slot = c->event % EVENTS_MAX;
    const char *poke = strstr(text, "\"priority\":");
    c->events++;
    if (c->events == 1) return;
    if (all.first_id[slot] == c->event) {
        note_delay(&all.spread, now - all.first_ms[slot]);
    } else if (all.first_id[slot] < c->event) {
        all.first_id[slot] = c->event;
        all.first_ms[slot] = now;
    }
    if (strstr(text, "\"state\":\"finished\"")) c->saw_end = true;
    const long number = poke ? strtol(poke + strlen("\"priority\":"), NULL, 10) : 0;
    /* States tell the priority for as long as there is no other: the first one tells the news. */
    if (number > c->poked && number <= all.pokes && strstr(text, "\"paused\"")) {
        note_delay(&all.poked, now - all.poke_ms[number - 1]);
        c->poked = (int)number;
    }
}

static void on_line(struct client *c)
{
    c->line[c->line_bytes] = '\0';
    if (strncmp(c->line, "id: ", 4) == 0) on_id(c, c->line + 4);
    if (strncmp(c->line, "data: ", 6) == 0) on_data(c, c->line + 6);
    c->line_bytes = 0;
}

static void take_events(struct client *c, const char *data, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++) {
        if (data[i] == '\n')
            on_line(c);
        else if (c->line_bytes + 1 < LINE_BYTES)
            c->line[c->line_bytes++] = data[i];
    }
}

/* ---- HTTP ---- */

static void end_client(struct client *c)
{
    if (c->fd < 0) return;
    close(c->fd);
    c->fd = -1;
    c->body = IN_NOTHING;
    if (c->kind != STUCK) all.open--;
}

static void on_head(struct client *c)
{
    c->line[c->line_bytes] = '\0';
    if (strncmp(c->line, "HTTP/1.1 200", 12) != 0) {
        fprintf(stderr, "watchers: %.200s\n", c->line);
        exit(1);
    }
    c->begun = true;
    all.begun++;
    c->line_bytes = 0;
    c->body = strcasestr(c->line, "chunked") ? IN_SIZE : IN_DATA;
    c->chunk_left = c->body == IN_DATA ? UINT64_MAX : 0;
}

/* One letter of a head, or of the lines around a chunk. */
static void take_letter(struct client *c, char letter)
{
    if (c->body == IN_HEAD) {
        if (c->line_bytes + 1 < LINE_BYTES) c->line[c->line_bytes++] = letter;
        if (c->line_bytes >= 4 && memcmp(c->line + c->line_bytes - 4, "\r\n\r\n", 4) == 0)
            on_head(c);
        return;
    }
    if (c->body == IN_END) {
        if (letter == '\n') c->body = IN_SIZE;
    } else if (letter == '\n') {
        c->body = c->chunk_left > 0 ? IN_DATA : IN_NOTHING;
    } else if (letter != '\r') {
        const char digit[2] = {letter, 0};
        c->chunk_left = c->chunk_left << 4 | (unsigned)strtoul(digit, NULL, 16);
    }
}

static void take(struct client *c, const char *data, size_t bytes)
{
    while (bytes > 0 && c->body != IN_NOTHING) {
        size_t n = 1;
        if (c->body == IN_DATA) {
            n = bytes < c->chunk_left ? bytes : (size_t)c->chunk_left;
            c->chunk_left -= n;
            c->bytes += n;
            if (c->kind == VIEWER) take_events(c, data, n);
            if (c->kind == FEED) take_pixels(&c->feed, data, n);
            if (c->chunk_left == 0) c->body = IN_END;
        } else {
            take_letter(c, *data);
        }
        data += n;
        bytes -= n;
    }
    if (c->body == IN_NOTHING) end_client(c);
}

static int dial(int receive_bytes)
{
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons((uint16_t)all.port)};
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0) fail("socket");
    if (receive_bytes > 0)
        setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
    if (connect(fd, (struct sockaddr *)&to, sizeof to) != 0) fail("connect");
    return fd;
}

static void say(int fd, const char *text)
{
    if (send(fd, text, strlen(text), MSG_NOSIGNAL) != (ssize_t)strlen(text)) fail("send");
}

static void start_client(struct client *c, enum kind kind, bool feed)
{
    char text[256];
    c->kind = kind;
    c->fd = dial(kind == STUCK ? STUCK_BYTES : 0);
    if (kind == FEED) {
        c->feed.hash = must(calloc(BLOCKS_MAX, sizeof *c->feed.hash));
        c->feed.seen = must(calloc(BLOCKS_MAX, 1));
    }
    snprintf(text, sizeof text, "GET /v1/jobs/%s/%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n",
             all.job, feed ? "pixels" : "events", all.port);
    say(c->fd, text);
    if (kind == STUCK) return; /* it never reads: not even the answer's head */
    all.open++;
    if (fcntl(c->fd, F_SETFL, O_NONBLOCK) != 0) fail("fcntl");
    struct epoll_event e = {.events = EPOLLIN, .data.ptr = c};
    if (epoll_ctl(all.epoll, EPOLL_CTL_ADD, c->fd, &e) != 0) fail("epoll");
}

static void on_readable(struct client *c)
{
    const ssize_t n = recv(c->fd, all.buffer, sizeof all.buffer, 0);
    if (n > 0)
        take(c, all.buffer, (size_t)n);
    else if (n == 0 || (errno != EAGAIN && errno != EINTR))
        end_client(c);
}

static void look(int wait_ms)
{
    struct epoll_event events[512];
    const int n = epoll_wait(all.epoll, events, 512, wait_ms);
    for (int i = 0; i < n; i++) on_readable(events[i].data.ptr);
}

/* The job's priority tells nothing to a job that runs alone, but all who watch it. */
static void poke(void)
{
    char body[64], text[320];
    if (all.pokes >= POKES_MAX) return;
    ssize_t got;
    while ((got = recv(all.poke_fd, text, sizeof text, MSG_DONTWAIT)) > 0) {
    }
    if (got == 0) { /* the server ends connections that were idle for long */
        close(all.poke_fd);
        all.poke_fd = dial(0);
    }
    all.poke_ms[all.pokes++] = now_ms();
    const int bytes = snprintf(body, sizeof body, "{\"priority\": %d}", all.pokes);
    snprintf(
        text, sizeof text,
        "PATCH /v1/jobs/%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nContent-Type: application/json\r\n"
        "Content-Length: %d\r\n\r\n%s",
        all.job, all.port, bytes, body);
    say(all.poke_fd, text);
}

/* ---- what came ---- */

/* The picture as who comes after the end is given it. */
static struct client *last_picture(void)
{
    struct client *c = &all.client[all.clients];
    start_client(c, FEED, true);
    c->feed.hashed = true;
    for (const double end = now_ms() + 20000; c->fd >= 0 && now_ms() < end;) look(100);
    return c;
}

static void report(void)
{
    uint64_t bytes = 0;
    unsigned viewers = 0, ended = 0, feeds = 0, whole = 0, same = 0, hashed = 0, least = UINT32_MAX;
    uint64_t blocks = 0;
    const struct client *last = last_picture();
    for (int i = 0; i < all.clients; i++) {
        const struct client *c = &all.client[i];
        if (c->kind == VIEWER) {
            viewers++;
            ended += c->saw_end;
            least = c->events < least ? c->events : least;
        } else if (c->kind == FEED) {
            feeds++;
            bytes += c->bytes;
            blocks += c->feed.blocks;
            whole += c->feed.whole && c->feed.distinct == blocks_of(&c->feed);
            hashed += c->feed.hashed;
            same += c->feed.hashed && c->feed.distinct == last->feed.distinct &&
                    memcmp(c->feed.hash, last->feed.hash, BLOCKS_MAX * sizeof *c->feed.hash) == 0;
        }
    }
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    printf("{\"viewers\": %u, \"told_of_the_end\": %u, \"events_min\": %u, ", viewers, ended,
           viewers ? least : 0);
    printf("\"spread_p50_ms\": %.1f, \"spread_p99_ms\": %.1f, \"spread_max_ms\": %.1f, ",
           quantile(&all.spread, 0.5), quantile(&all.spread, 0.99), quantile(&all.spread, 1));
    printf("\"pokes\": %d, \"poked\": %zu, \"poke_p50_ms\": %.1f, \"poke_p99_ms\": %.1f, ",
           all.pokes, all.poked.count, quantile(&all.poked, 0.5), quantile(&all.poked, 0.99));
    printf("\"feeds\": %u, \"feeds_whole\": %u, \"compared\": %u, \"same\": %u, ", feeds, whole,
           hashed, same);
    printf("\"pictures\": %.2f, \"feed_mb\": %.1f, \"cpu_s\": %.2f}\n",
           feeds ? (double)blocks / feeds / (last->feed.distinct ? last->feed.distinct : 1) : 0,
           1e-6 * (double)bytes,
           (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
               1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec));
}

static int number_of(int argc, char **argv, const char *name, int usual)
{
    const size_t bytes = strlen(name);
    for (int i = 1; i < argc; i++)
        if (strncmp(argv[i], name, bytes) == 0 && argv[i][bytes] == '=')
            return atoi(argv[i] + bytes + 1);
    return usual;
}

static void start_all(int viewers, int feeds, int stuck)
{
    const int count = viewers + feeds + 2 * stuck;
    if (count >= CLIENTS_MAX) fail("too many clients");
    all.client = must(calloc((size_t)count + 1, sizeof *all.client));
    for (int i = 0; i < count; i++) {
        struct client *c = &all.client[all.clients++];
        if (i < 2 * stuck)
            start_client(c, STUCK, i % 2 == 0);
        else if (i < 2 * stuck + viewers)
            start_client(c, VIEWER, false);
        else
            start_client(c, FEED, true);
        c->feed.hashed = c->kind == FEED && (count - i) % HASHED_EVERY == 1;
        if (i % 64 == 63) look(0);
    }
    while (all.begun < viewers + feeds) look(100);
}

int main(int argc, char **argv)
{
    const int poke_every_ms = number_of(argc, argv, "poke_ms", 0);
    for (int i = 1; i < argc; i++)
        if (strncmp(argv[i], "job=", 4) == 0) all.job = argv[i] + 4;
    all.port = number_of(argc, argv, "port", 0);
    all.epoll = epoll_create1(EPOLL_CLOEXEC);
    if (!all.job || all.port == 0) {
        fprintf(stderr,
                "usage: watchers port=N job=ID [viewers=N] [feeds=N] [stuck=N] [poke_ms=N]\n");
        return 2;
    }
    start_all(number_of(argc, argv, "viewers", 0), number_of(argc, argv, "feeds", 0),
              number_of(argc, argv, "stuck", 0));
    all.poke_fd = dial(0);
    printf("ready\n");
    fflush(stdout);
    const double end = now_ms() + TOO_LONG_MS;
    for (double next = now_ms() + poke_every_ms; all.open > 0 && now_ms() < end;) {
        look(100);
        if (poke_every_ms > 0 && now_ms() >= next) {
            poke();
            next += poke_every_ms;
        }
    }
    report();
    fflush(stdout);
    while (read(STDIN_FILENO, all.buffer, sizeof all.buffer) > 0) {
    }
    return 0;
}
