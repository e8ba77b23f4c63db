
#include <stdio.h>
#include <stdlib.h>

#include "server/fleet/conduct.h"
#include "tests/unit/unit.h"

static struct conduct *make(void)
{
    struct conduct *c = calloc(1, sizeof *c);
    assert_non_null(c);
    return c;
}

TEST(the_third_strike_is_the_one)
{
    struct conduct *c = make();
    assert_false(conduct_strike(c, "a", true, STRIKE_CORRUPT, 1000));
    assert_false(conduct_strike(c, "b", true, STRIKE_CORRUPT, 1000));
    assert_false(conduct_strike(c, "a", false, STRIKE_CORRUPT, 1000)); /* another of that name */
    assert_false(conduct_strike(c, "a", true, STRIKE_PROTOCOL, 1001));
    assert_null(conduct_quarantine(c, "a", true, 1001));
    assert_true(conduct_strike(c, "a", true, STRIKE_STALLED, 1002));
    const struct conduct_record *r = conduct_quarantine(c, "a", true, 1003);
    assert_non_null(r);
    assert_int_equal(r->last, STRIKE_STALLED);
    assert_int_equal(r->until_ms, 1002 + CONDUCT_QUARANTINE_MS);
    assert_null(conduct_quarantine(c, "a", false, 1003));
    assert_null(conduct_quarantine(c, "b", true, 1003));
    free(c);
}

TEST(strikes_are_forgotten)
{
    struct conduct *c = make();
    assert_false(conduct_strike(c, "a", true, STRIKE_SILENT, 1));
    assert_false(conduct_strike(c, "a", true, STRIKE_SILENT, 2));
    assert_false(conduct_strike(c, "a", true, STRIKE_SILENT, 2 + CONDUCT_WINDOW_MS));
    assert_true(conduct_strike(c, "a", true, STRIKE_SILENT, 2 + CONDUCT_WINDOW_MS));
    free(c);
}

TEST(a_quarantine_ends)
{
    struct conduct *c = make();
    for (uint64_t i = 1; i <= CONDUCT_STRIKES; i++)
        assert_int_equal(conduct_strike(c, "a", true, STRIKE_CORRUPT, i), i == CONDUCT_STRIKES);
    const uint64_t until_ms = CONDUCT_STRIKES + CONDUCT_QUARANTINE_MS;
    assert_false(conduct_strike(c, "a", true, STRIKE_CORRUPT, until_ms - 1)); /* it is in one */
    assert_non_null(conduct_quarantine(c, "a", true, until_ms - 1));
    assert_null(conduct_quarantine(c, "a", true, until_ms));
    free(c);
}

TEST(who_is_forgiven_starts_anew)
{
    struct conduct *c = make();
    for (uint64_t i = 1; i <= CONDUCT_STRIKES; i++) conduct_strike(c, "a", true, STRIKE_CORRUPT, i);
    conduct_forgive(c, "a", true);
    assert_null(conduct_quarantine(c, "a", true, 10));
    assert_false(conduct_strike(c, "a", true, STRIKE_CORRUPT, 11));
    conduct_forgive(c, "nobody", true);
    free(c);
}

/* A flood of names cannot make it grow, and forgets the oldest. */
TEST(a_flood_of_names)
{
    struct conduct *c = make();
    char name[32];
    conduct_strike(c, "first", true, STRIKE_CORRUPT, 1);
    for (uint64_t i = 0; i < 3 * CONDUCT_KNOWN; i++) {
        snprintf(name, sizeof name, "worker-%llu", (unsigned long long)i);
        assert_false(conduct_strike(c, name, true, STRIKE_CORRUPT, 2 + i));
    }
    assert_false(conduct_strike(c, "first", true, STRIKE_CORRUPT, 5000));
    assert_false(
        conduct_strike(c, "first", true, STRIKE_CORRUPT, 5001)); /* the first is forgotten */
    assert_true(conduct_strike(c, "first", true, STRIKE_CORRUPT, 5002));
    free(c);
}
