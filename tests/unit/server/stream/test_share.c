/* How much CPU time streams may take: by a clock of the test's own. */
#include "server/stream/meter.h"
#include "server/stream/share.h"
#include "tests/unit/unit.h"

enum { PER_S = 80000, STEP_US = 25000 };

/* Events and feeds that take all they may for ten seconds; feeds when there is some, by bits. */
static void spend(bool events, bool feeds, uint64_t *events_us, uint64_t *feeds_us)
{
    struct share share;
    uint64_t now_us = 7000000;
    share_init(&share, PER_S, now_us);
    *events_us = *feeds_us = 0;
    for (int i = 0; i < 10 * 1000000 / STEP_US; i++) {
        const uint64_t e = events && share_has_for_events(&share) ? 9000 : 0;
        const uint64_t f = feeds && share_for_feeds_us(&share) > 0 ? 3000 : 0;
        now_us += STEP_US;
        share_settle(&share, now_us, e, f);
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
    struct share share;
    uint64_t events_us = 0, feeds_us = 0, now_us = 0;
    share_init(&share, PER_S, now_us);
    for (int i = 0; i < 60 * 1000000 / STEP_US; i++) {
        const uint64_t e = share_has_for_events(&share) ? 200000 : 0;
        const uint64_t f = share_for_feeds_us(&share) > 0 ? 3000 : 0;
        now_us += STEP_US;
        share_settle(&share, now_us, e, f);
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
    struct share share;
    share_init(&share, PER_S, 0);
    share_settle(&share, 1000, 50 * PER_S, 50 * PER_S);
    assert_false(share_has_for_events(&share));
    assert_true(share_for_feeds_us(&share) < 0);
    for (uint64_t s = 1; s <= 15; s++) share_settle(&share, 1000 + s * 1000000, 0, 0);
    assert_false(share_has_for_events(&share));
    assert_true(share_for_feeds_us(&share) < 0);
    share_settle(&share, 16101000, 0, 0);
    share_settle(&share, 17001000, 0, 0);
    assert_true(share_has_for_events(&share));
    assert_true(share_for_feeds_us(&share) > 0);
    /* Nor is much saved in an hour. */
    share_settle(&share, 3600000000u, 0, 0);
    assert_in_range(share_for_feeds_us(&share), 1, PER_S / 4);
}

TEST(without_limit_there_is_none)
{
    struct share share;
    share_init(&share, 0, 0);
    share_settle(&share, 1000, 5000000, 5000000);
    assert_true(share_has_for_events(&share));
    assert_true(share_for_feeds_us(&share) == INT64_MAX);
}

static volatile unsigned burnt;

static void burn(struct meter *meter, enum meter_kind kind, uint64_t us)
{
    for (const uint64_t end = meter_us(meter, kind) + us; meter_us(meter, kind) < end;)
        for (int i = 0; i < 1000; i++) burnt++;
}

TEST(time_is_who_holds_the_thread)
{
    struct meter meter = {0};
    assert_int_equal(meter_switch(&meter, METER_EVENTS), METER_NOBODY);
    burn(&meter, METER_EVENTS, 3000);
    assert_int_equal(meter_switch(&meter, METER_PIXELS), METER_EVENTS);
    const uint64_t events_us = meter_us(&meter, METER_EVENTS);
    burn(&meter, METER_PIXELS, 5000);
    assert_int_equal(meter_switch(&meter, METER_NOBODY), METER_PIXELS);
    const uint64_t pixels_us = meter_us(&meter, METER_PIXELS);
    for (int i = 0; i < 2000000; i++) burnt++; /* nobody's */
    assert_int_equal(meter_switch(&meter, METER_OTHER), METER_NOBODY);
    assert_in_range(events_us, 3000, 4500);
    assert_in_range(pixels_us, 5000, 6500);
    assert_int_equal(meter_us(&meter, METER_EVENTS), events_us);
    assert_int_equal(meter_us(&meter, METER_PIXELS), pixels_us);
    assert_int_equal(meter_us(&meter, METER_NOBODY), 0);
}
