#include "worker/session.h"

#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/build.h"
#include "proto/message.h"
#include "worker/crew.h"
#include "worker/hand.h"
#include "worker/link.h"
#include "worker/shelf.h"
#include "worker/vitals.h"

#define BEAT_MIN_MS 20u
#define BEAT_MAX_MS 60000u
#define TEXT_BYTES  768

struct session {
    const struct options *options;
    const struct tracing *tracing;
    struct session_client client;
    enum session_state state;
    struct link *link;
    struct crew *crew;
    struct shelf *shelf;
    struct hand *hand;
    uv_timer_t beat, patience;
    uint64_t worker_id; /* of the last WELCOME; 0: none yet */
    uint64_t next_request;
    uint32_t beat_ms;
    uint32_t asked; /* tiles asked for that have not come */
    bool was_told_offline;
    /* Progress of loading: beats in which a load used CPU time. */
    uint64_t load_beats, load_from_ms, cpu_us;
    uint64_t last_beat_ms; /* 0: none on this link */
    unsigned open;         /* what must close before the memory goes */
    bool closing;
    void (*closed)(void *ctx);
    void *closed_ctx;
};

/* ---- states ---- */

#define TO(state) (1u << SESSION_##state)
static const unsigned legal[SESSION_STATE_COUNT] = {
    [SESSION_OFFLINE] = TO(GREETING) | TO(OFFLINE) | TO(ENDED),
    [SESSION_GREETING] = TO(WORKING) | TO(OFFLINE) | TO(ENDED),
    [SESSION_WORKING] = TO(DRAINING) | TO(LEAVING) | TO(OFFLINE) | TO(ENDED),
    [SESSION_DRAINING] = TO(WORKING) | TO(LEAVING) | TO(OFFLINE) | TO(ENDED),
    [SESSION_LEAVING] = TO(ENDED),
    [SESSION_ENDED] = 0,
};

static void enter(struct session *s, enum session_state next)
{
    if (!(legal[s->state] & (1u << next))) abort(); /* our own bug */
    s->state = next;
}

enum session_state session_state(const struct session *s)
{
    return s->state;
}

static void end(struct session *s, enum session_end how, const char *text)
{
    if (s->state == SESSION_ENDED) return;
    enter(s, SESSION_ENDED);
    uv_timer_stop(&s->beat);
    uv_timer_stop(&s->patience);
    s->client.ended(s->client.ctx, how, text);
}

static void note(struct session *s, enum log_level level, const char *what, const char *detail)
{
    const struct log_field fields[] = {{"coordinator", s->options->connect, 0},
                                       {"detail", detail, 0}};
    journal_write(s->client.journal, level, what, fields, 2);
}

static bool is_on(const struct session *s)
{
    return s->state == SESSION_WORKING || s->state == SESSION_DRAINING ||
           s->state == SESSION_LEAVING;
}

/* ---- what we say ---- */

/* Asks for as many tiles as we may hold beyond those that we hold or have asked for. Results that
 * wait for their acknowledgement hold new tiles back, too, so that memory stays bounded. */
static void ask_for_tiles(struct session *s)
{
    if (s->state != SESSION_WORKING) return;
    const struct hand_counts counts = hand_counts(s->hand);
    const uint32_t most = s->options->tiles_in_hand;
    uint32_t held = counts.open > most ? most : counts.open;
    uint32_t room = most - held;
    uint32_t all_room = counts.kept + held < 3 * most ? 3 * most - counts.kept - held : 0;
    if (room > all_room) room = all_room;
    if (room <= s->asked) return;
    struct message_want m = {.tiles = room - s->asked};
    s->asked = room;
    message_encode_want(link_payload(s->link), &m);
    link_put(s->link, MESSAGE_WANT, 0);
}

