/* A worker that misbehaves by script, for tests of the coordinator; or one that answers at once,
 * for load tests. Speaks the protocol over a blocking socket and prints what it sees as JSON lines.
 *
 *   fake_worker --connect unix:PATH|HOST:PORT --script NAME
 *               [--threads N] [--seconds S] [--tiles N] [--reconnects N] [--embree VERSION]
 *               [--name NAME]
 *
 * It ends when the link is closed (after N reconnects), after S seconds or N answers. Exit status:
 * 0, 1 when no link could be made, 2 for wrong use, 3 when it was refused. */
#include <errno.h>
#include <math.h>
#include <netdb.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "proto/build.h"
#include "proto/frame.h"
#include "proto/message.h"
#include "proto/samples.h"

#define HELLO_DELAY_MS 8000u
#define MAX_FRAMES     64u
#define END_MS         50 /* after damage, until the link is ended from here */
#define CAPABILITIES                                                                               \
    (CAPABILITY_DIRECT | CAPABILITY_INDIRECT | CAPABILITY_VISIBILITY | CAPABILITY_STRATA |         \
     CAPABILITY_PATHS | CAPABILITY_ENVIRONMENT | CAPABILITY_LENS | CAPABILITY_SIDES)

struct fake;

struct script {
    const char *name;
    const char *text;
    void (*tile)(struct fake *f, uint64_t request_id, const struct message_tile *tile);
    bool no_beats;
};

struct known_frame {
    uint64_t id;
    struct plan plan;
};

struct fake {
    const struct script *script;
    const char *address, *embree, *name;
    uint32_t threads;
    double seconds;
    uint64_t tiles_most, reconnects;
    int fd;
    bool refused;
    struct frame_inbox inbox;
    struct known_frame *frames; /* the last MAX_FRAMES */
    uint64_t frame_count;
    struct bytes_writer packed; /* the last zero samples, of these: */
    uint64_t packed_frame;
    uint32_t packed_pass;
    int32_t packed_width, packed_height;
    uint64_t tiles, answers, acks[VERDICT_CORRUPT + 1];
    uint64_t started_ms, beat_ms, next_beat_ms, next_request;
};

static uint64_t now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000u + (uint64_t)t.tv_nsec / 1000000u;
}

/* ---- sending ---- */

static void lose(struct fake *f)
{
    if (f->fd >= 0) close(f->fd);
    f->fd = -1;
}

static void send_raw(struct fake *f, const void *data, size_t size_bytes)
{
    const uint8_t *at = data;
    while (size_bytes > 0 && f->fd >= 0) {
        ssize_t n = send(f->fd, at, size_bytes, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            lose(f);
            return;
        }
        at += n;
        size_bytes -= (size_t)n;
    }
}

static void send_message(struct fake *f, uint16_t type, uint64_t request_id,
                         struct bytes_writer *head, const void *tail, size_t tail_bytes)
{
    uint8_t header[FRAME_HEADER_BYTES];
    frame_header(header, type, request_id, head->data, (uint32_t)head->size_bytes, tail,
                 (uint32_t)tail_bytes);
    send_raw(f, header, sizeof header);
    send_raw(f, head->data, head->size_bytes);
    send_raw(f, tail, tail_bytes);
    bytes_writer_fini(head);
}

static void send_want(struct fake *f, uint32_t tiles)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    message_encode_want(&w, &(struct message_want){.tiles = tiles});
    send_message(f, MESSAGE_WANT, f->next_request++, &w, NULL, 0);
}

static void send_beat(struct fake *f)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    message_encode_beat(&w, &(struct message_beat){.progress = f->answers, .phase = BEAT_TRACING});
    send_message(f, MESSAGE_BEAT, f->next_request++, &w, NULL, 0);
}

/* ---- results ---- */

static const struct plan *plan_of(const struct fake *f, uint64_t frame_id)
{
    for (uint64_t i = 0; i < MAX_FRAMES && i < f->frame_count; i++)
        if (f->frames[i].id == frame_id) return &f->frames[i].plan;
    return NULL;
}

