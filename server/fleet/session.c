#include "server/fleet/session.h"

#include <stdlib.h>

static const char *const state_names[SESSION_STATE_COUNT] = {"greeting", "working", "draining",
                                                             "leaving", "closing"};

/* legal[from] has a bit for each state that may follow. */
#define TO(state) (1u << SESSION_##state)
static const unsigned legal[SESSION_STATE_COUNT] = {
    [SESSION_GREETING] = TO(WORKING) | TO(LEAVING) | TO(CLOSING),
    [SESSION_WORKING] = TO(DRAINING) | TO(LEAVING) | TO(CLOSING),
    [SESSION_DRAINING] = TO(WORKING) | TO(LEAVING) | TO(CLOSING),
    [SESSION_LEAVING] = TO(CLOSING),
    [SESSION_CLOSING] = 0,
};

const char *session_state_name(enum session_state state)
{
    return state_names[state];
}

void session_enter(struct session *s, enum session_state next)
{
    if (!(legal[s->state] & (1u << next))) abort(); /* our own bug */
    s->state = next;
}

bool session_is_listening(const struct session *s)
{
    return s->state < SESSION_LEAVING;
}

static uint64_t now_ms(const struct session *s)
{
    return uv_now(s->handle.any.loop);
}

static void wake(struct session *s)
{
    s->host->wake(s->host->ctx);
}

static void on_written(struct outbox *box)
{
    struct session *s = box->stream->data;
    if (s->state != SESSION_CLOSING && (box->error || !s->reading || s->state == SESSION_LEAVING))
        wake(s);
}

int session_create(uv_loop_t *loop, bool tcp, const struct link_key *key, uint64_t id,
                   const struct session_host *host, struct fleet_totals *totals,
                   struct session **out)
{
    struct session *s = calloc(1, sizeof *s);
    if (!s) return ERR_MEMORY;
    int e = key ? channel_create(true, key, &s->channel) : 0;
    if (e) {
        free(s);
        return e;
    }
    int status = tcp ? uv_tcp_init(loop, &s->handle.tcp) : uv_pipe_init(loop, &s->handle.pipe, 0);
    if (status < 0) {
        channel_destroy(&s->channel);
        free(s);
        return ERR_IO;
    }
    s->handle.any.data = s;
    s->host = host;
    s->totals = totals;
    s->id = id;
    s->local = !tcp;
    s->next_request = 1;
    wire_frame_inbox_init(&s->inbox, LIMIT_HELLO_BYTES);
    outbox_init(&s->outbox, &s->handle.stream, &s->sent_bytes, on_written);
    s->outbox.channel = s->channel;
    blob_source_init(&s->blob);
    s->connected_ms = s->heard_ms = s->progress_ms = s->rate_ms = uv_now(loop);
    *out = s;
    return 0;
}

void session_destroy(struct session **session)
{
    struct session *s = *session;
    *session = NULL;
    *s->host->unacked_bytes -= s->unacked_bytes;
    wire_frame_inbox_fini(&s->inbox);
    outbox_fini(&s->outbox);
    channel_destroy(&s->channel);
    lease_table_fini(&s->leases);
    blob_source_fini(&s->blob);
    free(s->frames);
    free(s->unacked);
    free(s);
}

static void on_closed(uv_handle_t *handle)
{
    struct session *s = handle->data;
    s->host->closed(s->host->ctx, s);
}

void session_drop(struct session *s)
{
    if (s->state == SESSION_CLOSING) return;
    session_enter(s, SESSION_CLOSING);
    s->reading = false;
    uv_close(&s->handle.any, on_closed);
}

/* Returns leases, oldest first. Each leaves the table before the client hears of it, because the
 * client may cancel frames from inside. */
static void return_leases(struct session *s, enum fleet_return why)
{
    uint32_t begun = lease_begun(&s->leases);
    while (s->leases.count > 0) {
        struct fleet_tile tile = s->leases.at[0].tile;
        lease_remove(&s->leases, 0, now_ms(s));
        const bool untouched = why == FLEET_DIED && begun == 0;
        s->host->returned(s->host->ctx, s, &tile, untouched ? FLEET_TAKEN_BACK : why);
        begun -= begun > 0;
    }
}