static void say_hello(struct session *s)
{
    struct message_hello m = {.protocol_version = PROTOCOL_VERSION,
                              .capabilities = s->tracing->capabilities,
                              .threads = s->options->threads,
                              .pid = (uint64_t)getpid()};
    snprintf(m.build_id, sizeof m.build_id, "%s", build_id());
    snprintf(m.embree_version, sizeof m.embree_version, "%s",
             s->tracing->embree_version(s->tracing->ctx));
    snprintf(m.isa, sizeof m.isa, "%s", build_isa());
    if (s->options->name)
        snprintf(m.name, sizeof m.name, "%s", s->options->name);
    else
        (void)options_default_name(m.name, sizeof m.name);
    message_encode_hello(link_payload(s->link), &m);
    link_put(s->link, MESSAGE_HELLO, s->next_request++);
}

static void say_goodbye(struct session *s)
{
    struct message_bye m = {0};
    message_encode_bye(link_payload(s->link), &m);
    link_put(s->link, MESSAGE_BYE, 0);
    end(s, SESSION_END_TOLD, "");
}

static void on_ack_patience(uv_timer_t *timer)
{
    say_goodbye(timer->data);
}

/* When leaving: is there still something to wait for? */
static void leave_when_done(struct session *s)
{
    if (s->state != SESSION_LEAVING) return;
    struct hand_counts counts = hand_counts(s->hand);
    if (counts.open > 0) return;
    if (counts.kept == 0)
        say_goodbye(s);
    else if (!uv_is_active((uv_handle_t *)&s->patience))
        uv_timer_start(&s->patience, on_ack_patience, SESSION_ACK_MS, 0);
}

/* ---- beats ---- */

static enum beat_phase phase(const struct session *s)
{
    if (hand_is_tracing(s->hand)) return BEAT_TRACING;
    return shelf_is_busy(s->shelf) ? BEAT_LOADING : BEAT_IDLE;
}

/* Loading has no rows to count: a beat in which it used a tenth of a CPU is progress, up to a
 * bound, since a load that hangs may use CPU time, too. */
static void watch_loading(struct session *s, uint64_t cpu_us)
{
    const uint64_t now = uv_now(s->beat.loop), used_us = cpu_us - s->cpu_us;
    s->cpu_us = cpu_us;
    if (!shelf_is_loading(s->shelf)) {
        s->load_from_ms = now;
        return;
    }
    if (now - s->load_from_ms <= SESSION_LOADING_MS && used_us >= 100u * (uint64_t)s->beat_ms)
        s->load_beats++;
}

static void send_beat(struct session *s)
{
    struct vitals v;
    s->last_beat_ms = uv_now(s->beat.loop);
    vitals_read(&v);
    watch_loading(s, v.cpu_us);
    struct message_beat m = {.progress = hand_rows(s->hand) + shelf_parts(s->shelf) + s->load_beats,
                             .phase = phase(s),
                             .tiles_in_hand = hand_counts(s->hand).open,
                             .rss_bytes = v.rss_bytes,
                             .peak_rss_bytes = v.peak_rss_bytes,
                             .cpu_us = v.cpu_us};
    message_encode_beat(link_payload(s->link), &m);
    link_put(s->link, MESSAGE_BEAT, 0);
}

static void on_beat(uv_timer_t *timer)
{
    send_beat(timer->data);
}

/* ---- what the hand and the shelf say ---- */

static void on_result(void *ctx, const struct hand_result *result)
{
    struct session *s = ctx;
    if (!is_on(s)) return; /* kept; said again when the link is back */
    /* Short jobs end between two beats: their results tell of us, too. */
    if (uv_now(s->beat.loop) - s->last_beat_ms >= s->beat_ms / 4) send_beat(s);
    struct message_result m = result->message;
    m.samples_bytes = (uint32_t)result->samples->size_bytes;
    message_encode_result(link_payload(s->link), &m);
    link_put_parcel(s->link, MESSAGE_RESULT, result->request_id, result->samples);
}

static void on_tile_fault(void *ctx, uint64_t request_id, const struct message_tile_fault *m)
{
    struct session *s = ctx;
    if (!is_on(s)) return;
    message_encode_tile_fault(link_payload(s->link), m);
    link_put(s->link, MESSAGE_FAULT, request_id);
}

