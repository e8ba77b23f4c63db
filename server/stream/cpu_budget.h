#pragma once
/* The CPU time that streams may take: a fixed number of microseconds of each second, whatever their
 * readers cost on this machine.
 *
 * Time flows in by the clock and out by what was spent (cpu_meter.h). Half of it belongs to events.
 * Progress and tile events wait while events owe time, and feeds never hold them up. Feeds get all
 * that events leave, and the other half in any case. Changes of state bypass the budget; their cost
 * is charged afterwards. Unused time adds up to a quarter of a second's, debt to that of sixteen
 * seconds: a round of progress that costs more than that still goes out as often. */
#include <stdbool.h>
#include <stdint.h>

struct cpu_budget {
    int64_t us_per_s;            /* 0: no limit */
    int64_t all_us;              /* available now; below 0: owed */
    int64_t events_us, feeds_us; /* of each one's half */
    uint64_t at_us;              /* time of the last settlement */
};

void cpu_budget_init(struct cpu_budget *budget, int64_t us_per_s, uint64_t now_us);

/* Charges what was spent since the last call. */
void cpu_budget_settle(struct cpu_budget *budget, uint64_t now_us, uint64_t events_us,
                       uint64_t pixels_us);

/* Returns whether events that can wait may go out. */
bool cpu_budget_has_for_events(const struct cpu_budget *budget);

/* Returns what feeds may take until the next settlement; INT64_MAX: no limit. */
int64_t cpu_budget_for_feeds_us(const struct cpu_budget *budget);