static void put_nan(struct samples *s)
{
    const uint16_t half_nan = 0x7e00;
    if (s->layout.planes & PLANE_BIT(DEPTH))
        samples_f32(s, PLANE_DEPTH, 0)[0] = NAN;
    else if (s->layout.planes & PLANES_PATH)
        samples_f32(s, (enum plane_id)__builtin_ctz(s->layout.planes & PLANES_PATH), 0)[0] = NAN;
    else if (s->layout.planes & PLANE_BIT(EMISSION))
        samples_u16(s, PLANE_EMISSION, 0)[0] = half_nan;
    else if (s->layout.planes & PLANE_BIT(INDIRECT_MEAN))
        samples_u16(s, PLANE_INDIRECT_MEAN, 0)[0] = half_nan;
    else
        samples_light_irradiance(s, 0)[0] = NAN;
}

/* Samples that hold nothing, validly packed (or with one NaN). */
/* Lone sub-samples whose places do not ascend, or whose light is not finite, by turns. */
static void put_lone(struct samples *s, uint64_t turn)
{
    if (s->layout.lone_parts == 0 || lone_create(s->layout.lone_parts, 2, &s->lone) != 0) return;
    s->lone->words[1] = turn % 2;
    for (uint32_t part = 0; part < LONE_PART_COUNT; part++)
        if (turn % 2 && lone_values(s->lone, part, 0)) lone_values(s->lone, part, 0)[1] = INFINITY;
}

enum lie { LIE_NONE, LIE_NAN, LIE_LONE };

static void pack(struct fake *f, const struct message_tile *tile, int32_t width, int32_t height,
                 enum lie lie, struct bytes_writer *out)
{
    struct samples_layout layout;
    struct samples *s = NULL;
    uint64_t dropped = 0;
    const struct plan *plan = plan_of(f, tile->frame_id);
    bytes_writer_init(out);
    if (!plan || samples_layout_init(&layout, plan, tile->pass.number, width, height) != 0 ||
        samples_create(&layout, &s) != 0)
        return;
    if (lie == LIE_NAN) put_nan(s);
    if (lie == LIE_LONE) put_lone(s, f->answers);
    samples_pack(s, out, &dropped);
    samples_destroy(&s);
}

static void send_result(struct fake *f, uint64_t request_id, const struct message_tile *tile,
                        const struct bytes_writer *packed)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    const struct message_result m = {.frame_id = tile->frame_id,
                                     .index = tile->index,
                                     .generation = tile->generation,
                                     .samples_bytes = (uint32_t)packed->size_bytes};
    message_encode_result(&w, &m);
    f->answers++;
    send_message(f, MESSAGE_RESULT, request_id, &w, packed->data, packed->size_bytes);
}

/* Packed once for a frame and size: an echo must be cheaper than what it measures. */
static const struct bytes_writer *zero_samples(struct fake *f, const struct message_tile *tile)
{
    int32_t width = rect_width(tile->rect), height = rect_height(tile->rect);
    if (f->packed.data && f->packed_frame == tile->frame_id &&
        f->packed_pass == tile->pass.number && f->packed_width == width &&
        f->packed_height == height)
        return &f->packed;
    bytes_writer_fini(&f->packed);
    pack(f, tile, width, height, false, &f->packed);
    f->packed_frame = tile->frame_id;
    f->packed_pass = tile->pass.number;
    f->packed_width = width;
    f->packed_height = height;
    return &f->packed;
}

static void tile_echo(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    send_result(f, request_id, tile, zero_samples(f, tile));
    send_want(f, 1);
}

static void tile_ignored(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    (void)f;
    (void)request_id;
    (void)tile;
}

/* The frame of a right result, byte by byte. */
static void whole_result(struct fake *f, uint64_t request_id, const struct message_tile *tile,
                         struct bytes_writer *whole)
{
    const struct bytes_writer *packed = zero_samples(f, tile);
    struct bytes_writer head;
    uint8_t header[FRAME_HEADER_BYTES];
    bytes_writer_init(&head);
    bytes_writer_init(whole);
    const struct message_result m = {.frame_id = tile->frame_id,
                                     .index = tile->index,
                                     .generation = tile->generation,
                                     .samples_bytes = (uint32_t)packed->size_bytes};
    message_encode_result(&head, &m);
    frame_header(header, MESSAGE_RESULT, request_id, head.data, (uint32_t)head.size_bytes,
                 packed->data, (uint32_t)packed->size_bytes);
    bytes_write_raw(whole, header, sizeof header);
    bytes_write_raw(whole, head.data, head.size_bytes);
    bytes_write_raw(whole, packed->data, packed->size_bytes);
    bytes_writer_fini(&head);
}

static void send_whole(struct fake *f, struct bytes_writer *whole)
{
    f->answers++;
    send_raw(f, whole->data, whole->size_bytes);
    bytes_writer_fini(whole);
}