static enum fleet_return return_of(const struct session *s, enum session_end why)
{
    if (why == SESSION_BREACHED) return FLEET_SENT_AWAY;
    if (why == SESSION_SILENT) return FLEET_TAKEN_BACK;
    return s->host->gone(s->host->ctx, s) ? FLEET_DIED : FLEET_TAKEN_BACK;
}

void session_end(struct session *s, enum session_end why)
{
    if (s->state == SESSION_CLOSING) return;
    const bool greeted = s->state == SESSION_WORKING || s->state == SESSION_DRAINING;
    if (greeted && why == SESSION_BREACHED) s->host->struck(s->host->ctx, s, STRIKE_PROTOCOL);
    if (greeted && why == SESSION_SILENT && s->leases.count > 0)
        s->host->struck(s->host->ctx, s, STRIKE_SILENT);
    if (greeted && why == SESSION_SILENT) s->host->silent(s->host->ctx, s);
    session_drop(s);
    if (s->leases.count > 0) return_leases(s, return_of(s, why));
}

void session_leave(struct session *s)
{
    session_enter(s, SESSION_LEAVING);
    s->left_ms = now_ms(s);
    return_leases(s, FLEET_GIVEN_BACK);
    wake(s);
}

/* ---- reading ---- */

static bool may_read(const struct session *s)
{
    return s->unacked_bytes <= SESSION_UNACKED_BYTES &&
           outbox_backlog(&s->outbox) <= SESSION_BACKLOG_BYTES &&
           *s->host->unacked_bytes <= SESSION_ALL_UNACKED_BYTES;
}

static void end_corrupt(struct session *s, int error)
{
    s->totals->corrupt++;
    session_end(s, error == ERR_MEMORY ? SESSION_BROKE : SESSION_BREACHED);
}

/* Takes whole frames while limits allow. A fault ends the session. */
static void digest_inbox(struct session *s)
{
    struct wire_frame_view f;
    while (session_is_listening(s) && may_read(s)) {
        int e = wire_frame_inbox_next(&s->inbox, &f);
        if (e == ERR_INCOMPLETE) return;
        if (e == ERR_LIMIT && s->state == SESSION_GREETING) {
            session_refuse_greeting(s, 0, e);
            return;
        }
        if (e == 0) e = session_take(s, &f);
        if (e != 0) {
            end_corrupt(s, e);
            return;
        }
    }
}

/* Opens what has come sealed, as long as frames are taken. The handshake is in it: a peer without
 * the key ends here, one that says nothing with the time for its HELLO. */
static void open_sealed(struct session *s)
{
    while (session_is_listening(s) && may_read(s)) {
        size_t space_bytes = 0, got = 0;
        uint8_t *space = wire_frame_inbox_space(&s->inbox, &space_bytes);
        const int e = space ? channel_read(s->channel, space, space_bytes, &got) : ERR_MEMORY;
        wake(s); /* it may have words of its own to send */
        if (e == ERR_INCOMPLETE) return;
        if (e) {
            /* The fault is the line's or the coordinator's, never the worker's. */
            session_end(s, SESSION_BROKE);
            return;
        }
        wire_frame_inbox_filled(&s->inbox, got);
        digest_inbox(s);
    }
}

/* libuv fills it and calls on_read before anything else is read. */
static char sealed[65536];

static void on_space(uv_handle_t *handle, size_t suggested, uv_buf_t *out)
{
    (void)suggested;
    struct session *s = handle->data;
    static char ignored[4096];
    if (!session_is_listening(s)) {
        *out = uv_buf_init(ignored, sizeof ignored);
        return;
    }
    if (s->channel) {
        *out = uv_buf_init(sealed, sizeof sealed);
        return;
    }
    size_t space_bytes = 0;
    uint8_t *space = wire_frame_inbox_space(&s->inbox, &space_bytes);
    if (space_bytes > INT32_MAX) space_bytes = INT32_MAX;
    *out = uv_buf_init((char *)space, space ? (unsigned)space_bytes : 0);
}

static void pause_reading(struct session *s)
{
    uv_read_stop(&s->handle.stream);
    s->reading = false;
}

