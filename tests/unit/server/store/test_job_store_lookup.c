/* What is found in a store of jobs: jobs by id, by page, by text, those to go on with after a
 * restart; blobs by their source; keys. */
#include <stdio.h>
#include <string.h>

#include "tests/unit/server/store/job_store_fixture.h"
#include "tests/unit/unit.h"

EACH_TEST(setup, teardown);

TEST(an_unknown_job_is_no_error)
{
    struct fixture *f = *state;
    char longer[64];
    insert_plain(f, 1);
    assert_false(get(f, "nothing").there);
    snprintf(longer, sizeof longer, "%sX", make_row(1).id);
    assert_false(get(f, longer).there); /* not cut to an id that exists */
}

struct listed {
    int error;
    size_t count;
    bool more;
    char ids[128][JOB_ID_BYTES];
};

static void on_listed(void *ctx, int error, const struct job_row *rows, size_t count, bool more)
{
    struct listed *l = ctx;
    l->error = error;
    l->count = count;
    l->more = more;
    for (size_t i = 0; i < count; i++) strcpy(l->ids[i], rows[i].id);
}

static struct listed *find(struct fixture *f, const struct job_listing *listing)
{
    static struct listed l;
    l = (struct listed){.error = 1};
    job_store_list(f->store, listing, on_listed, &l);
    settle(f);
    assert_int_equal(l.error, 0);
    return &l;
}

static struct listed *list(struct fixture *f, const char *state, const char *cursor, size_t limit)
{
    return find(f, &(struct job_listing){.state = state, .cursor = cursor, .limit = limit});
}

TEST(listing_pages_from_the_newest)
{
    struct fixture *f = *state;
    for (int i = 0; i < 7; i++) insert_plain(f, i);
    job_store_update(f->store, make_row(2).id, "finished", NULL, NULL, NULL, NULL);
    job_store_update(f->store, make_row(5).id, "finished", NULL, NULL, NULL, NULL);
    struct listed *l = list(f, NULL, NULL, 3);
    assert_int_equal(l->count, 3);
    assert_true(l->more);
    assert_string_equal(l->ids[0], make_row(6).id);
    l = list(f, NULL, make_row(4).id, 4);
    assert_int_equal(l->count, 4);
    assert_false(l->more);
    assert_string_equal(l->ids[3], make_row(0).id);
    l = list(f, "finished", NULL, 10);
    assert_int_equal(l->count, 2);
    assert_string_equal(l->ids[1], make_row(2).id);
    assert_int_equal(list(f, "failed", NULL, 10)->count, 0);
}

static void insert_marked(struct fixture *f, int number, const char *name, const char *labels)
{
    struct insertion i = {.error = 1};
    struct job_row row = make_row(number);
    row.name = name;
    row.labels = labels;
    job_store_insert(f->store, &row, NULL, NULL, on_inserted, &i);
    settle(f);
    assert_int_equal(i.error, 0);
}

static struct listed *find_marked(struct fixture *f, const char *name, const char *label,
                                  const char *cursor)
{
    return find(f,
                &(struct job_listing){.name = name, .label = label, .cursor = cursor, .limit = 2});
}

TEST(listing_finds_names_and_labels)
{
    struct fixture *f = *state;
    insert_marked(f, 1, "Gulls 100%", "\na\nshot_1\n");
    insert_plain(f, 2);
    insert_marked(f, 3, "gulls again", NULL);
    insert_marked(f, 4, NULL, "\na\n");
    insert_marked(f, 5, "The GULLS", "\nshot\n");
    struct listed *l = find_marked(f, "gulls", NULL, NULL);
    assert_int_equal(l->count, 2);
    assert_true(l->more);
    assert_string_equal(l->ids[1], make_row(3).id);
    l = find_marked(f, "gulls", NULL, make_row(3).id);
    assert_int_equal(l->count, 1);
    assert_false(l->more);
    assert_string_equal(l->ids[0], make_row(1).id);
    assert_int_equal(find_marked(f, "0%", NULL, NULL)->count, 1);
    assert_int_equal(find_marked(f, "_", NULL, NULL)->count, 0);
    assert_int_equal(find_marked(f, NULL, "a", NULL)->count, 2);
    assert_int_equal(find_marked(f, NULL, "shot", NULL)->count, 1); /* whole labels alone */
    assert_int_equal(find_marked(f, "gulls", "a", NULL)->count, 1);
    job_store_remove(f->store, make_row(4).id, NULL, NULL);
    assert_int_equal(find_marked(f, NULL, "a", NULL)->count, 1);
}

