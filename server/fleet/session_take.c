/* What a session does with each message: one step function a message, a table of which message is
 * legal in which state. A negative code ends the session. */
#include <string.h>

#include "server/fleet/admission.h"
#include "server/fleet/session.h"

static void refuse(struct session *s, uint64_t request_id, const struct message_refused *refused)
{
    s->totals->refused++;
    s->host->refused(s->host->ctx, s, refused);
    message_encode_refused(outbox_payload(&s->outbox), refused);
    outbox_put(&s->outbox, MESSAGE_REFUSED, request_id);
    session_leave(s);
}

void session_refuse_greeting(struct session *s, uint64_t request_id, int error)
{
    struct message_refused refused = {0};
    s->hello = (struct message_hello){.threads = 1};
    admission_refuse_greeting(error, &refused);
    refuse(s, request_id, &refused);
}

/* The version comes first in every HELLO, whatever follows it. */
static bool speaks_another_version(struct session *s, const struct wire_frame_view *f)
{
    struct bytes_reader r;
    bytes_reader_init(&r, f->payload, f->payload_bytes);
    uint32_t version = bytes_read_u32(&r);
    if (r.failed || version == PROTOCOL_VERSION) return false;
    s->hello = (struct message_hello){.protocol_version = version, .threads = 1};
    return true;
}

static int take_hello(struct session *s, const struct wire_frame_view *f)
{
    struct message_welcome welcome = {0};
    struct message_refused refused = {0};
    int e = message_decode_hello(f->payload, f->payload_bytes, &s->hello);
    if (e && speaks_another_version(s, f)) e = 0; /* greet refuses it with words */
    if (e) {
        session_refuse_greeting(s, f->request_id, e);
        return 0;
    }
    if (!s->host->greet(s->host->ctx, s, &welcome, &refused)) {
        refuse(s, f->request_id, &refused);
        return 0;
    }
    session_enter(s, SESSION_WORKING);
    s->leases.threads = s->hello.threads;
    s->inbox.limit_bytes = LIMIT_FRAME_BYTES;
    message_encode_welcome(outbox_payload(&s->outbox), &welcome);
    outbox_put(&s->outbox, MESSAGE_WELCOME, f->request_id);
    if (s->quarantined_until_ms) session_drain(s, true); /* greet knew it */
    s->host->wake(s->host->ctx);
    return 0;
}

