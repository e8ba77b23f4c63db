/* How much CPU time streams may take: by a clock of the test's own. */
#include "server/stream/cpu_budget.h"
#include "server/stream/cpu_meter.h"
#include "tests/unit/unit.h"

enum { PER_S = 80000, STEP_US = 25000 };

/* Events and feeds that take all they may for ten seconds; feeds when there is some, by bits. */
static void spend(bool events, bool feeds, uint64_t *events_us, uint64_t *feeds_us)
{
    struct cpu_budget budget;
    uint64_t now_us = 7000000;
    cpu_budget_init(&budget, PER_S, now_us);
    *events_us = *feeds_us = 0;
    for (int i = 0; i < 10 * 1000000 / STEP_US; i++) {
        const uint64_t e = events && cpu_budget_has_for_events(&budget) ? 9000 : 0;
        const uint64_t f = feeds && cpu_budget_for_feeds_us(&budget) > 0 ? 3000 : 0;
        now_us += STEP_US;
        cpu_budget_settle(&budget, now_us, e, f);
        *events_us += e;
        *feeds_us += f;
    }
}

TEST(feeds_alone_get_all_of_it)
{
    uint64_t events_us, feeds_us;
    spend(false, true, &events_us, &feeds_us);
    assert_in_range(feeds_us, 10 * PER_S * 97 / 100, 10 * PER_S + PER_S / 4 + 3000);
}

TEST(events_get_half_of_it)
{
    uint64_t events_us, feeds_us;
    spend(true, false, &events_us, &feeds_us);
    assert_in_range(events_us, 5 * PER_S * 97 / 100, 5 * PER_S + PER_S / 8 + 9000);
}

TEST(neither_starves_the_other)
{
    uint64_t events_us, feeds_us;
    spend(true, true, &events_us, &feeds_us);
    assert_in_range(events_us, 5 * PER_S * 97 / 100, 5 * PER_S + PER_S / 8 + 9000);
    assert_in_range(feeds_us, 5 * PER_S * 90 / 100, 5 * PER_S + PER_S / 4 + 3000);
    assert_true(events_us + feeds_us <= 10 * PER_S + PER_S / 4 + 12000);
}

/* A crowd whose round of progress costs more than a second's time of events waits longer, and feeds
 * have their half meanwhile. */
TEST(dear_rounds_are_rare)
{
    struct cpu_budget budget;
    uint64_t events_us = 0, feeds_us = 0, now_us = 0;
    cpu_budget_init(&budget, PER_S, now_us);
    for (int i = 0; i < 60 * 1000000 / STEP_US; i++) {
        const uint64_t e = cpu_budget_has_for_events(&budget) ? 200000 : 0;
        const uint64_t f = cpu_budget_for_feeds_us(&budget) > 0 ? 3000 : 0;
        now_us += STEP_US;
        cpu_budget_settle(&budget, now_us, e, f);
        events_us += e;
        feeds_us += f;
    }
    assert_in_range(events_us, 60 * PER_S / 2 - 200000, 60 * PER_S / 2 + 2 * 200000);
    assert_in_range(feeds_us, 60 * PER_S / 2 * 97 / 100, 60 * PER_S / 2 + 200000);
}

/* What had to go out is owed, but for no longer than sixteen seconds, and by feeds as long as it is
 * theirs. */
TEST(debts_end)
{
    struct cpu_budget budget;
    cpu_budget_init(&budget, PER_S, 0);
    cpu_budget_settle(&budget, 1000, 50 * PER_S, 50 * PER_S);
    assert_false(cpu_budget_has_for_events(&budget));
    assert_true(cpu_budget_for_feeds_us(&budget) < 0);
    for (uint64_t s = 1; s <= 15; s++) cpu_budget_settle(&budget, 1000 + s * 1000000, 0, 0);
    assert_false(cpu_budget_has_for_events(&budget));
    assert_true(cpu_budget_for_feeds_us(&budget) < 0);
    cpu_budget_settle(&budget, 16101000, 0, 0);
    cpu_budget_settle(&budget, 17001000, 0, 0);
    assert_true(cpu_budget_has_for_events(&budget));
    assert_true(cpu_budget_for_feeds_us(&budget) > 0);
    /* Nor is much saved in an hour. */
    cpu_budget_settle(&budget, 3600000000u, 0, 0);
    assert_in_range(cpu_budget_for_feeds_us(&budget), 1, PER_S / 4);
}

TEST(without_limit_there_is_none)
{
    struct cpu_budget budget;
    cpu_budget_init(&budget, 0, 0);
    cpu_budget_settle(&budget, 1000, 5000000, 5000000);
    assert_true(cpu_budget_has_for_events(&budget));
    assert_true(cpu_budget_for_feeds_us(&budget) == INT64_MAX);
}

static volatile unsigned burnt;

static void burn(struct cpu_meter *meter, enum cpu_meter_kind kind, uint64_t us)
{
    for (const uint64_t end = cpu_meter_us(meter, kind) + us; cpu_meter_us(meter, kind) < end;)
        for (int i = 0; i < 1000; i++) burnt++;
}

TEST(time_is_who_holds_the_thread)
{
    struct cpu_meter meter = {0};
    assert_int_equal(cpu_meter_switch(&meter, CPU_METER_EVENTS), CPU_METER_NONE);
    burn(&meter, CPU_METER_EVENTS, 3000);
    assert_int_equal(cpu_meter_switch(&meter, CPU_METER_PIXELS), CPU_METER_EVENTS);
    const uint64_t events_us = cpu_meter_us(&meter, CPU_METER_EVENTS);
    burn(&meter, CPU_METER_PIXELS, 5000);
    assert_int_equal(cpu_meter_switch(&meter, CPU_METER_NONE), CPU_METER_PIXELS);
    const uint64_t pixels_us = cpu_meter_us(&meter, CPU_METER_PIXELS);
    for (int i = 0; i < 2000000; i++) burnt++; /* nobody's */
    assert_int_equal(cpu_meter_switch(&meter, CPU_METER_OTHER), CPU_METER_NONE);
    assert_in_range(events_us, 3000, 4500);
    assert_in_range(pixels_us, 5000, 6500);
    assert_int_equal(cpu_meter_us(&meter, CPU_METER_EVENTS), events_us);
    assert_int_equal(cpu_meter_us(&meter, CPU_METER_PIXELS), pixels_us);
    assert_int_equal(cpu_meter_us(&meter, CPU_METER_NONE), 0);
}
