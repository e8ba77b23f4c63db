#include <stdio.h>
#include <unistd.h>

#include "proto/runtime/build.h"
#include "worker/process/process_stats.h"
#include "worker/process/worker_name.h"
#include "worker/session/session_work.h"

/* Asks for as many tiles as we may hold beyond those that we hold or have asked for. Results that
 * wait for their acknowledgement hold new tiles back, too, so that memory stays bounded. */
void session_ask_for_tiles(struct session *s)
{
    if (s->state != SESSION_WORKING) return;
    const struct leases_counts counts = leases_counts(s->leases);
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

void session_say_hello(struct session *s)
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
        (void)worker_name_default(m.name, sizeof m.name);
    message_encode_hello(link_payload(s->link), &m);
    link_put(s->link, MESSAGE_HELLO, s->next_request++);
}

static void say_bye(struct session *s)
{
    struct message_bye m = {0};
    message_encode_bye(link_payload(s->link), &m);
    link_put(s->link, MESSAGE_BYE, 0);
}

void session_say_goodbye(struct session *s)
{
    say_bye(s);
    session_end(s, SESSION_END_TOLD, "");
}

void session_say_returned(struct session *s, uint64_t request_id, const struct message_returned *m)
{
    if (!session_is_on(s)) return;
    message_encode_returned(link_payload(s->link), m);
    link_put(s->link, MESSAGE_RETURN, request_id);
}

static void on_ack_patience(uv_timer_t *timer)
{
    session_say_goodbye(timer->data);
}

/* Returns whether a leaving session still has something to wait for. */
void session_leave_when_done(struct session *s)
{
    if (s->state != SESSION_LEAVING) return;
    struct leases_counts counts = leases_counts(s->leases);
    if (counts.open > 0) return;
    if (counts.kept == 0)
        session_say_goodbye(s);
    else if (!uv_is_active((uv_handle_t *)&s->patience))
        uv_timer_start(&s->patience, on_ack_patience, SESSION_ACK_MS, 0);
}

void session_moved(struct session *s)
{
    session_ask_for_tiles(s);
    session_deadlines_moved(s);
    session_leave_when_done(s);
}

/* ---- beats ---- */

static enum beat_phase phase(const struct session *s)
{
    if (leases_is_tracing(s->leases)) return BEAT_TRACING;
    return blob_cache_is_busy(s->cache) ? BEAT_LOADING : BEAT_IDLE;
}

/* Counts the time of beats in which a load has made no step. A beat counts for beat_ms at most,
 * since a process that was stopped sends a late one when it continues. Beats in which at least a
 * tenth of a CPU was used are counted apart: such a load counts as hung sooner than one that waits
 * for a disk. */
static void watch_loading(struct session *s, uint64_t cpu_us, uint64_t passed_ms)
{
    const uint64_t used_us = cpu_us - s->cpu_us, steps = blob_cache_steps(s->cache);
    s->cpu_us = cpu_us;
    if (steps != s->load_steps || !blob_cache_runs_loads(s->cache)) {
        s->load_steps = steps;
        s->load_silent_ms = s->load_busy_ms = 0;
        return;
    }
    if (passed_ms > s->beat_ms) passed_ms = s->beat_ms;
    s->load_silent_ms += passed_ms;
    if (used_us < 100u * passed_ms) return;
    s->load_busy_ms += passed_ms;
    s->load_beats++;
}

static bool load_hangs(const struct session *s)
{
    const uint64_t busy_ms = s->options->loading_ms ? s->options->loading_ms : SESSION_LOADING_MS;
    return s->load_busy_ms > busy_ms || s->load_silent_ms > SESSION_LOADING_WAITS * busy_ms;
}

/* Ends the session, since only the end of the process ends a load that hangs; its supervisor starts
 * another worker. The tiles are returned as by a worker that leaves, so that none is suspected. */
static void give_up_loading(struct session *s)
{
    char text[96];
    snprintf(text, sizeof text, "a load has made no step for %llu s",
             (unsigned long long)s->load_silent_ms / 1000);
    leases_return(s->leases, true);
    say_bye(s);
    session_end(s, SESSION_END_FAILED, text);
}

void session_send_beat(struct session *s)
{
    struct process_stats v;
    const uint64_t now = uv_now(s->beat.loop);
    const uint64_t passed_ms = s->last_beat_ms > 0 ? now - s->last_beat_ms : 0;
    s->last_beat_ms = now;
    process_stats_read(&v);
    watch_loading(s, v.cpu_us, passed_ms);
    struct message_beat m = {.progress = leases_rows(s->leases) + blob_cache_steps(s->cache) +
                                         s->load_beats,
                             .phase = phase(s),
                             .tiles_in_hand = leases_counts(s->leases).open,
                             .rss_bytes = v.rss_bytes,
                             .peak_rss_bytes = v.peak_rss_bytes,
                             .cpu_us = v.cpu_us};
    message_encode_beat(link_payload(s->link), &m);
    link_put(s->link, MESSAGE_BEAT, 0);
}

static void on_beat(uv_timer_t *timer)
{
    struct session *s = timer->data;
    if (load_hangs(s))
        give_up_loading(s);
    else
        session_send_beat(s);
}

void session_begin_beats(struct session *s)
{
    s->load_silent_ms = s->load_busy_ms = 0;
    uv_timer_start(&s->beat, on_beat, s->beat_ms, s->beat_ms);
}
