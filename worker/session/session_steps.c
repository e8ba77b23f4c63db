#include "worker/session/session_work.h"

#define BEAT_MIN_MS 20u
#define BEAT_MAX_MS 60000u

static int take_welcome(struct session *s, const struct wire_frame_view *f)
{
    struct message_welcome m;
    int e = message_decode_welcome(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (s->worker_id && s->worker_id >> WORKER_ID_LIFE_SHIFT != m.worker_id >> WORKER_ID_LIFE_SHIFT)
        leases_drop_all(s->leases);
    s->worker_id = m.worker_id;
    s->beat_ms = m.beat_ms < BEAT_MIN_MS   ? BEAT_MIN_MS
                 : m.beat_ms > BEAT_MAX_MS ? BEAT_MAX_MS
                                           : m.beat_ms;
    session_enter(s, SESSION_WORKING);
    uv_timer_stop(&s->patience);
    session_deadlines_welcome(s);
    session_begin_beats(s);
    link_settle(s->link);
    session_note(s, LOG_INFO, "connected", "");
    s->was_told_offline = false;
    leases_resend(s->leases);
    blob_cache_link_up(s->cache);
    session_ask_for_tiles(s);
    return 0;
}

static int take_refused(struct session *s, const struct wire_frame_view *f)
{
    struct message_refused m;
    int e = message_decode_refused(f->payload, f->payload_bytes, &m);
    if (e) return e;
    session_end(s, SESSION_END_REFUSED, m.text);
    return 0;
}

static int take_frame(struct session *s, const struct wire_frame_view *f)
{
    struct message_frame_plan m;
    int e = message_decode_frame_plan(f->payload, f->payload_bytes, &m);
    return e ? e : leases_add_frame(s->leases, &m);
}

static int take_tile(struct session *s, const struct wire_frame_view *f)
{
    struct message_tile m;
    int e = message_decode_tile(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (s->state == SESSION_DRAINING) session_enter(s, SESSION_WORKING);
    if (s->asked > 0) s->asked--;
    e = leases_add_tile(s->leases, f->request_id, &m);
    session_deadlines_moved(s);
    session_ask_for_tiles(s);
    return e;
}

/* Returns a lease that crossed the session's end. */
static int return_tile(struct session *s, const struct wire_frame_view *f)
{
    struct message_tile m;
    int e = message_decode_tile(f->payload, f->payload_bytes, &m);
    if (e) return e;
    struct message_returned back = {
        .frame_id = m.frame_id, .index = m.index, .generation = m.generation};
    session_say_returned(s, f->request_id, &back);
    return 0;
}

static int take_ack(struct session *s, const struct wire_frame_view *f)
{
    struct message_ack m;
    int e = message_decode_ack(f->payload, f->payload_bytes, &m);
    if (e) return e;
    leases_acknowledge(s->leases, &m);
    session_moved(s);
    return 0;
}

static int take_cancel(struct session *s, const struct wire_frame_view *f)
{
    struct message_cancel m;
    int e = message_decode_cancel(f->payload, f->payload_bytes, &m);
    if (e) return e;
    leases_cancel(s->leases, m.frame_id);
    session_moved(s);
    return 0;
}

static int take_blob_part(struct session *s, const struct wire_frame_view *f)
{
    struct message_blob_part m;
    int e = message_decode_blob_part(f->payload, f->payload_bytes, &m);
    if (e) return e;
    blob_cache_part(s->cache, &m);
    return 0;
}

static int take_blob_none(struct session *s, const struct wire_frame_view *f)
{
    struct message_blob_none m;
    int e = message_decode_blob_none(f->payload, f->payload_bytes, &m);
    if (e) return e;
    blob_cache_none(s->cache, &m.digest);
    return 0;
}

static int take_drain(struct session *s, const struct wire_frame_view *f)
{
    struct message_drain m;
    int e = message_decode_drain(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (s->state == SESSION_WORKING) {
        session_enter(s, SESSION_DRAINING);
        session_note(s, LOG_INFO, "draining", "");
    }
    return 0;
}

#define MESSAGE_TYPE_END (MESSAGE_FAULT + 1)
typedef int (*step)(struct session *s, const struct wire_frame_view *f);
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

int session_take(struct session *s, const struct wire_frame_view *f)
{
    if (s->state == SESSION_ENDED) return 0;
    step take = f->type < MESSAGE_TYPE_END ? steps[s->state][f->type] : NULL;
    return take ? take(s, f) : ERR_STATE;
}
