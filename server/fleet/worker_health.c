#include "server/fleet/worker_health.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *name, *text;
} strikes[STRIKE_COUNT] = {
    [STRIKE_CORRUPT] = {"corrupt", "sent results that do not fit their plan"},
    [STRIKE_PROTOCOL] = {"protocol", "sent messages that break the protocol"},
    [STRIKE_SILENT] = {"silent", "fell silent while it held tiles"},
    [STRIKE_STALLED] = {"stalled", "made no progress with the tiles that it held"},
};

const char *strike_text(enum strike kind)
{
    return strikes[kind].text;
}

const char *strike_name(enum strike kind)
{
    return strikes[kind].name;
}

static bool is_of(const struct worker_health_record *r, const char *name, bool local)
{
    return r->is_used && r->local == local && strcmp(r->name, name) == 0;
}

static const struct worker_health_record *find(const struct worker_health *c, const char *name,
                                               bool local)
{
    for (size_t i = 0; i < WORKER_HEALTH_KNOWN; i++)
        if (is_of(&c->records[i], name, local)) return &c->records[i];
    return NULL;
}

/* Returns the record to overwrite: an unused one, else the one with the oldest last strike. Workers
 * in quarantine were struck lately, so only a flood of names reaches them. */
static struct worker_health_record *oldest(struct worker_health *c)
{
    struct worker_health_record *found = &c->records[0];
    for (size_t i = 0; i < WORKER_HEALTH_KNOWN; i++)
        if (c->records[i].struck_ms[0] < found->struck_ms[0]) found = &c->records[i];
    return found;
}

static struct worker_health_record *record_of(struct worker_health *c, const char *name, bool local)
{
    for (size_t i = 0; i < WORKER_HEALTH_KNOWN; i++)
        if (is_of(&c->records[i], name, local)) return &c->records[i];
    struct worker_health_record *r = oldest(c);
    *r = (struct worker_health_record){.local = local, .is_used = true};
    snprintf(r->name, sizeof r->name, "%s", name);
    return r;
}

bool worker_health_strike(struct worker_health *c, const char *name, bool local, enum strike kind,
                          uint64_t now_ms)
{
    struct worker_health_record *r = record_of(c, name, local);
    memmove(&r->struck_ms[1], &r->struck_ms[0], sizeof r->struck_ms - sizeof r->struck_ms[0]);
    r->struck_ms[0] = now_ms;
    r->last = kind;
    if (r->until_ms > now_ms) return false;
    const uint64_t first_ms = r->struck_ms[WORKER_HEALTH_STRIKES - 1];
    if (first_ms == 0 || now_ms - first_ms > WORKER_HEALTH_WINDOW_MS) return false;
    r->until_ms = now_ms + WORKER_HEALTH_QUARANTINE_MS;
    memset(r->struck_ms + 1, 0, sizeof r->struck_ms - sizeof r->struck_ms[0]);
    return true;
}

const struct worker_health_record *worker_health_quarantine(const struct worker_health *c,
                                                            const char *name, bool local,
                                                            uint64_t now_ms)
{
    const struct worker_health_record *r = find(c, name, local);
    return r && r->until_ms > now_ms ? r : NULL;
}

void worker_health_forgive(struct worker_health *c, const char *name, bool local)
{
    for (size_t i = 0; i < WORKER_HEALTH_KNOWN; i++)
        if (is_of(&c->records[i], name, local)) c->records[i] = (struct worker_health_record){0};
}