static void flip(struct bytes_writer *whole, size_t bit)
{
    whole->data[bit / 8] ^= (uint8_t)(1u << (bit % 8));
}

/* The whole frame is right but for one bit, after the checksum was made. */
static void tile_flip(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct bytes_writer whole;
    whole_result(f, request_id, tile, &whole);
    size_t payload_bytes = whole.size_bytes - FRAME_HEADER_BYTES;
    flip(&whole, 8 * FRAME_HEADER_BYTES + (f->answers * 2654435761u) % (8 * payload_bytes));
    send_whole(f, &whole);
}

/* The coordinator may wait for what a damaged length promised: the link ends. */
static void end_soon(struct fake *f)
{
    struct pollfd p = {.fd = f->fd, .events = POLLIN};
    uint8_t ignored[4096];
    while (f->fd >= 0 && poll(&p, 1, END_MS) > 0)
        if (recv(f->fd, ignored, sizeof ignored, 0) <= 0) break;
    if (f->fd >= 0) lose(f);
}

/* One bit of the header after the other, a link each. */
static void tile_header(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct bytes_writer whole;
    whole_result(f, request_id, tile, &whole);
    flip(&whole, f->answers % (8 * FRAME_HEADER_BYTES));
    send_whole(f, &whole);
    end_soon(f);
}