static void on_read(uv_stream_t *stream, ssize_t size_bytes, const uv_buf_t *buf)
{
    struct session *s = stream->data;
    if (size_bytes < 0) {
        session_end(s, SESSION_BROKE);
        return;
    }
    s->received_bytes += (uint64_t)size_bytes;
    s->totals->bytes_received += (uint64_t)size_bytes;
    s->heard_ms = now_ms(s);
    if (!session_is_listening(s)) return;
    if (!s->channel) {
        wire_frame_inbox_filled(&s->inbox, (size_t)size_bytes);
        digest_inbox(s);
    } else if (channel_feed(s->channel, buf->base, (size_t)size_bytes) == 0) {
        open_sealed(s);
    } else {
        session_end(s, SESSION_BROKE);
    }
    if (session_is_listening(s) && !may_read(s)) pause_reading(s);
}

void session_start(struct session *s)
{
    if (uv_read_start(&s->handle.stream, on_space, on_read) < 0)
        session_end(s, SESSION_BROKE);
    else
        s->reading = true;
}

static void resume_reading(struct session *s)
{
    digest_inbox(s); /* what had come before the pause */
    if (s->channel) open_sealed(s);
    if (!session_is_listening(s) || !may_read(s)) return;
    s->heard_ms = now_ms(s); /* it could not be heard */
    session_start(s);
}

void session_turn(struct session *s)
{
    if (session_is_listening(s) && !s->reading && may_read(s)) resume_reading(s);
    if (s->state == SESSION_CLOSING) return;
    uint64_t sent_bytes = s->sent_bytes;
    int e = outbox_flush(&s->outbox);
    s->totals->bytes_sent += s->sent_bytes - sent_bytes;
    if (e)
        session_end(s, SESSION_BROKE);
    else if (s->state == SESSION_LEAVING && !s->reading)
        session_start(s); /* so that the peer's close is seen */
}

/* ---- clocks ---- */

static uint64_t overtaken(const struct session *s)
{
    return 64u + 8u * (uint64_t)s->hello.threads;
}

static void take_back_stalled(struct session *s, uint64_t now, uint32_t stall_ms)
{
    uint32_t at;
    const bool was_stalled = s->stalled;
    while ((at = lease_stalled(&s->leases, now, s->progress_ms, s->answered, overtaken(s),
                               stall_ms)) != LEASE_NONE) {
        struct fleet_tile tile = s->leases.at[at].tile;
        if (now - s->progress_ms >= stall_ms) s->stalled = true;
        lease_remove(&s->leases, at, now);
        s->host->returned(s->host->ctx, s, &tile, FLEET_TAKEN_BACK);
    }
    if (s->stalled && !was_stalled) s->host->struck(s->host->ctx, s, STRIKE_STALLED);
}

static void end_quarantine(struct session *s, uint64_t now)
{
    if (s->quarantined_until_ms != 0 && now >= s->quarantined_until_ms) session_quarantine(s, 0);
}

static void update_rates(struct session *s, uint64_t now)
{
    uint64_t ms = now - s->rate_ms;
    if (ms < 1000) return;
    double tiles = 1000.0 * (double)(s->answered - s->rate_tiles) / (double)ms;
    double rays = 1000.0 * (double)(s->rays - s->rate_rays) / (double)ms;
    s->tiles_per_s = s->rate_tiles ? 0.5 * (s->tiles_per_s + tiles) : tiles;
    s->rays_per_s = s->rate_rays ? 0.5 * (s->rays_per_s + rays) : rays;
    s->rate_ms = now;
    s->rate_tiles = s->answered;
    s->rate_rays = s->rays;
}

static bool is_late(const struct session *s, uint64_t now, uint32_t silence_ms)
{
    switch (s->state) {
    case SESSION_GREETING:
        return now - s->connected_ms >= SESSION_HELLO_MS;
    case SESSION_LEAVING:
        return now - s->left_ms >= SESSION_LEAVE_MS;
    default:
        return s->reading && now - s->heard_ms >= silence_ms;
    }
}

void session_tick(struct session *s, uint64_t now, uint32_t silence_ms, uint32_t stall_ms)
{
    if (s->state == SESSION_CLOSING) return;
    if (is_late(s, now, silence_ms)) {
        session_end(s, SESSION_SILENT);
        return;
    }
    if (!session_is_listening(s) || s->state == SESSION_GREETING) return;
    if (!s->reading) s->progress_ms = now; /* we do not listen: nothing may be held against it */
    take_back_stalled(s, now, stall_ms);
    end_quarantine(s, now);
    update_rates(s, now);
}
