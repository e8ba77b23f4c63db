#include "tests/fake/worker/talk.h"

#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "proto/runtime/build.h"
#include "tests/fake/worker/link.h"
#include "tests/fake/worker/script.h"

#define HELLO_DELAY_MS 8000u
#define CAPABILITIES                                                                               \
    (CAPABILITY_DIRECT | CAPABILITY_INDIRECT | CAPABILITY_VISIBILITY | CAPABILITY_STRATA |         \
     CAPABILITY_PATHS | CAPABILITY_ENVIRONMENT | CAPABILITY_LENS | CAPABILITY_STRATA_MAPS |        \
     CAPABILITY_VIEWS | CAPABILITY_SHUTTER)

static void send_hello(struct fake *f)
{
    struct bytes_writer w;
    struct message_hello m = {.protocol_version = PROTOCOL_VERSION,
                              .capabilities = CAPABILITIES,
                              .threads = f->threads,
                              .pid = (uint64_t)getpid()};
    if (script_plays(f, "slow-hello")) poll(NULL, 0, HELLO_DELAY_MS);
    if (script_plays(f, "wrong-protocol")) m.protocol_version = PROTOCOL_VERSION + 1000;
    snprintf(m.build_id, sizeof m.build_id, "%s",
             script_plays(f, "wrong-build") ? "0.0.0+fake" : build_id());
    const char *isa = build_isa() ? build_isa() : "none";
    if (script_plays(f, "wrong-isa")) isa = strcmp(isa, "sse4.2") == 0 ? "avx2" : "sse4.2";
    snprintf(m.isa, sizeof m.isa, "%s", isa);
    snprintf(m.embree_version, sizeof m.embree_version, "%s", f->embree);
    if (f->name)
        snprintf(m.name, sizeof m.name, "%s", f->name);
    else if (script_plays(f, "header") || script_plays(f, "mutate"))
        snprintf(m.name, sizeof m.name, "fake-%s-%llu", f->script->name, /* no quarantine */
                 (unsigned long long)f->answers);
    else
        snprintf(m.name, sizeof m.name, "fake-%s", f->script->name);
    bytes_writer_init(&w);
    message_encode_hello(&w, &m);
    link_send_message(f, MESSAGE_HELLO, f->next_request++, &w, NULL, 0);
}

static void print_text(const char *text)
{
    for (; *text; text++) {
        if (*text == '"' || *text == '\\') putchar('\\');
        putchar(*text);
    }
}

static void saw_welcome(struct fake *f, const struct wire_frame_view *v)
{
    struct message_welcome m;
    if (message_decode_welcome(v->payload, v->payload_bytes, &m) != 0) return;
    printf("{\"saw\": \"WELCOME\", \"worker_id\": %llu, \"beat_ms\": %u}\n",
           (unsigned long long)m.worker_id, m.beat_ms);
    f->beat_ms = m.beat_ms;
    f->next_beat_ms = fake_now_ms();
    uint32_t tiles = 2 * f->threads;
    link_send_want(f, tiles < LIMIT_TILES_IN_HAND ? tiles : LIMIT_TILES_IN_HAND);
}

static void saw_refused(struct fake *f, const struct wire_frame_view *v)
{
    struct message_refused m;
    if (message_decode_refused(v->payload, v->payload_bytes, &m) != 0) return;
    printf("{\"saw\": \"REFUSED\", \"code\": \"%s\", \"text\": \"", error_name(m.code));
    print_text(m.text);
    printf("\"}\n");
    f->refused = true;
    link_lose(f);
}

static void saw_frame(struct fake *f, const struct wire_frame_view *v)
{
    struct message_frame_plan m;
    struct fault fault = {0};
    if (message_decode_frame_plan(v->payload, v->payload_bytes, &m) != 0) return;
    struct known_frame *k = &f->frames[f->frame_count % FAKE_FRAMES];
    if (plan_decode(m.plan, m.plan_bytes, &k->plan, &fault) != 0) return;
    k->id = m.frame_id;
    f->frame_count++;
    printf("{\"saw\": \"FRAME\", \"frame_id\": %llu, \"width\": %d, \"height\": %d}\n",
           (unsigned long long)m.frame_id, k->plan.width_px, k->plan.height_px);
}

static void saw_tile(struct fake *f, const struct wire_frame_view *v)
{
    struct message_tile m;
    if (message_decode_tile(v->payload, v->payload_bytes, &m) != 0) return;
    f->tiles++;
    if (f->tiles == 1)
        printf("{\"saw\": \"TILE\", \"index\": %u, \"generation\": %u}\n", m.index, m.generation);
    f->script->tile(f, v->request_id, &m);
}

static void saw_ack(struct fake *f, const struct wire_frame_view *v)
{
    struct message_ack m;
    if (message_decode_ack(v->payload, v->payload_bytes, &m) != 0) return;
    if (m.verdict > VERDICT_CORRUPT) return;
    if (f->acks[m.verdict]++ == 0) printf("{\"saw\": \"ACK\", \"verdict\": %u}\n", m.verdict);
}

static void saw(struct fake *f, const struct wire_frame_view *v)
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

static void send_beat(struct fake *f)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    message_encode_beat(&w, &(struct message_beat){.progress = f->answers, .phase = BEAT_TRACING});
    link_send_message(f, MESSAGE_BEAT, f->next_request++, &w, NULL, 0);
}

static int time_left_ms(const struct fake *f)
{
    uint64_t now = fake_now_ms(), end = f->started_ms + (uint64_t)(1000.0 * f->seconds);
    if (f->beat_ms && !f->script->no_beats && f->next_beat_ms < end) end = f->next_beat_ms;
    return end > now ? (int)(end - now < 1000 ? end - now : 1000) : 0;
}

static void read_some(struct fake *f)
{
    size_t space_bytes = 0;
    uint8_t *space = wire_frame_inbox_space(&f->inbox, &space_bytes);
    ssize_t n = space ? recv(f->fd, space, space_bytes, 0) : -1;
    if (n <= 0) {
        link_lose(f);
        return;
    }
    wire_frame_inbox_filled(&f->inbox, (size_t)n);
    struct wire_frame_view v;
    while (f->fd >= 0 && !fake_is_over(f) && wire_frame_inbox_next(&f->inbox, &v) == 0) saw(f, &v);
}

void talk(struct fake *f)
{
    wire_frame_inbox_init(&f->inbox, LIMIT_FRAME_BYTES);
    f->beat_ms = 0;
    send_hello(f);
    while (f->fd >= 0 && !fake_is_over(f)) {
        struct pollfd p = {.fd = f->fd, .events = POLLIN};
        if (poll(&p, 1, time_left_ms(f)) > 0) read_some(f);
        if (f->fd < 0 || !f->beat_ms || f->script->no_beats || fake_now_ms() < f->next_beat_ms)
            continue;
        send_beat(f);
        f->next_beat_ms = fake_now_ms() + f->beat_ms;
    }
    wire_frame_inbox_fini(&f->inbox);
}