/* splitmix64, of the number of the answer. */
static uint64_t random_of(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* One to eight bytes of the body are others than the checksum says, a link each. */
static void tile_mutate(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct bytes_writer whole;
    whole_result(f, request_id, tile, &whole);
    const uint64_t seed = random_of(f->answers);
    const size_t body_bytes = whole.size_bytes - FRAME_HEADER_BYTES;
    uint8_t *body = whole.data + FRAME_HEADER_BYTES;
    const uint32_t right = frame_crc32c(0, body, body_bytes);
    for (uint64_t i = 0; i < 1 + seed % 8; i++) {
        const uint64_t r = random_of(seed + i);
        body[(r >> 8) % body_bytes] ^= (uint8_t)(1 + r % 255);
    }
    /* A few in a million change a byte twice, back to what it was. */
    if (frame_crc32c(0, body, body_bytes) == right) body[0] ^= 1;
    send_whole(f, &whole);
    end_soon(f);
}

static void tile_die(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    (void)request_id;
    (void)tile;
    lose(f);
}

static void answer_once(struct fake *f, uint64_t request_id, const struct message_tile *tile,
                        int32_t width, int32_t height, enum lie lie)
{
    struct bytes_writer packed;
    pack(f, tile, width, height, lie, &packed);
    send_result(f, request_id, tile, &packed);
    bytes_writer_fini(&packed);
    send_want(f, 1);
}

static void tile_lie(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    answer_once(f, request_id, tile, rect_width(tile->rect) + 1, rect_height(tile->rect), LIE_NONE);
}

static void tile_nan(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    answer_once(f, request_id, tile, rect_width(tile->rect), rect_height(tile->rect), LIE_NAN);
}

static void tile_lone(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    answer_once(f, request_id, tile, rect_width(tile->rect), rect_height(tile->rect), LIE_LONE);
}

static void tile_stale(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct message_tile old = *tile;
    old.generation = tile->generation ? tile->generation - 1 : 1;
    send_result(f, request_id, &old, zero_samples(f, tile));
}

static void tile_foreign(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct message_tile other = *tile;
    other.index = tile->index ^ 0x10000u; /* no image of a test has so many tiles */
    send_result(f, request_id, &other, zero_samples(f, tile));
}

static void tile_garbage(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    (void)request_id;
    uint64_t x = 0x9e3779b97f4a7c15u + tile->index;
    uint64_t noise[512];
    for (size_t i = 0; i < sizeof noise / sizeof noise[0]; i++) {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        noise[i] = x;
    }
    send_raw(f, noise, sizeof noise);
}

static void tile_half(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    const struct bytes_writer *packed = zero_samples(f, tile);
    struct bytes_writer head;
    uint8_t header[FRAME_HEADER_BYTES];
    bytes_writer_init(&head);
    const struct message_result m = {.frame_id = tile->frame_id,
                                     .index = tile->index,
                                     .generation = tile->generation,
                                     .samples_bytes = (uint32_t)packed->size_bytes};
    message_encode_result(&head, &m);
    frame_header(header, MESSAGE_RESULT, request_id, head.data, (uint32_t)head.size_bytes,
                 packed->data, (uint32_t)packed->size_bytes);
    send_raw(f, header, sizeof header);
    send_raw(f, head.data, head.size_bytes / 2);
    bytes_writer_fini(&head);
    lose(f);
}

static const struct script scripts[] = {
    {"echo", "answers at once with empty samples", tile_echo, false},
    {"hang", "takes tiles, beats without progress", tile_ignored, false},
    {"silent", "takes tiles, says nothing", tile_ignored, true},
    {"garbage", "random bytes in place of a result", tile_garbage, false},
    {"flip", "a right result with one bit flipped on the wire", tile_flip, false},
    {"header", "right results, each with another bit of its header flipped", tile_header, false},
    {"mutate", "right results with one to eight bytes of their body changed", tile_mutate, false},
    {"die", "takes a tile and is gone", tile_die, false},
    {"lie", "samples of another tile size", tile_lie, false},
    {"nan", "samples that are not finite", tile_nan, false},
    {"lone", "lists of lone sub-samples out of order, or with light that is not finite", tile_lone,
     false},
    {"stale", "a result of an older generation", tile_stale, false},
    {"foreign", "a result for a tile that nobody leased", tile_foreign, false},
    {"wrong-build", "another build id", tile_ignored, false},
    {"wrong-protocol", "another protocol version", tile_ignored, false},
    {"wrong-isa", "another instruction set", tile_ignored, false},
    {"slow-hello", "says HELLO after 8 s", tile_ignored, false},
    {"disconnect-mid-result", "half a result, then gone", tile_half, false},
};

static bool plays(const struct fake *f, const char *script)
{
    return strcmp(f->script->name, script) == 0;
}

/* ---- what comes in ---- */

static void send_hello(struct fake *f)
{
    struct bytes_writer w;
    struct message_hello m = {.protocol_version = PROTOCOL_VERSION,
                              .capabilities = CAPABILITIES,
                              .threads = f->threads,
                              .pid = (uint64_t)getpid()};
    if (plays(f, "slow-hello")) poll(NULL, 0, HELLO_DELAY_MS);
    if (plays(f, "wrong-protocol")) m.protocol_version = PROTOCOL_VERSION + 1000;
    snprintf(m.build_id, sizeof m.build_id, "%s",
             plays(f, "wrong-build") ? "0.0.0+fake" : build_id());
    const char *isa = build_isa() ? build_isa() : "none";
    if (plays(f, "wrong-isa")) isa = strcmp(isa, "sse4.2") == 0 ? "avx2" : "sse4.2";
    snprintf(m.isa, sizeof m.isa, "%s", isa);
    snprintf(m.embree_version, sizeof m.embree_version, "%s", f->embree);
    if (f->name)
        snprintf(m.name, sizeof m.name, "%s", f->name);
    else if (f->script->tile == tile_header || f->script->tile == tile_mutate)
        snprintf(m.name, sizeof m.name, "fake-%s-%llu", f->script->name, /* no quarantine */
                 (unsigned long long)f->answers);
    else
        snprintf(m.name, sizeof m.name, "fake-%s", f->script->name);
    bytes_writer_init(&w);
    message_encode_hello(&w, &m);
    send_message(f, MESSAGE_HELLO, f->next_request++, &w, NULL, 0);
}

static void print_text(const char *text)
{
    for (; *text; text++) {
        if (*text == '"' || *text == '\\') putchar('\\');
        putchar(*text);
    }
}

static void saw_welcome(struct fake *f, const struct frame_view *v)
{
    struct message_welcome m;
    if (message_decode_welcome(v->payload, v->payload_bytes, &m) != 0) return;
    printf("{\"saw\": \"WELCOME\", \"worker_id\": %llu, \"beat_ms\": %u}\n",
           (unsigned long long)m.worker_id, m.beat_ms);
    f->beat_ms = m.beat_ms;
    f->next_beat_ms = now_ms();
    uint32_t tiles = 2 * f->threads;
    send_want(f, tiles < LIMIT_TILES_IN_HAND ? tiles : LIMIT_TILES_IN_HAND);
}

static void saw_refused(struct fake *f, const struct frame_view *v)
{
    struct message_refused m;
    if (message_decode_refused(v->payload, v->payload_bytes, &m) != 0) return;
    printf("{\"saw\": \"REFUSED\", \"code\": \"%s\", \"text\": \"", error_name(m.code));
    print_text(m.text);
    printf("\"}\n");
    f->refused = true;
    lose(f);
}

static void saw_frame(struct fake *f, const struct frame_view *v)
{
    struct message_frame_plan m;
    struct fault fault = {0};
    if (message_decode_frame_plan(v->payload, v->payload_bytes, &m) != 0) return;
    struct known_frame *k = &f->frames[f->frame_count % MAX_FRAMES];
    if (plan_decode(m.plan, m.plan_bytes, &k->plan, &fault) != 0) return;
    k->id = m.frame_id;
    f->frame_count++;
    printf("{\"saw\": \"FRAME\", \"frame_id\": %llu, \"width\": %d, \"height\": %d}\n",
           (unsigned long long)m.frame_id, k->plan.width_px, k->plan.height_px);
}

static void saw_tile(struct fake *f, const struct frame_view *v)
{
    struct message_tile m;
    if (message_decode_tile(v->payload, v->payload_bytes, &m) != 0) return;
    f->tiles++;
    if (f->tiles == 1)
        printf("{\"saw\": \"TILE\", \"index\": %u, \"generation\": %u}\n", m.index, m.generation);
    f->script->tile(f, v->request_id, &m);
}

static void saw_ack(struct fake *f, const struct frame_view *v)
{
    struct message_ack m;
    if (message_decode_ack(v->payload, v->payload_bytes, &m) != 0) return;
    if (m.verdict > VERDICT_CORRUPT) return;
    if (f->acks[m.verdict]++ == 0) printf("{\"saw\": \"ACK\", \"verdict\": %u}\n", m.verdict);
}

static void saw(struct fake *f, const struct frame_view *v)
{
    switch (v->type) {
    case MESSAGE_WELCOME:
        saw_welcome(f, v);
        break;
    case MESSAGE_REFUSED:
        saw_refused(f, v);
        break;
    case MESSAGE_FRAME:
        saw_frame(f, v);
        break;
    case MESSAGE_TILE:
        saw_tile(f, v);
        break;
    case MESSAGE_ACK:
        saw_ack(f, v);
        break;
    default:
        printf("{\"saw\": \"%s\"}\n", message_name(v->type) ? message_name(v->type) : "?");
    }
}

/* ---- the link ---- */

static int dial_unix(const char *path)
{
    struct sockaddr_un a = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof a.sun_path) return -1;
    memcpy(a.sun_path, path, strlen(path) + 1);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&a, sizeof a) == 0) return fd;
    if (fd >= 0) close(fd);
    return -1;
}

