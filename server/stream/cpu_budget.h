#pragma once
/* How much CPU time streams may take: so many microseconds of each second, whatever their readers
 * cost on this machine.
 *
 * Time flows in by the clock and out by what was spent (cpu_meter.h). Half of it is for events:
 * those that can wait, progress and tiles, wait while events owe; nobody's feed holds them up.
 * Feeds get all that events leave, and the other half in any case. Events that tell something new
 * go out at once, and are owed. What is not used adds up to the time of a quarter of a second, what
 * is owed to that of sixteen: a round of progress that costs more than that goes out as often. */
#include <stdbool.h>
#include <stdint.h>

struct cpu_budget {
    int64_t us_per_s;            /* 0: no limit */
    int64_t all_us;              /* may be taken now; below 0: owed */
    int64_t events_us, feeds_us; /* of the half that is theirs */
    uint64_t at_us;              /* up to when that is so */
};

void cpu_budget_init(struct cpu_budget *budget, int64_t us_per_s, uint64_t now_us);

/* Counts what was spent since the last time. */
void cpu_budget_settle(struct cpu_budget *budget, uint64_t now_us, uint64_t events_us,
                       uint64_t pixels_us);

/* May events that can wait go out? */
bool cpu_budget_has_for_events(const struct cpu_budget *budget);

/* What feeds may take until it is settled again; INT64_MAX without limit. */
int64_t cpu_budget_for_feeds_us(const struct cpu_budget *budget);