static void on_tile_returned(void *ctx, uint64_t request_id, const struct message_returned *m)
{
    struct session *s = ctx;
    if (!is_on(s)) return;
    message_encode_returned(link_payload(s->link), m);
    link_put(s->link, MESSAGE_RETURN, request_id);
}

static void on_moved(void *ctx)
{
    struct session *s = ctx;
    ask_for_tiles(s);
    leave_when_done(s);
}

static void on_ask_for_part(void *ctx, const struct message_blob_get *m)
{
    struct session *s = ctx;
    message_encode_blob_get(link_payload(s->link), m);
    link_put(s->link, MESSAGE_BLOB_GET, s->next_request++);
}

static void on_blob_settled(void *ctx, struct shelf_blob *blob)
{
    struct session *s = ctx;
    hand_blob_settled(s->hand, blob);
}

/* ---- one step function a message ---- */

static int take_welcome(struct session *s, const struct frame_view *f)
{
    struct message_welcome m;
    int e = message_decode_welcome(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (s->worker_id && s->worker_id >> WORKER_ID_LIFE_SHIFT != m.worker_id >> WORKER_ID_LIFE_SHIFT)
        hand_drop_all(s->hand);
    s->worker_id = m.worker_id;
    s->beat_ms = m.beat_ms < BEAT_MIN_MS   ? BEAT_MIN_MS
                 : m.beat_ms > BEAT_MAX_MS ? BEAT_MAX_MS
                                           : m.beat_ms;
    enter(s, SESSION_WORKING);
    s->load_from_ms = uv_now(s->beat.loop);
    uv_timer_stop(&s->patience);
    uv_timer_start(&s->beat, on_beat, s->beat_ms, s->beat_ms);
    link_settle(s->link);
    note(s, LOG_INFO, "connected", "");
    s->was_told_offline = false;
    hand_resend(s->hand);
    shelf_link_up(s->shelf);
    ask_for_tiles(s);
    return 0;
}

static int take_refused(struct session *s, const struct frame_view *f)
{
    struct message_refused m;
    int e = message_decode_refused(f->payload, f->payload_bytes, &m);
    if (e) return e;
    end(s, SESSION_END_REFUSED, m.text);
    return 0;
}

static int take_frame(struct session *s, const struct frame_view *f)
{
    struct message_frame_plan m;
    int e = message_decode_frame_plan(f->payload, f->payload_bytes, &m);
    return e ? e : hand_add_frame(s->hand, &m);
}

static int take_tile(struct session *s, const struct frame_view *f)
{
    struct message_tile m;
    int e = message_decode_tile(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (s->state == SESSION_DRAINING) enter(s, SESSION_WORKING);
    if (s->asked > 0) s->asked--;
    e = hand_add_tile(s->hand, f->request_id, &m);
    ask_for_tiles(s);
    return e;
}

/* A lease that crossed our leaving. */
static int return_tile(struct session *s, const struct frame_view *f)
{
    struct message_tile m;
    int e = message_decode_tile(f->payload, f->payload_bytes, &m);
    if (e) return e;
    struct message_returned back = {
        .frame_id = m.frame_id, .index = m.index, .generation = m.generation};
    on_tile_returned(s, f->request_id, &back);
    return 0;
}

static int take_ack(struct session *s, const struct frame_view *f)
{
    struct message_ack m;
    int e = message_decode_ack(f->payload, f->payload_bytes, &m);
    if (e) return e;
    hand_acknowledge(s->hand, &m);
    on_moved(s);
    return 0;
}

static int take_cancel(struct session *s, const struct frame_view *f)
{
    struct message_cancel m;
    int e = message_decode_cancel(f->payload, f->payload_bytes, &m);
    if (e) return e;
    hand_cancel(s->hand, m.frame_id);
    on_moved(s);
    return 0;
}

static int take_blob_part(struct session *s, const struct frame_view *f)
{
    struct message_blob_part m;
    int e = message_decode_blob_part(f->payload, f->payload_bytes, &m);
    if (e) return e;
    shelf_part(s->shelf, &m);
    return 0;
}

static int take_blob_none(struct session *s, const struct frame_view *f)
{
    struct message_blob_none m;
    int e = message_decode_blob_none(f->payload, f->payload_bytes, &m);
    if (e) return e;
    shelf_none(s->shelf, &m.digest);
    return 0;
}

static int take_drain(struct session *s, const struct frame_view *f)
{
    struct message_drain m;
    int e = message_decode_drain(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (s->state == SESSION_WORKING) {
        enter(s, SESSION_DRAINING);
        note(s, LOG_INFO, "draining", "");
    }
    return 0;
}

#define MESSAGE_TYPE_END (MESSAGE_FAULT + 1)
typedef int (*step)(struct session *s, const struct frame_view *f);
#define STEPS_WHEN_ON                                                                              \
    [MESSAGE_FRAME] = take_frame, [MESSAGE_ACK] = take_ack, [MESSAGE_CANCEL] = take_cancel,        \
    [MESSAGE_BLOB_PART] = take_blob_part, [MESSAGE_BLOB_NONE] = take_blob_none,                    \
    [MESSAGE_DRAIN] = take_drain
static const step steps[SESSION_STATE_COUNT][MESSAGE_TYPE_END] = {
    [SESSION_GREETING] = {[MESSAGE_WELCOME] = take_welcome, [MESSAGE_REFUSED] = take_refused},
    [SESSION_WORKING] = {STEPS_WHEN_ON, [MESSAGE_TILE] = take_tile},
    [SESSION_DRAINING] = {STEPS_WHEN_ON, [MESSAGE_TILE] = take_tile},
    [SESSION_LEAVING] = {STEPS_WHEN_ON, [MESSAGE_TILE] = return_tile},
};

static int on_frame(void *ctx, const struct frame_view *f)
{
    struct session *s = ctx;
    if (s->state == SESSION_ENDED) return 0;
    step take = f->type < MESSAGE_TYPE_END ? steps[s->state][f->type] : NULL;
    return take ? take(s, f) : ERR_STATE;
}

/* ---- the link ---- */

static void on_greeting_patience(uv_timer_t *timer)
{
    struct session *s = timer->data;
    link_drop(s->link, ERR_TIMEOUT, "the coordinator does not answer");
}

static void on_up(void *ctx)
{
    struct session *s = ctx;
    if (s->state == SESSION_ENDED) return;
    enter(s, SESSION_GREETING);
    s->asked = 0;
    s->last_beat_ms = 0;
    say_hello(s);
    uv_timer_start(&s->patience, on_greeting_patience, SESSION_GREETING_MS, 0);
}

static void on_down(void *ctx, int error, const char *why, uint32_t wait_ms)
{
    struct session *s = ctx;
    char text[TEXT_BYTES];
    (void)error;
    if (s->state == SESSION_ENDED) return;
    uv_timer_stop(&s->beat);
    uv_timer_stop(&s->patience);
    const bool meant = s->state == SESSION_DRAINING && s->options->exit_with_parent;
    if (s->state == SESSION_LEAVING || meant) {
        end(s, SESSION_END_TOLD, "");
        return;
    }
    enter(s, SESSION_OFFLINE);
    shelf_link_down(s->shelf);
    hand_link_lost(s->hand);
    if (s->options->exit_with_parent) {
        end(s, SESSION_END_FAILED, why);
        return;
    }
    if (!s->was_told_offline) {
        snprintf(text, sizeof text,
                 "%s; trying again in %u ms and then ever less often, up to every %u ms", why,
                 wait_ms, LINK_RETRY_MAX_MS);
        note(s, LOG_WARNING, "link lost", text);
    }
    s->was_told_offline = true;
}

/* ---- life ---- */

static void release_one(struct session *s)
{
    if (--s->open > 0 || !s->closing) return;
    void (*closed)(void *ctx) = s->closed;
    void *ctx = s->closed_ctx;
    free(s);
    if (closed) closed(ctx);
}

static void on_timer_closed(uv_handle_t *handle)
{
    release_one(handle->data);
}

static void on_crew_closed(void *ctx)
{
    release_one(ctx);
}

/* The last bytes are out: now the threads may take their time. */
static void close_crew(struct session *s)
{
    if (!s->crew) return;
    if (s->client.flushed && s->shelf) s->client.flushed(s->client.ctx, shelf_is_loading(s->shelf));
    crew_close(s->crew, on_crew_closed, s);
    hand_destroy(&s->hand);
    shelf_destroy(&s->shelf);
}

static void on_link_closed(void *ctx)
{
    struct session *s = ctx;
    s->link = NULL;
    close_crew(s);
    release_one(s);
}

void session_close(struct session *s, void (*closed)(void *ctx), void *ctx)
{
    s->closing = true;
    s->closed = closed;
    s->closed_ctx = ctx;
    if (s->state != SESSION_ENDED) enter(s, SESSION_ENDED);
    if (s->hand) hand_drop_all(s->hand);
    uv_close((uv_handle_t *)&s->beat, on_timer_closed);
    uv_close((uv_handle_t *)&s->patience, on_timer_closed);
    if (s->link)
        link_close(s->link, on_link_closed, s);
    else
        close_crew(s);
}

static int build(struct session *s, uv_loop_t *loop, struct fault *fault)
{
    const struct options *o = s->options;
    const struct shelf_options shelf = {.blob_dir = o->blob_dir,
                                        .cache_dir = o->cache_dir,
                                        .cache_bytes = o->cache_bytes,
                                        .threads = o->threads};
    const struct shelf_client shelf_client = {s, on_ask_for_part, on_blob_settled};
    const struct hand_client hand_client = {
        s, on_result, on_tile_fault, on_tile_returned, on_moved, s->client.journal};
    const struct link_client link_client = {s, on_up, on_frame, on_down};
    struct link_key key;
    int e = o->key ? link_key_read(o->key, &key, fault) : 0;
    if (e == 0)
        e = link_create(loop, o->connect, o->key ? &key : NULL, &link_client, &s->link, fault);
    if (o->key) gnutls_memset(&key, 0, sizeof key);
    if (e) return e;
    s->open++;
    e = crew_create(loop, s->tracing, o->threads, &s->crew);
    if (e == 0) s->open++;
    if (e == 0) e = shelf_create(s->crew, s->tracing, &shelf, &shelf_client, &s->shelf);
    if (e == 0) e = hand_create(s->crew, s->shelf, s->tracing, &hand_client, &s->hand);
    return e ? fault_set(fault, e, "worker", "%s", error_text(e)) : 0;
}

int session_create(uv_loop_t *loop, const struct options *options, const struct tracing *tracing,
                   const struct session_client *client, struct session **out, struct fault *fault)
{
    if (!build_isa()) return fault_set(fault, ERR_UNSUPPORTED, "isa", "this CPU has no SSE 4.2");
    struct session *s = calloc(1, sizeof *s);
    if (!s) return fault_set(fault, ERR_MEMORY, "worker", "%s", error_text(ERR_MEMORY));
    s->options = options;
    s->tracing = tracing;
    s->client = *client;
    s->next_request = 1;
    uv_timer_init(loop, &s->beat);
    uv_timer_init(loop, &s->patience);
    s->beat.data = s->patience.data = s;
    s->open = 2;
    int e = build(s, loop, fault);
    if (e) {
        session_close(s, NULL, NULL);
        return e;
    }
    *out = s;
    return 0;
}

void session_start(struct session *s)
{
    link_dial(s->link);
}

void session_stop(struct session *s)
{
    switch (s->state) {
    case SESSION_OFFLINE:
    case SESSION_GREETING:
        end(s, SESSION_END_TOLD, "");
        return;
    case SESSION_WORKING:
    case SESSION_DRAINING:
        enter(s, SESSION_LEAVING);
        note(s, LOG_INFO, "leaving", "");
        hand_return(s->hand, false);
        leave_when_done(s);
        return;
    case SESSION_LEAVING:
        hand_return(s->hand, true);
        say_goodbye(s);
        return;
    default:
        return;
    }
}