static int dial_tcp(const char *address)
{
    char host[256];
    const char *colon = strrchr(address, ':');
    const struct addrinfo hints = {.ai_socktype = SOCK_STREAM};
    struct addrinfo *found = NULL;
    if (!colon || (size_t)(colon - address) >= sizeof host) return -1;
    memcpy(host, address, (size_t)(colon - address));
    host[colon - address] = '\0';
    if (getaddrinfo(host, colon + 1, &hints, &found) != 0) return -1;
    int fd = socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, found->ai_addr, found->ai_addrlen) != 0) {
        close(fd);
        fd = -1;
    }
    freeaddrinfo(found);
    return fd;
}

static bool is_over(const struct fake *f)
{
    return f->refused || (f->tiles_most > 0 && f->answers >= f->tiles_most) ||
           (double)(now_ms() - f->started_ms) >= 1000.0 * f->seconds;
}

static int time_left_ms(const struct fake *f)
{
    uint64_t now = now_ms(), end = f->started_ms + (uint64_t)(1000.0 * f->seconds);
    if (f->beat_ms && !f->script->no_beats && f->next_beat_ms < end) end = f->next_beat_ms;
    return end > now ? (int)(end - now < 1000 ? end - now : 1000) : 0;
}

static void read_some(struct fake *f)
{
    size_t space_bytes = 0;
    uint8_t *space = frame_inbox_space(&f->inbox, &space_bytes);
    ssize_t n = space ? recv(f->fd, space, space_bytes, 0) : -1;
    if (n <= 0) {
        lose(f);
        return;
    }
    frame_inbox_filled(&f->inbox, (size_t)n);
    struct frame_view v;
    while (f->fd >= 0 && !is_over(f) && frame_inbox_next(&f->inbox, &v) == 0) saw(f, &v);
}

