#pragma once
/* Strikes of workers. Three strikes within ten minutes put a worker into quarantine for ten
 * minutes. It gets no tiles then, but stays connected, so that an operator sees it and may take it
 * back.
 *
 * A strike is a result that does not fit its plan, a message that breaks the protocol, silence
 * while tiles are held, or tiles without progress. The end of a link is no strike, since machines
 * are switched off.
 *
 * Workers are known by name and by whether they are local, since a link's id ends with the link.
 * This is pure data; the clock is the caller's. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/limits.h"

#define WORKER_HEALTH_STRIKES       3
#define WORKER_HEALTH_WINDOW_MS     600000u /* strikes older than this are forgotten */
#define WORKER_HEALTH_QUARANTINE_MS 600000u
/* Workers with strikes; of more, the one whose last strike is oldest is forgotten. */
#define WORKER_HEALTH_KNOWN 256

enum strike { STRIKE_CORRUPT, STRIKE_PROTOCOL, STRIKE_SILENT, STRIKE_STALLED, STRIKE_COUNT };

/* Returns the strike in words: "sent results that do not fit their plan". */
const char *strike_text(enum strike kind);
/* Returns the strike's name in metrics: "corrupt". */
const char *strike_name(enum strike kind);

struct worker_health_record {
    char name[LIMIT_NAME_BYTES];
    bool local, is_used;
    uint64_t struck_ms[WORKER_HEALTH_STRIKES]; /* the last ones, newest first; 0: none */
    uint64_t until_ms;                         /* of the quarantine; 0: there is none */
    enum strike last;
};

/* It has no strikes when zero-initialised. */
struct worker_health {
    struct worker_health_record records[WORKER_HEALTH_KNOWN];
};

/* Counts a strike. Returns true when it begins a quarantine. now_ms is above 0 and never falls. */
bool worker_health_strike(struct worker_health *c, const char *name, bool local, enum strike kind,
                          uint64_t now_ms);
/* Returns the record of a worker that is in quarantine now, borrowed until the next call; else
 * NULL. */
const struct worker_health_record *worker_health_quarantine(const struct worker_health *c,
                                                            const char *name, bool local,
                                                            uint64_t now_ms);
/* Forgets the worker's strikes and ends its quarantine. */
void worker_health_forgive(struct worker_health *c, const char *name, bool local);