static int mark(struct fixture *f, int number, const char *owner, uint64_t seen, const char *marks)
{
    int error = 1;
    job_store_mark(f->store, make_row(number).id, owner, seen, marks, on_done, &error);
    settle(f);
    return error;
}

TEST(marks_change_with_their_document)
{
    struct fixture *f = *state;
    struct job_row row = make_row(1);
    struct insertion i = {.error = 1};
    row.document = "{\"a\":0.69631064,\"name\":null,\"comment\":null,\"labels\":[]}";
    row.report = "{\"revision\":7}";
    job_store_insert(f->store, &row, NULL, NULL, on_inserted, &i);
    insert_marked(f, 2, "gulls", "\na\n");
    assert_int_equal(mark(f, 1, NULL, 0, "{\"name\":\"Gulls\",\"labels\":[\"a\",\"b c\"]}"), 0);
    const struct found one = get(f, row.id);
    assert_string_equal(one.document, "{\"a\":0.69631064,\"name\":\"Gulls\",\"comment\":null,"
                                      "\"labels\":[\"a\",\"b c\"]}");
    assert_string_equal(one.report, "{\"revision\":8}");
    assert_int_equal(find_marked(f, "gulls", "b c", NULL)->count, 1);
    assert_int_equal(find_marked(f, NULL, "a", NULL)->count, 2);
    assert_int_equal(mark(f, 1, NULL, 7, "{\"comment\":\"late\"}"), ERR_MISMATCH);
    assert_int_equal(mark(f, 1, NULL, 8, "{\"labels\":[]}"), 0);
    assert_int_equal(find_marked(f, NULL, "a", NULL)->count, 1);
    assert_int_equal(mark(f, 1, "another", 0, "{\"name\":\"Mine\"}"), ERR_NOT_FOUND);
    assert_int_equal(mark(f, 3, NULL, 0, "{\"name\":\"None\"}"), ERR_NOT_FOUND);
    assert_int_equal(mark(f, 1, NULL, 0, "{\"name\":null}"), 0);
    assert_int_equal(find_marked(f, "gulls", NULL, NULL)->count, 1);
}

static size_t count_with(struct fixture *f, const char *text, const char *state)
{
    return find(f, &(struct job_listing){.state = state, .text = text, .limit = 10})->count;
}

TEST(listing_looks_for_text)
{
    struct fixture *f = *state;
    for (int i = 0; i < 4; i++) insert_plain(f, i);
    struct insertion i = {.error = 1};
    struct job_row row = make_row(9);
    struct digest digest = {0};
    row.document = "{\"camera\":\"Nord_100%\"}";
    job_store_insert(f->store, &row, NULL, &digest, on_inserted, &i);
    settle(f);
    job_store_update(f->store, make_row(2).id, "finished", NULL, NULL, NULL, NULL);
    assert_int_equal(count_with(f, "nord", NULL), 1);
    assert_int_equal(count_with(f, "d_1", NULL), 1);
    assert_int_equal(count_with(f, "100%\"", NULL), 1);
    assert_int_equal(count_with(f, "n%d", NULL), 0); /* no wildcards */
    assert_int_equal(count_with(f, "N_rd", NULL), 0);
    assert_int_equal(count_with(f, "SCENE", NULL), 4);
    assert_int_equal(count_with(f, "scene", "finished"), 1);
    assert_int_equal(count_with(f, "nord", "finished"), 0);
    assert_int_equal(count_with(f, make_row(3).id, NULL), 1);
    struct listed *l = find(f, &(struct job_listing){.text = "scene", .limit = 3});
    assert_int_equal(l->count, 3);
    assert_true(l->more);
    assert_string_equal(l->ids[0], make_row(3).id);
}