static void talk(struct fake *f)
{
    frame_inbox_init(&f->inbox, LIMIT_FRAME_BYTES);
    f->beat_ms = 0;
    send_hello(f);
    while (f->fd >= 0 && !is_over(f)) {
        struct pollfd p = {.fd = f->fd, .events = POLLIN};
        if (poll(&p, 1, time_left_ms(f)) > 0) read_some(f);
        if (f->fd < 0 || !f->beat_ms || f->script->no_beats || now_ms() < f->next_beat_ms) continue;
        send_beat(f);
        f->next_beat_ms = now_ms() + f->beat_ms;
    }
    frame_inbox_fini(&f->inbox);
}

static void print_sum(const struct fake *f)
{
    double seconds = (double)(now_ms() - f->started_ms) / 1000.0;
    printf("{\"script\": \"%s\", \"closed\": %s, \"seconds\": %.3f, \"tiles\": %llu, "
           "\"answers\": %llu, \"tiles_per_s\": %.1f, \"accepted\": %llu, \"duplicate\": %llu, "
           "\"stale\": %llu, \"foreign\": %llu, \"corrupt\": %llu}\n",
           f->script->name, f->fd < 0 ? "true" : "false", seconds, (unsigned long long)f->tiles,
           (unsigned long long)f->answers, seconds > 0 ? (double)f->answers / seconds : 0.0,
           (unsigned long long)f->acks[VERDICT_ACCEPTED],
           (unsigned long long)f->acks[VERDICT_DUPLICATE],
           (unsigned long long)f->acks[VERDICT_STALE], (unsigned long long)f->acks[VERDICT_FOREIGN],
           (unsigned long long)f->acks[VERDICT_CORRUPT]);
}

/* Waits for a coordinator that is still starting. */
static bool dial(struct fake *f)
{
    for (int attempt = 0; attempt < 50 && f->fd < 0 && !is_over(f); attempt++) {
        if (attempt > 0) poll(NULL, 0, 100);
        f->fd =
            strncmp(f->address, "unix:", 5) == 0 ? dial_unix(f->address + 5) : dial_tcp(f->address);
    }
    return f->fd >= 0;
}

static int play(struct fake *f)
{
    bool linked = false;
    f->started_ms = now_ms();
    for (uint64_t links = 0; links <= f->reconnects && !is_over(f) && dial(f); links++) {
        linked = true;
        talk(f);
        if (links < f->reconnects && !is_over(f)) lose(f);
    }
    print_sum(f);
    lose(f);
    return f->refused ? 3 : linked ? 0 : 1;
}

static int usage(void)
{
    fputs("usage: fake_worker --connect ADDRESS --script NAME [--threads N] [--seconds S]\n"
          "                   [--tiles N] [--reconnects N] [--embree VERSION] [--name NAME]\n",
          stderr);
    for (size_t i = 0; i < sizeof scripts / sizeof scripts[0]; i++)
        fprintf(stderr, "  %-22s %s\n", scripts[i].name, scripts[i].text);
    return 2;
}

static bool take_option(struct fake *f, const char *name, const char *value)
{
    if (strcmp(name, "--connect") == 0)
        f->address = value;
    else if (strcmp(name, "--embree") == 0)
        f->embree = value;
    else if (strcmp(name, "--name") == 0)
        f->name = value;
    else if (strcmp(name, "--threads") == 0)
        f->threads = (uint32_t)strtoul(value, NULL, 10);
    else if (strcmp(name, "--seconds") == 0)
        f->seconds = strtod(value, NULL);
    else if (strcmp(name, "--tiles") == 0)
        f->tiles_most = strtoull(value, NULL, 10);
    else if (strcmp(name, "--reconnects") == 0)
        f->reconnects = strtoull(value, NULL, 10);
    else if (strcmp(name, "--script") == 0)
        for (size_t i = 0; i < sizeof scripts / sizeof scripts[0]; i++)
            f->script = strcmp(scripts[i].name, value) == 0 ? &scripts[i] : f->script;
    else
        return false;
    return true;
}

int main(int argc, char **argv)
{
    static struct known_frame frames[MAX_FRAMES];
    struct fake f = {.fd = -1, .threads = 1, .seconds = 60, .embree = "3.13.5", .frames = frames};
    for (int i = 1; i < argc; i += 2)
        if (i + 1 >= argc || !take_option(&f, argv[i], argv[i + 1])) return usage();
    if (!f.address || !f.script || f.threads == 0 || f.threads > LIMIT_THREADS) return usage();
    setvbuf(stdout, NULL, _IOLBF, 0);
    bytes_writer_init(&f.packed);
    int status = play(&f);
    bytes_writer_fini(&f.packed);
    return status;
}
