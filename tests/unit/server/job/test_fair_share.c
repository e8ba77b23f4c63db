/* Whose turn it is: shares of a long run, who comes late, who goes away, who cannot be served. */
#include <stdlib.h>
#include <string.h>

#include "server/job/fair_share.h"
#include "tests/unit/unit.h"

/* Serves whoever is next with tiles of his own size, `samples` in all; what each got. */
static void serve(struct fair_share *share, struct fair_tenant *const tenants[], unsigned count,
                  const uint64_t tile[], uint64_t samples, uint64_t got[])
{
    for (uint64_t given = 0; given < samples;) {
        const struct fair_tenant *next = fair_share_next(share, 0);
        unsigned i = 0;
        while (i < count && tenants[i] != next) i++;
        assert_in_range(i, 0, count - 1);
        fair_share_charge(share, tenants[i], tile[i]);
        got[i] += tile[i];
        given += tile[i];
    }
}

TEST(shares_are_equal_whatever_the_tiles)
{
    struct fair_share share = {0};
    struct fair_tenant *t[3] = {fair_share_join(&share, "a", 0), fair_share_join(&share, "b", 0),
                                fair_share_join(&share, "c", 0)};
    const uint64_t tile[3] = {1000, 64000, 7};
    uint64_t got[3] = {0};
    serve(&share, t, 3, tile, 30000000, got);
    for (unsigned i = 0; i < 3; i++) assert_in_range(got[i], 10000000 - 64000, 10000000 + 64000);
    assert_int_equal(fair_share_count(&share, 0), 3);
    fair_share_fini(&share);
}

TEST(many_jobs_are_one_share)
{
    struct fair_share share = {0};
    struct fair_tenant *t[2] = {NULL, fair_share_join(&share, "b", 0)};
    for (int i = 0; i < 100; i++) t[0] = fair_share_join(&share, "a", 0);
    const uint64_t tile[2] = {10, 10};
    uint64_t got[2] = {0};
    serve(&share, t, 2, tile, 20000, got);
    assert_int_equal(got[0], 10000);
    assert_int_equal(got[1], 10000);
    fair_share_fini(&share);
}

TEST(time_away_earns_nothing)
{
    struct fair_share share = {0};
    struct fair_tenant *t[2] = {fair_share_join(&share, "a", 0), NULL};
    const uint64_t tile[2] = {10, 10};
    uint64_t got[2] = {0};
    serve(&share, t, 1, tile, 1000000, got);
    t[1] = fair_share_join(&share, "b", 0);
    memset(got, 0, sizeof got);
    serve(&share, t, 2, tile, 2000, got);
    assert_in_range(got[1], 990, 1010);
    fair_share_fini(&share);
}

/* Leaving and coming back does not wipe out what one had beyond the others. */
TEST(who_comes_back_is_remembered)
{
    struct fair_share share = {0};
    struct fair_tenant *a = fair_share_join(&share, "a", 0), *b = fair_share_join(&share, "b", 0);
    fair_share_charge(&share, a, 500);
    fair_share_leave(&share, a);
    assert_ptr_equal(fair_share_join(&share, "a", 0), a);
    assert_ptr_equal(fair_share_next(&share, 0), b);
    assert_int_equal(fair_share_rank(&share, a), 1);
    fair_share_charge(&share, b, 501);
    assert_ptr_equal(fair_share_next(&share, 0), a);
    fair_share_fini(&share);
}

TEST(an_empty_line_begins_anew)
{
    struct fair_share share = {0};
    struct fair_tenant *a = fair_share_join(&share, "a", 0);
    fair_share_charge(&share, a, 1u << 20);
    fair_share_leave(&share, a);
    assert_null(share.first);
    a = fair_share_join(&share, "a", 0);
    struct fair_tenant *b = fair_share_join(&share, "b", 0);
    assert_false(fair_tenant_before(b, a));
    fair_share_fini(&share);
}

TEST(what_could_not_be_served_is_owed_within_bounds)
{
    struct fair_share share = {0};
    struct fair_tenant *a = fair_share_join(&share, "a", 0), *b = fair_share_join(&share, "b", 0);
    fair_share_charge(&share, a, FAIR_SHARE_CREDIT / 2);
    fair_share_charge(&share, a, 1);
    assert_int_equal(b->served, 0);
    for (int i = 0; i < 10; i++) fair_share_charge(&share, a, FAIR_SHARE_CREDIT);
    assert_true(a->served - b->served <= 2 * FAIR_SHARE_CREDIT);
    fair_share_fini(&share);
}

TEST(priorities_are_apart)
{
    struct fair_share share = {0};
    struct fair_tenant *low = fair_share_join(&share, "a", 0);
    struct fair_tenant *high = fair_share_join(&share, "a", 1);
    assert_ptr_not_equal(low, high);
    fair_share_charge(&share, high, 1000);
    struct fair_tenant *other = fair_share_join(&share, "b", 0);
    assert_int_equal(other->served, low->served);
    assert_int_equal(fair_share_count(&share, 1), 1);
    assert_ptr_equal(fair_share_next(&share, 1), high);
    assert_null(fair_share_next(&share, 2));
    fair_share_fini(&share);
}

static uint64_t served_of(struct fair_tenant *t[2], struct fair_share *share, int turns)
{
    uint64_t of_first = 0;
    for (int i = 0; i < turns; i++) {
        struct fair_tenant *next = fair_tenant_before(t[0], t[1]) ? t[0] : t[1];
        fair_share_charge(share, next, 1001); /* no multiple of the weight */
        of_first += next == t[0];
    }
    return of_first;
}

static struct fair_weights *weights_of(const char *owner, uint32_t weight)
{
    struct fair_weights *w = calloc(1, sizeof *w + sizeof w->list[0]);
    assert_non_null(w);
    w->count = 1;
    strcpy(w->list[0].owner, owner);
    w->list[0].weight = weight;
    return w;
}

TEST(weights_are_shares_of_a_long_run)
{
    struct fair_share share = {0};
    fair_share_weigh(&share, weights_of("a", 2));
    struct fair_tenant *t[2] = {fair_share_join(&share, "a", 0), fair_share_join(&share, "b", 0)};
    assert_in_range(served_of(t, &share, 3000), 1999, 2001);
    assert_in_range(t[0]->served, t[1]->served - 1001, t[1]->served + 1001); /* no sample is lost */
    /* The file is read again: from now on otherwise. */
    fair_share_weigh(&share, weights_of("b", 3));
    assert_in_range(served_of(t, &share, 4000), 998, 1002);
    fair_share_weigh(&share, NULL);
    assert_in_range(served_of(t, &share, 4000), 1998, 2002);
    fair_share_fini(&share);
}
