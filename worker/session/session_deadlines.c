/* When a worker leaves by itself: it was never answered, it idles, its lifetime ends, or memory ran
 * out. All of it is counted on the monotonic clock of this machine, so clocks may differ. */
#include <stdio.h>

#include "worker/session/session_work.h"

#define DRAIN_SHARE  10u    /* the part of a lifetime in which no tile is taken, as a divisor */
#define DRAIN_MAX_MS 60000u /* of it at most */

static uint64_t ms_of(uint32_t seconds)
{
    return 1000ull * seconds;
}

static bool is_leaving(const struct session *s)
{
    return s->state == SESSION_LEAVING || s->state == SESSION_ENDED;
}

static void on_not_connected(uv_timer_t *timer)
{
    struct session *s = timer->data;
    char text[64];
    snprintf(text, sizeof text, "the coordinator has not answered within %u s",
             s->options->connect_within_s);
    session_end(s, SESSION_END_FAILED, text);
}

static void on_idle(uv_timer_t *timer)
{
    struct session *s = timer->data;
    if (is_leaving(s)) return;
    session_note(s, LOG_INFO, "idle", "no tile came for the time of --idle-exit");
    session_stop(s);
}

static void on_lifetime_over(uv_timer_t *timer)
{
    struct session *s = timer->data;
    if (s->state != SESSION_ENDED) session_stop(s); /* a second time: at once */
}

static void on_lifetime_ends(uv_timer_t *timer)
{
    struct session *s = timer->data;
    uv_timer_start(timer, on_lifetime_over, s->drain_ms, 0);
    if (is_leaving(s)) return;
    session_note(s, LOG_INFO, "lifetime ends", "no more tiles are taken");
    session_stop(s);
}

/* Embree cannot be trusted after an allocation of its own has failed: the next build may spin for
 * ever. */
static void on_memory_lacks(uv_timer_t *timer)
{
    struct session *s = timer->data;
    if (!is_leaving(s)) session_stop(s);
}

/* The faults of tiles are told first, since a scene that never fits must fail in the end. */
void session_deadlines_lack_memory(struct session *s)
{
    s->lacks_memory = true;
    uv_timer_start(&s->deadlines[SESSION_DEADLINE_MEMORY], on_memory_lacks, 0, 0);
}

void session_deadlines_init(struct session *s, uv_loop_t *loop)
{
    for (int i = 0; i < SESSION_DEADLINE_COUNT; i++) {
        uv_timer_init(loop, &s->deadlines[i]);
        s->deadlines[i].data = s;
    }
}

void session_deadlines_start(struct session *s)
{
    const struct options *o = s->options;
    const uint64_t life_ms = ms_of(o->lifetime_s);
    s->drain_ms = life_ms / DRAIN_SHARE < DRAIN_MAX_MS ? life_ms / DRAIN_SHARE : DRAIN_MAX_MS;
    uv_update_time(s->beat.loop); /* Embree's device was made since */
    if (o->connect_within_s > 0)
        uv_timer_start(&s->deadlines[SESSION_DEADLINE_CONNECT], on_not_connected,
                       ms_of(o->connect_within_s), 0);
    if (o->lifetime_s > 0)
        uv_timer_start(&s->deadlines[SESSION_DEADLINE_LIFETIME], on_lifetime_ends,
                       life_ms - s->drain_ms, 0);
}

void session_deadlines_moved(struct session *s)
{
    uv_timer_t *idle = &s->deadlines[SESSION_DEADLINE_IDLE];
    if (s->options->idle_exit_s == 0 || s->worker_id == 0) return; /* never welcome: no idling */
    if (is_leaving(s) || leases_counts(s->leases).open > 0)
        uv_timer_stop(idle);
    else if (!uv_is_active((uv_handle_t *)idle))
        uv_timer_start(idle, on_idle, ms_of(s->options->idle_exit_s), 0);
}

void session_deadlines_welcome(struct session *s)
{
    uv_timer_stop(&s->deadlines[SESSION_DEADLINE_CONNECT]);
    session_deadlines_moved(s);
}

void session_deadlines_stop(struct session *s)
{
    for (int i = 0; i < SESSION_DEADLINE_COUNT; i++) uv_timer_stop(&s->deadlines[i]);
}