static int take_want(struct session *s, const struct wire_frame_view *f)
{
    struct message_want m;
    int e = message_decode_want(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (m.tiles > LIMIT_TILES_IN_HAND - s->want) return ERR_LIMIT;
    s->want += m.tiles;
    s->host->wake(s->host->ctx);
    return 0;
}

static void show_progress(struct session *s)
{
    s->progress_ms = uv_now(s->handle.any.loop);
    if (s->stalled) s->host->wake(s->host->ctx);
    s->stalled = false;
}

static void count_rays(struct session *s, const struct counters *c)
{
    for (int i = 0; i < COUNTER_COUNT; i++)
        if (strcmp(counter_group((enum counter_id)i), "rays") == 0) s->rays += c->value[i];
}

static int take_result(struct session *s, const struct wire_frame_view *f)
{
    struct message_result m;
    int e = message_decode_result(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (lease_find(&s->leases, m.frame_id, m.index, m.generation) != LEASE_NONE) {
        s->answered++;
        count_rays(s, &m.counters);
        show_progress(s);
    }
    return s->host->result(s->host->ctx, s, f->request_id, &m);
}

/* Takes a lease out; false when it is not held (it was taken back, or its frame is gone). */
static bool end_lease(struct session *s, uint64_t frame_id, uint32_t index, uint32_t generation,
                      struct fleet_tile *tile)
{
    uint32_t at = lease_find(&s->leases, frame_id, index, generation);
    if (at == LEASE_NONE) return false;
    *tile = s->leases.at[at].tile;
    lease_remove(&s->leases, at, uv_now(s->handle.any.loop));
    return true;
}

static int take_return(struct session *s, const struct wire_frame_view *f)
{
    struct message_returned m;
    struct fleet_tile tile;
    int e = message_decode_returned(f->payload, f->payload_bytes, &m);
    if (e) return e;
    s->want = 0; /* a worker that gives tiles back is leaving; more would come back, too */
    if (end_lease(s, m.frame_id, m.index, m.generation, &tile))
        s->host->returned(s->host->ctx, s, &tile, FLEET_GIVEN_BACK);
    return 0;
}

static int take_fault(struct session *s, const struct wire_frame_view *f)
{
    struct message_tile_fault m;
    struct fleet_tile tile;
    int e = message_decode_tile_fault(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (end_lease(s, m.frame_id, m.index, m.generation, &tile))
        s->host->faulted(s->host->ctx, s, &m);
    return 0;
}

static int send_blob_none(struct session *s, uint64_t request_id, const struct digest *digest)
{
    struct message_blob_none none = {.digest = *digest};
    message_encode_blob_none(outbox_payload(&s->outbox), &none);
    outbox_put(&s->outbox, MESSAGE_BLOB_NONE, request_id);
    s->host->wake(s->host->ctx);
    return 0;
}

static int open_blob(struct session *s, const struct digest *digest)
{
    char path[4608];
    if (s->blob.fd >= 0 && digest_equal(&s->blob.digest, digest)) return 0;
    if (!s->host->blob_path(s->host->ctx, digest, path, sizeof path)) return ERR_NOT_FOUND;
    return blob_source_open(&s->blob, digest, path);
}

static int take_blob_get(struct session *s, const struct wire_frame_view *f)
{
    struct message_blob_get m;
    void *bytes = NULL;
    uint32_t size_bytes = 0;
    int e = message_decode_blob_get(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (open_blob(s, &m.digest) != 0) return send_blob_none(s, f->request_id, &m.digest);
    e = blob_source_read(&s->blob, m.offset, m.size_bytes, &bytes, &size_bytes);
    if (e == ERR_IO) return send_blob_none(s, f->request_id, &m.digest);
    if (e) return e;
    struct message_blob_part part = {.digest = m.digest,
                                     .total_bytes = s->blob.total_bytes,
                                     .offset = m.offset,
                                     .bytes = bytes,
                                     .size_bytes = size_bytes};
    message_encode_blob_part(outbox_payload(&s->outbox), &part);
    outbox_put_tail(&s->outbox, MESSAGE_BLOB_PART, f->request_id, bytes, size_bytes);
    show_progress(s);
    return 0;
}

static int take_beat(struct session *s, const struct wire_frame_view *f)
{
    struct message_beat m;
    int e = message_decode_beat(f->payload, f->payload_bytes, &m);
    if (e) return e;
    if (m.progress > s->beat.progress) show_progress(s);
    if (m.peak_rss_bytes > s->totals->peak_rss_bytes) s->totals->peak_rss_bytes = m.peak_rss_bytes;
    s->beat = m;
    return 0;
}

static int take_bye(struct session *s, const struct wire_frame_view *f)
{
    struct message_bye m;
    int e = message_decode_bye(f->payload, f->payload_bytes, &m);
    if (e) return e;
    session_leave(s);
    return 0;
}

#define MESSAGE_TYPE_END (MESSAGE_FAULT + 1)
typedef int (*step)(struct session *s, const struct wire_frame_view *f);
/* What a worker sends between its HELLO and its end. */
#define STEPS_WHEN_JOINED                                                                          \
    {                                                                                              \
        [MESSAGE_WANT] = take_want, [MESSAGE_RESULT] = take_result,                                \
        [MESSAGE_RETURN] = take_return, [MESSAGE_FAULT] = take_fault,                              \
        [MESSAGE_BLOB_GET] = take_blob_get, [MESSAGE_BEAT] = take_beat, [MESSAGE_BYE] = take_bye   \
    }
static const step steps[SESSION_STATE_COUNT][MESSAGE_TYPE_END] = {
    [SESSION_GREETING] = {[MESSAGE_HELLO] = take_hello},
    [SESSION_WORKING] = STEPS_WHEN_JOINED,
    [SESSION_DRAINING] = STEPS_WHEN_JOINED,
};

int session_take(struct session *s, const struct wire_frame_view *f)
{
    step take = f->type < MESSAGE_TYPE_END ? steps[s->state][f->type] : NULL;
    return take ? take(s, f) : ERR_STATE;
}
