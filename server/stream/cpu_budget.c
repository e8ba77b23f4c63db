#include "server/stream/cpu_budget.h"

#define PARTS_SAVED  4 /* of a second's time */
#define SECONDS_OWED 16

void cpu_budget_init(struct cpu_budget *budget, int64_t us_per_s, uint64_t now_us)
{
    *budget = (struct cpu_budget){.us_per_s = us_per_s, .at_us = now_us};
    budget->all_us = us_per_s / PARTS_SAVED;
    budget->events_us = budget->feeds_us = us_per_s / 2 / PARTS_SAVED;
}

static int64_t settled(int64_t now_us, int64_t us_per_s, uint64_t passed_us, uint64_t spent_us)
{
    const int64_t most_us = us_per_s / PARTS_SAVED, least_us = -SECONDS_OWED * us_per_s;
    const int64_t next_us = now_us + us_per_s * (int64_t)passed_us / 1000000 - (int64_t)spent_us;
    return next_us > most_us ? most_us : next_us < least_us ? least_us : next_us;
}

void cpu_budget_settle(struct cpu_budget *budget, uint64_t now_us, uint64_t events_us,
                       uint64_t pixels_us)
{
    uint64_t passed_us = now_us - budget->at_us;
    if (passed_us > 1000000) passed_us = 1000000;
    budget->at_us = now_us;
    budget->all_us = settled(budget->all_us, budget->us_per_s, passed_us, events_us + pixels_us);
    budget->events_us = settled(budget->events_us, budget->us_per_s / 2, passed_us, events_us);
    budget->feeds_us = settled(budget->feeds_us, budget->us_per_s / 2, passed_us, pixels_us);
}

bool cpu_budget_has_for_events(const struct cpu_budget *budget)
{
    return budget->us_per_s == 0 || budget->events_us > 0;
}

int64_t cpu_budget_for_feeds_us(const struct cpu_budget *budget)
{
    if (budget->us_per_s == 0) return INT64_MAX;
    return budget->all_us > budget->feeds_us ? budget->all_us : budget->feeds_us;
}
