
#include <stdio.h>
#include <stdlib.h>

#include "server/fleet/worker_health.h"
#include "tests/unit/unit.h"

static struct worker_health *make(void)
{
    struct worker_health *c = calloc(1, sizeof *c);
    assert_non_null(c);
    return c;
}

TEST(the_third_strike_is_the_one)
{
    struct worker_health *c = make();
    assert_false(worker_health_strike(c, "a", true, STRIKE_CORRUPT, 1000));
    assert_false(worker_health_strike(c, "b", true, STRIKE_CORRUPT, 1000));
    assert_false(
        worker_health_strike(c, "a", false, STRIKE_CORRUPT, 1000)); /* another of that name */
    assert_false(worker_health_strike(c, "a", true, STRIKE_PROTOCOL, 1001));
    assert_null(worker_health_quarantine(c, "a", true, 1001));
    assert_true(worker_health_strike(c, "a", true, STRIKE_STALLED, 1002));
    const struct worker_health_record *r = worker_health_quarantine(c, "a", true, 1003);
    assert_non_null(r);
    assert_int_equal(r->last, STRIKE_STALLED);
    assert_int_equal(r->until_ms, 1002 + WORKER_HEALTH_QUARANTINE_MS);
    assert_null(worker_health_quarantine(c, "a", false, 1003));
    assert_null(worker_health_quarantine(c, "b", true, 1003));
    free(c);
}

TEST(strikes_are_forgotten)
{
    struct worker_health *c = make();
    assert_false(worker_health_strike(c, "a", true, STRIKE_SILENT, 1));
    assert_false(worker_health_strike(c, "a", true, STRIKE_SILENT, 2));
    assert_false(worker_health_strike(c, "a", true, STRIKE_SILENT, 2 + WORKER_HEALTH_WINDOW_MS));
    assert_true(worker_health_strike(c, "a", true, STRIKE_SILENT, 2 + WORKER_HEALTH_WINDOW_MS));
    free(c);
}

TEST(a_quarantine_ends)
{
    struct worker_health *c = make();
    for (uint64_t i = 1; i <= WORKER_HEALTH_STRIKES; i++)
        assert_int_equal(worker_health_strike(c, "a", true, STRIKE_CORRUPT, i),
                         i == WORKER_HEALTH_STRIKES);
    const uint64_t until_ms = WORKER_HEALTH_STRIKES + WORKER_HEALTH_QUARANTINE_MS;
    assert_false(
        worker_health_strike(c, "a", true, STRIKE_CORRUPT, until_ms - 1)); /* it is in one */
    assert_non_null(worker_health_quarantine(c, "a", true, until_ms - 1));
    assert_null(worker_health_quarantine(c, "a", true, until_ms));
    free(c);
}

TEST(who_is_forgiven_starts_anew)
{
    struct worker_health *c = make();
    for (uint64_t i = 1; i <= WORKER_HEALTH_STRIKES; i++)
        worker_health_strike(c, "a", true, STRIKE_CORRUPT, i);
    worker_health_forgive(c, "a", true);
    assert_null(worker_health_quarantine(c, "a", true, 10));
    assert_false(worker_health_strike(c, "a", true, STRIKE_CORRUPT, 11));
    worker_health_forgive(c, "nobody", true);
    free(c);
}

/* A flood of names cannot make it grow, and forgets the oldest. */
TEST(a_flood_of_names)
{
    struct worker_health *c = make();
    char name[32];
    worker_health_strike(c, "first", true, STRIKE_CORRUPT, 1);
    for (uint64_t i = 0; i < 3 * WORKER_HEALTH_KNOWN; i++) {
        snprintf(name, sizeof name, "worker-%llu", (unsigned long long)i);
        assert_false(worker_health_strike(c, name, true, STRIKE_CORRUPT, 2 + i));
    }
    assert_false(worker_health_strike(c, "first", true, STRIKE_CORRUPT, 5000));
    assert_false(
        worker_health_strike(c, "first", true, STRIKE_CORRUPT, 5001)); /* the first is forgotten */
    assert_true(worker_health_strike(c, "first", true, STRIKE_CORRUPT, 5002));
    free(c);
}
