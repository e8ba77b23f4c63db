/* What the fleet asks of a session. Nothing here calls the host back but for a wake. */
#include <stdlib.h>
#include <string.h>

#include "server/fleet/session.h"

bool session_may_work(const struct session *s)
{
    return s->state == SESSION_WORKING && !s->stalled;
}

bool session_takes_more(const struct session *s)
{
    const bool is_alone = s->leases.count > 0 && s->leases.at[0].tile.alone;
    return session_may_work(s) && s->want > 0 && !is_alone;
}

bool session_knows_frame(const struct session *s, uint64_t frame_id)
{
    for (uint32_t i = 0; i < s->frame_count; i++)
        if (s->frames[i] == frame_id) return true;
    return false;
}

static void send_cancel(struct session *s, uint64_t frame_id)
{
    struct message_cancel m = {.frame_id = frame_id};
    message_encode_cancel(outbox_payload(&s->outbox), &m);
    outbox_put(&s->outbox, MESSAGE_CANCEL, 0);
    s->host->wake(s->host->ctx);
}

static void forget_frame_at(struct session *s, uint32_t at)
{
    s->frame_count--;
    memmove(&s->frames[at], &s->frames[at + 1], (s->frame_count - at) * sizeof s->frames[0]);
}

static bool is_frame_in_use(const struct session *s, uint64_t frame_id)
{
    for (uint32_t i = 0; i < s->unacked_count; i++)
        if (s->unacked[i].tile.frame_id == frame_id) return true;
    return lease_has_frame(&s->leases, frame_id);
}

/* Makes room for one more frame; an idle one is dropped on the worker, which frees its scene. There
 * are at most LIMIT_TILES_IN_HAND frames with leases, and the unacknowledged are bounded, too. */
static int make_frame_room(struct session *s)
{
    for (uint32_t i = 0; i < s->frame_count && s->frame_count >= SESSION_FRAMES; i++) {
        if (is_frame_in_use(s, s->frames[i])) continue;
        send_cancel(s, s->frames[i]);
        forget_frame_at(s, i);
        break;
    }
    uint64_t *frames = realloc(s->frames, (s->frame_count + 1) * sizeof *frames);
    if (!frames) return ERR_MEMORY;
    s->frames = frames;
    return 0;
}

int session_send_plan(struct session *s, const struct message_frame_plan *plan)
{
    int e = make_frame_room(s);
    if (e) return e;
    message_encode_frame_plan(outbox_payload(&s->outbox), plan);
    outbox_put(&s->outbox, MESSAGE_FRAME, 0);
    s->frames[s->frame_count++] = plan->frame_id;
    return 0;
}

int session_send_tile(struct session *s, const struct fleet_tile *tile, uint64_t now)
{
    struct lease lease = {.tile = *tile, .since_ms = now, .answered_before = s->answered};
    lease.tile.counts = lease.tile.pass.strata_map = lease.tile.pass.lobes =
        NULL; /* not for the lease's life */
    int e = lease_add(&s->leases, &lease);
    if (e) return e;
    if (s->leases.count == 1) s->progress_ms = now; /* it had nothing to show progress in */
    struct message_tile m = {.frame_id = tile->frame_id,
                             .index = tile->index,
                             .generation = tile->generation,
                             .pass = tile->pass,
                             .rect = tile->rect,
                             .counts = tile->counts,
                             .counts_bytes = tile->counts_bytes};
    message_encode_tile(outbox_payload(&s->outbox), &m);
    outbox_put(&s->outbox, MESSAGE_TILE, s->next_request++);
    if (s->want > 0) s->want--;
    return 0;
}

int session_add_unacked(struct session *s, uint64_t request_id, const struct message_result *r)
{
    if (s->unacked_count == s->unacked_capacity) {
        uint32_t capacity = s->unacked_capacity ? 2 * s->unacked_capacity : 16;
        struct session_unacked *more = realloc(s->unacked, capacity * sizeof *more);
        if (!more) return ERR_MEMORY;
        s->unacked = more;
        s->unacked_capacity = capacity;
    }
    s->unacked[s->unacked_count++] = (struct session_unacked){
        .tile = {.frame_id = r->frame_id, .index = r->index, .generation = r->generation},
        .request_id = request_id,
        .size_bytes = r->samples_bytes};
    s->unacked_bytes += r->samples_bytes;
    *s->host->unacked_bytes += r->samples_bytes;
    return 0;
}

static void remove_unacked(struct session *s, uint32_t at)
{
    s->unacked_bytes -= s->unacked[at].size_bytes;
    *s->host->unacked_bytes -= s->unacked[at].size_bytes;
    s->unacked[at] = s->unacked[--s->unacked_count];
}

static void count_verdict(struct fleet_totals *totals, uint32_t verdict)
{
    totals->duplicate += verdict == VERDICT_DUPLICATE;
    totals->stale += verdict == VERDICT_STALE;
    totals->foreign += verdict == VERDICT_FOREIGN;
    totals->corrupt += verdict == VERDICT_CORRUPT;
}

void session_ack(struct session *s, const struct message_ack *ack, uint64_t request_id)
{
    for (uint32_t i = 0; i < s->unacked_count; i++) {
        const struct lease_key *tile = &s->unacked[i].tile;
        if (tile->index != ack->index || tile->frame_id != ack->frame_id ||
            tile->generation != ack->generation)
            continue;
        request_id = s->unacked[i].request_id;
        remove_unacked(s, i);
        break;
    }
    count_verdict(s->totals, ack->verdict);
    if (!session_is_listening(s)) return;
    message_encode_ack(outbox_payload(&s->outbox), ack);
    outbox_put(&s->outbox, MESSAGE_ACK, request_id);
    s->host->wake(s->host->ctx);
}

void session_cancel(struct session *s, uint64_t frame_id)
{
    lease_forget_frame(&s->leases, frame_id, uv_now(s->handle.any.loop));
    for (uint32_t i = s->unacked_count; i-- > 0;)
        if (s->unacked[i].tile.frame_id == frame_id) remove_unacked(s, i);
    for (uint32_t i = 0; i < s->frame_count; i++) {
        if (s->frames[i] != frame_id) continue;
        forget_frame_at(s, i);
        if (session_is_listening(s)) send_cancel(s, frame_id);
        return;
    }
}

void session_drain(struct session *s, bool drain)
{
    if (drain == (s->state == SESSION_DRAINING)) return;
    session_enter(s, drain ? SESSION_DRAINING : SESSION_WORKING);
    if (drain) {
        struct message_drain m = {0};
        message_encode_drain(outbox_payload(&s->outbox), &m);
        outbox_put(&s->outbox, MESSAGE_DRAIN, 0);
    } else if (s->want == 0) {
        s->want = 1; /* it asks for no more while it drains; a tile tells it to ask again */
    }
    s->host->wake(s->host->ctx);
}

void session_quarantine(struct session *s, uint64_t until_ms)
{
    if (s->state != SESSION_WORKING && s->state != SESSION_DRAINING) return;
    if (until_ms == 0 && s->quarantined_until_ms == 0) return;
    if (until_ms != 0 && s->state == SESSION_DRAINING && s->quarantined_until_ms == 0) return;
    s->quarantined_until_ms = until_ms;
    session_drain(s, until_ms != 0);
}
