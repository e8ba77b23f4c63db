/* Jobs that come to a store: keys, owners, traces, commits that many share. */
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "tests/unit/server/store/job_store_fixture.h"
#include "tests/unit/unit.h"

EACH_TEST(setup, teardown);

TEST(keys_make_submission_idempotent)
{
    struct fixture *f = *state;
    struct insertion i;
    assert_int_equal(insert(f, 1, "key", "body", &i), 0);
    assert_int_equal(insert(f, 2, "key", "body", &i), ERR_EXISTS);
    assert_string_equal(i.existing, make_row(1).id);
    assert_int_equal(insert(f, 3, "key", "other", &i), ERR_MISMATCH);
    assert_string_equal(i.existing, "");
    assert_int_equal(insert(f, 4, "another", "body", &i), 0);
    assert_false(get(f, make_row(2).id).there);
    assert_false(get(f, make_row(3).id).there);
    assert_int_equal(insert(f, 1, NULL, "body", &i), ERR_STATE); /* an id twice */
}

TEST(a_key_counts_within_one_commit)
{
    struct fixture *f = *state;
    struct insertion first = {0}, second = {0};
    struct job_row a = make_row(1), b = make_row(2);
    struct digest body;
    digest_of("b", 1, &body);
    job_store_insert(f->store, &a, "k", &body, on_inserted, &first);
    job_store_insert(f->store, &b, "k", &body, on_inserted, &second);
    settle(f);
    assert_int_equal(first.error, 0);
    assert_int_equal(second.error, ERR_EXISTS);
    assert_string_equal(second.existing, a.id);
}

#define MANY 2000

TEST(many_submissions_share_commits)
{
    struct fixture *f = *state;
    static struct insertion results[MANY];
    struct timespec a, b;
    struct digest body = {0};
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (int i = 0; i < MANY; i++) {
        struct job_row row = make_row(i);
        results[i] = (struct insertion){0};
        job_store_insert(f->store, &row, NULL, &body, on_inserted, &results[i]);
    }
    settle(f);
    clock_gettime(CLOCK_MONOTONIC, &b);
    for (int i = 0; i < MANY; i++) {
        assert_int_equal(results[i].calls, 1);
        assert_int_equal(results[i].error, 0);
    }
    double seconds = (double)(b.tv_sec - a.tv_sec) + (double)(b.tv_nsec - a.tv_nsec) * 1e-9;
    print_message("# %.0f durable submissions a second\n", MANY / seconds);
}

TEST(closing_finishes_what_is_queued)
{
    struct fixture *f = *state;
    static struct insertion results[600];
    struct digest body = {0};
    for (int i = 0; i < 600; i++) {
        struct job_row row = make_row(i);
        results[i] = (struct insertion){0};
        job_store_insert(f->store, &row, NULL, &body, on_inserted, &results[i]);
    }
    close_store(f);
    for (int i = 0; i < 600; i++) assert_int_equal(results[i].calls, 1);
    assert_int_equal(open_store(f), 0);
    assert_true(get(f, make_row(599).id).there);
}

TEST(a_trace_is_kept)
{
    struct fixture *f = *state;
    struct insertion i = {.error = 1};
    struct job_row row = make_row(1);
    strcpy(row.trace, "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01-a0f067aa0ba902b7");
    job_store_insert(f->store, &row, NULL, NULL, on_inserted, &i);
    settle(f);
    assert_int_equal(i.error, 0);
    close_store(f);
    assert_int_equal(open_store(f), 0);
    assert_string_equal(get(f, first_id).row.trace, row.trace);
}

static int insert_owned(struct fixture *f, int number, const char *owner, const char *key,
                        struct insertion *out)
{
    struct job_row row = make_row(number);
    struct digest digest = {{1}};
    *out = (struct insertion){.error = 1};
    snprintf(row.owner, sizeof row.owner, "%s", owner);
    job_store_insert(f->store, &row, key, &digest, on_inserted, out);
    settle(f);
    return out->error;
}

/* How many jobs of an owner a listing has; all of them must be his. */
static void count_owned(void *ctx, int error, const struct job_row *rows, size_t count, bool more)
{
    int *out = ctx;
    assert_int_equal(error, 0);
    assert_false(more);
    *out = (int)count;
    for (size_t i = 1; i < count; i++) assert_string_equal(rows[i].owner, rows[0].owner);
}

static int owned(struct fixture *f, const char *owner, const char *state, const char *text)
{
    int count = -1;
    const struct job_listing listing = {.owner = owner, .state = state, .text = text, .limit = 50};
    job_store_list(f->store, &listing, count_owned, &count);
    settle(f);
    return count;
}

TEST(owners_have_jobs_and_keys_of_their_own)
{
    struct fixture *f = *state;
    struct insertion i;
    assert_int_equal(insert_owned(f, 1, "a", "key", &i), 0);
    assert_int_equal(insert_owned(f, 2, "b", "key", &i), 0);
    assert_int_equal(insert_owned(f, 3, "b", "key", &i), ERR_EXISTS);
    assert_string_equal(i.existing, "01JOB000000000000000000002");
    assert_int_equal(insert_owned(f, 4, "", "key", &i), 0);
    assert_int_equal(insert_owned(f, 5, "b", NULL, &i), 0);
    assert_string_equal(get(f, first_id).row.owner, "a");
    assert_int_equal(owned(f, "a", NULL, NULL), 1);
    assert_int_equal(owned(f, "b", NULL, NULL), 2);
    assert_int_equal(owned(f, "b", "queued", NULL), 2);
    assert_int_equal(owned(f, "b", "running", NULL), 0);
    assert_int_equal(owned(f, "b", NULL, "scene"), 2);
    assert_int_equal(owned(f, "b", "queued", "0000001"), 0);
    assert_int_equal(owned(f, "", NULL, NULL), 1);
    assert_int_equal(owned(f, "c", NULL, NULL), 0);
}
