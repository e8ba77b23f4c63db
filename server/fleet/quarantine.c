/* Puts workers into quarantine after strikes and takes them back, and tells workers that died from
 * those that only lost the link. */
#include <stdio.h>
#include <string.h>

#include "server/fleet/fleet_work.h"

static bool has_others(const struct fleet *fleet, const struct session *s)
{
    for (size_t i = 0; i < fleet->session_count; i++)
        if (fleet->sessions[i] != s && session_may_work(fleet->sessions[i])) return true;
    return false;
}

/* A slow worker, or one on a machine that sleeps, is better than none. */
static bool is_slowness(enum strike kind)
{
    return kind == STRIKE_SILENT || kind == STRIKE_STALLED;
}

static bool strike(struct fleet *fleet, struct session *s, enum strike kind)
{
    const uint64_t now_ms = uv_now(fleet->loop);
    if (fleet->closing) return false;
    fleet->totals.strikes[kind]++;
    if (is_slowness(kind) && !has_others(fleet, s)) return false;
    if (!worker_health_strike(&fleet->health, s->hello.name, s->local, kind, now_ms)) return false;
    fleet->totals.quarantined++;
    session_quarantine(s, now_ms + WORKER_HEALTH_QUARANTINE_MS);
    return true;
}

void fleet_struck(void *ctx, struct session *s, enum strike kind)
{
    strike(ctx, s, kind);
}

bool fleet_strike(struct fleet *fleet, uint64_t worker)
{
    struct session *s = fleet_find_session(fleet, worker);
    return s && strike(fleet, s, STRIKE_CORRUPT);
}

void fleet_forgive(struct fleet *fleet)
{
    for (size_t i = 0; i < fleet->session_count; i++) {
        struct session *s = fleet->sessions[i];
        const struct worker_health_record *record =
            worker_health_quarantine(&fleet->health, s->hello.name, s->local, uv_now(fleet->loop));
        if (!record) continue;
        worker_health_forgive(&fleet->health, s->hello.name, s->local);
        session_quarantine(s, 0);
    }
}

void fleet_note_silent(void *ctx, const struct session *s)
{
    struct fleet *fleet = ctx;
    if (s->local && fleet->processes && !fleet->closing)
        processes_end(fleet->processes, (int64_t)s->hello.pid);
}

bool fleet_note_gone(void *ctx, const struct session *s)
{
    struct fleet *fleet = ctx;
    for (unsigned i = 0; i < STOPPED_KNOWN && s->local; i++)
        if (fleet->stopped[i] > 0 && (uint64_t)fleet->stopped[i] == s->hello.pid) return false;
    struct gone *gone = &fleet->gone[fleet->gone_next++ % GONE_KNOWN];
    *gone = (struct gone){.pid = s->hello.pid, .id = s->id, .local = s->local};
    snprintf(gone->name, sizeof gone->name, "%s", s->hello.name);
    return true;
}

/* A process that died does not come back under its pid. Pids of different machines may be equal, so
 * the name must be, too. */
static bool is_same_process(const struct gone *gone, const struct session *s)
{
    return gone->id != 0 && gone->pid == s->hello.pid && gone->local == s->local &&
           (s->local || strcmp(gone->name, s->hello.name) == 0);
}

static void survived(struct fleet *fleet, struct gone *gone)
{
    const uint64_t id = gone->id;
    gone->id = 0;
    if (!fleet->closing && fleet->client.survived) fleet->client.survived(fleet->client.ctx, id);
}

void fleet_note_joined(struct fleet *fleet, const struct session *s)
{
    for (unsigned i = 0; i < GONE_KNOWN; i++) {
        struct gone *gone = &fleet->gone[i];
        if (is_same_process(gone, s)) survived(fleet, gone);
    }
}

void fleet_note_stopped(void *ctx, int64_t pid)
{
    struct fleet *fleet = ctx;
    fleet->stopped[fleet->stopped_next++ % STOPPED_KNOWN] = pid;
    for (unsigned i = 0; i < GONE_KNOWN; i++) {
        struct gone *gone = &fleet->gone[i];
        if (gone->id != 0 && gone->local && gone->pid == (uint64_t)pid) survived(fleet, gone);
    }
}