TEST(one_text_is_looked_for_at_a_time)
{
    struct fixture *f = *state;
    static struct listed first, second, plain;
    const struct job_listing any = {.limit = 10}, text = {.text = "scene", .limit = 10};
    insert_plain(f, 1);
    first = second = plain = (struct listed){.error = 1};
    job_store_list(f->store, &text, on_listed, &first);
    job_store_list(f->store, &text, on_listed, &second);
    job_store_list(f->store, &any, on_listed, &plain);
    assert_int_equal(second.error, ERR_STATE); /* at once */
    settle(f);
    assert_int_equal(first.error, 0);
    assert_int_equal(plain.error, 0);
    assert_int_equal(find(f, &text)->error, 0); /* the next one may */
}

struct resumed {
    int count;
    char ids[8][JOB_ID_BYTES];
    size_t frames[8];
    struct job_store *store;
};

static void on_unfinished(void *ctx, const struct job_row *row, const struct frame_row *frames,
                          size_t frame_count)
{
    struct resumed *r = ctx;
    (void)frames;
    strcpy(r->ids[r->count], row->id);
    r->frames[r->count++] = frame_count;
    /* What a restart does, while others are still to be told. */
    job_store_update(r->store, row->id, "queued", NULL, NULL, NULL, NULL);
}

TEST(unfinished_jobs_are_found_oldest_first)
{
    struct fixture *f = *state;
    struct resumed r = {0};
    for (int i = 0; i < 5; i++) insert_plain(f, i);
    job_store_update(f->store, make_row(0).id, "finished", NULL, NULL, NULL, NULL);
    job_store_update(f->store, make_row(2).id, "cancelled", NULL, NULL, NULL, NULL);
    job_store_update(f->store, make_row(3).id, "failed", NULL, NULL, NULL, NULL);
    assert_int_equal(job_store_unfinished(f->store, on_unfinished, &r), ERR_STATE); /* busy */
    settle(f);
    put_frame(f, 4, 1, "rendering", false);
    close_store(f);
    assert_int_equal(open_store(f), 0);
    r = (struct resumed){.store = f->store};
    assert_int_equal(job_store_unfinished(f->store, on_unfinished, &r), 0);
    settle(f);
    assert_int_equal(r.count, 2);
    assert_string_equal(r.ids[0], make_row(1).id);
    assert_string_equal(r.ids[1], make_row(4).id);
    assert_int_equal(r.frames[1], 1);
}

static void on_blob(void *ctx, int error, const struct digest *blob)
{
    struct digest *out = ctx;
    assert_int_equal(error, 0);
    *out = blob ? *blob : (struct digest){0};
}

TEST(blobs_are_remembered)
{
    struct fixture *f = *state;
    struct digest source, blob, other, found;
    digest_of("source", 6, &source);
    digest_of("blob", 4, &blob);
    digest_of("other", 5, &other);
    job_store_find_blob(f->store, &source, on_blob, &found);
    settle(f);
    assert_true(digest_is_zero(&found));
    job_store_remember_blob(f->store, &source, &other, NULL, 0, NULL, NULL);
    job_store_remember_blob(f->store, &source, &blob, NULL, 0, NULL, NULL);
    job_store_find_blob(f->store, &source, on_blob, &found); /* in order */
    settle(f);
    assert_true(digest_equal(&found, &blob));
}

TEST(looking_for_a_key_commits_nothing)
{
    struct fixture *f = *state;
    struct job_store_totals totals;
    struct insertion found = {0};
    const struct digest body = {0};
    job_store_find_key(f->store, "", "a key", &body, on_inserted, &found);
    settle(f);
    assert_int_equal(found.calls, 1);
    job_store_totals(f->store, &totals);
    for (size_t i = 0; i <= DURATION_BUCKETS; i++) assert_int_equal(totals.commits.count[i], 0);
}
