/* Jobs on disk: what was answered is there after a restart, keys, listing, cascades, grouping. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "server/store/job_store.h"
#include "server/store/objects.h"

struct fixture {
    char dir[64];
    uv_loop_t loop;
    struct job_store *store;
};

static int open_store(struct fixture *f)
{
    return job_store_open(&f->loop, f->dir, &f->store);
}

static void close_store(struct fixture *f)
{
    job_store_close(&f->store);
    uv_run(&f->loop, UV_RUN_DEFAULT);
}

static int setup(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    strcpy(f->dir, "/tmp/shearwater-jobs-XXXXXX");
    if (!mkdtemp(f->dir) || uv_loop_init(&f->loop)) return -1;
    *state = f;
    return open_store(f);
}

static int teardown(void **state)
{
    struct fixture *f = *state;
    close_store(f);
    objects_remove_dir(f->dir);
    int error = uv_loop_close(&f->loop);
    free(f);
    return error;
}

static void settle(struct fixture *f)
{
    uv_run(&f->loop, UV_RUN_DEFAULT);
}

static struct job_row make_row(int number)
{
    struct job_row row = {.document = "{\"scene\":\"x\"}",
                          .state = "queued",
                          .created_ms = 1000 + number,
                          .updated_ms = 1000 + number,
                          .priority = number % 7 - 3};
    snprintf(row.id, sizeof row.id, "01JOB%021d", number);
    return row;
}

struct insertion {
    int calls, error;
    char existing[JOB_ID_BYTES];
};

static void on_inserted(void *ctx, int error, const char *existing)
{
    struct insertion *i = ctx;
    i->calls++;
    i->error = error;
    if (existing) strcpy(i->existing, existing);
}

static void on_done(void *ctx, int error)
{
    *(int *)ctx = error;
}

static int insert(struct fixture *f, int number, const char *key, const char *body,
                  struct insertion *out)
{
    struct job_row row = make_row(number);
    struct digest digest;
    *out = (struct insertion){.error = 1};
    digest_of(body, strlen(body), &digest);
    job_store_insert(f->store, &row, key, &digest, on_inserted, out);
    settle(f);
    assert_int_equal(out->calls, 1);
    return out->error;
}

static void insert_plain(struct fixture *f, int number)
{
    struct insertion i;
    assert_int_equal(insert(f, number, NULL, "", &i), 0);
}

struct found {
    int calls, error;
    bool there;
    struct job_row row; /* texts are not kept */
    char state[32], document[128], fault[128], report[128];
    struct frame_row frames[8];
    char frame_states[8][16];
    size_t frame_count;
};

static void keep_text(char *out, size_t capacity, const char *text)
{
    snprintf(out, capacity, "%s", text ? text : "(null)");
}

static void on_found(void *ctx, int error, const struct job_row *row,
                     const struct frame_row *frames, size_t frame_count)
{
    struct found *f = ctx;
    f->calls++;
    f->error = error;
    f->there = row != NULL;
    if (!row) return;
    f->row = *row;
    keep_text(f->state, sizeof f->state, row->state);
    keep_text(f->document, sizeof f->document, row->document);
    keep_text(f->fault, sizeof f->fault, row->error);
    keep_text(f->report, sizeof f->report, row->report);
    f->frame_count = frame_count;
    for (size_t i = 0; i < frame_count && i < 8; i++) {
        f->frames[i] = frames[i];
        keep_text(f->frame_states[i], sizeof f->frame_states[i], frames[i].state);
    }
}

static struct found get(struct fixture *f, const char *id)
{
    struct found found = {0};
    job_store_get(f->store, id, on_found, &found);
    settle(f);
    assert_int_equal(found.calls, 1);
    assert_int_equal(found.error, 0);
    return found;
}

static void a_job_survives_a_restart(void **state)
{
    struct fixture *f = *state;
    insert_plain(f, 1);
    close_store(f);
    assert_int_equal(open_store(f), 0);
    struct found found = get(f, make_row(1).id);
    assert_true(found.there);
    assert_string_equal(found.state, "queued");
    assert_string_equal(found.document, "{\"scene\":\"x\"}");
    assert_string_equal(found.fault, "(null)");
    assert_int_equal(found.row.created_ms, 1001);
    assert_int_equal(found.row.priority, -2);
    assert_int_equal(found.frame_count, 0);
}

static void an_unknown_job_is_no_error(void **state)
{
    struct fixture *f = *state;
    char longer[64];
    insert_plain(f, 1);
    assert_false(get(f, "nothing").there);
    snprintf(longer, sizeof longer, "%sX", make_row(1).id);
    assert_false(get(f, longer).there); /* not cut to an id that exists */
}

static void keys_make_submission_idempotent(void **state)
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

static void a_key_counts_within_one_commit(void **state)
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

static void updates_set_what_is_given(void **state)
{
    struct fixture *f = *state;
    int error = 1;
    insert_plain(f, 1);
    job_store_update(f->store, make_row(1).id, "running", NULL, "{\"a\":1}", on_done, &error);
    settle(f);
    assert_int_equal(error, 0);
    job_store_update(f->store, make_row(1).id, NULL, "{\"e\":2}", NULL, NULL, NULL);
    struct found found = get(f, make_row(1).id);
    assert_string_equal(found.state, "running");
    assert_string_equal(found.fault, "{\"e\":2}");
    assert_string_equal(found.report, "{\"a\":1}");
    assert_true(found.row.updated_ms > 1001);
    job_store_update(f->store, "none", "running", NULL, NULL, on_done, &error);
    settle(f);
    assert_int_equal(error, ERR_NOT_FOUND);
}

/* The loop does not run, so that nothing comes back from the store, as on a disk that hangs. */
static void reports_do_not_pile_up(void **state)
{
    struct fixture *f = *state;
    struct job_store_totals totals;
    char text[32];
    int error = 1;
    insert_plain(f, 1);
    insert_plain(f, 2);
    for (int i = 0; i < 1000; i++) {
        snprintf(text, sizeof text, "{\"i\":%d}", i);
        const char *const job_state = i == 500 ? "running" : NULL;
        job_store_update(f->store, make_row(1).id, job_state, NULL, text, NULL, NULL);
        job_store_update(f->store, make_row(2).id, NULL, NULL, text, NULL, NULL);
        job_store_update_document(f->store, make_row(2).id, text, NULL, NULL);
    }
    job_store_totals(f->store, &totals);
    assert_in_range(totals.waiting, 1, 3);
    /* One that is to be answered is not joined to others, but takes what comes after it. */
    job_store_update(f->store, make_row(1).id, "finished", NULL, "{\"end\":1}", on_done, &error);
    job_store_update(f->store, make_row(1).id, NULL, "{\"e\":2}", NULL, NULL, NULL);
    job_store_totals(f->store, &totals);
    assert_in_range(totals.waiting, 2, 4);
    settle(f);
    assert_int_equal(error, 0);
    struct found one = get(f, make_row(1).id), two = get(f, make_row(2).id);
    assert_string_equal(one.state, "finished");
    assert_string_equal(one.report, "{\"end\":1}");
    assert_string_equal(one.fault, "{\"e\":2}");
    assert_string_equal(two.report, "{\"i\":999}");
    assert_string_equal(two.document, "{\"i\":999}");
    assert_string_equal(two.state, "queued");
}

static void put_frame(struct fixture *f, int job, int32_t number, const char *state, bool finished)
{
    struct frame_row frame = {.number = number, .state = state};
    int error = 1;
    if (finished) {
        digest_of("exr", 3, &frame.exr);
        digest_of("png", 3, &frame.png);
    }
    job_store_update_frame(f->store, make_row(job).id, &frame, NULL, on_done, &error);
    settle(f);
    assert_int_equal(error, 0);
}

static void frames_are_kept_by_number_and_go_with_their_job(void **state)
{
    struct fixture *f = *state;
    int error = 1;
    struct digest exr;
    digest_of("exr", 3, &exr);
    insert_plain(f, 1);
    put_frame(f, 1, 3, "rendering", false);
    put_frame(f, 1, 2, "queued", false);
    put_frame(f, 1, 2, "finished", true);
    struct found found = get(f, make_row(1).id);
    assert_int_equal(found.frame_count, 2);
    assert_int_equal(found.frames[0].number, 2);
    assert_string_equal(found.frame_states[0], "finished");
    assert_true(digest_equal(&found.frames[0].exr, &exr));
    assert_string_equal(found.frame_states[1], "rendering");
    assert_true(digest_is_zero(&found.frames[1].exr));
    job_store_remove(f->store, make_row(1).id, on_done, &error);
    settle(f);
    assert_int_equal(error, 0);
    insert_plain(f, 1);
    assert_int_equal(get(f, make_row(1).id).frame_count, 0);
    struct frame_row frame = {.number = 1, .state = "queued"};
    job_store_update_frame(f->store, "none", &frame, NULL, on_done, &error);
    settle(f);
    assert_int_equal(error, ERR_NOT_FOUND);
}

static void frames_bring_their_jobs_report(void **state)
{
    struct fixture *f = *state;
    struct frame_row frame = {.number = 1, .state = "finished"};
    int error = 1;
    insert_plain(f, 1);
    job_store_update_frame(f->store, make_row(1).id, &frame, "{\"tiles\":9}", on_done, &error);
    settle(f);
    assert_int_equal(error, 0);
    struct found found = get(f, make_row(1).id);
    assert_int_equal(found.frame_count, 1);
    assert_string_equal(found.report, "{\"tiles\":9}");
    assert_string_equal(found.state, "queued");
    put_frame(f, 1, 2, "finished", true);
    assert_string_equal(get(f, make_row(1).id).report, "{\"tiles\":9}");
}

/* Also of those that wait: the loop does not run between. */
static void the_newest_report_stays(void **state)
{
    struct fixture *f = *state;
    struct frame_row frame = {.number = 1, .state = "finished"};
    const char *const id = make_row(1).id;
    int error = 1;
    insert_plain(f, 1);
    insert_plain(f, 2);
    job_store_update(f->store, make_row(2).id, NULL, NULL, "{}", NULL, NULL); /* keeps it busy */
    job_store_update(f->store, id, NULL, NULL, "{\"i\":1}", NULL, NULL);
    job_store_update_frame(f->store, id, &frame, "{\"i\":2}", on_done, &error);
    job_store_update(f->store, id, NULL, NULL, "{\"i\":3}", NULL, NULL);
    job_store_update(f->store, id, NULL, NULL, "{\"i\":4}", NULL, NULL);
    settle(f);
    assert_int_equal(error, 0);
    assert_string_equal(get(f, id).report, "{\"i\":4}");
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

static void listing_pages_from_the_newest(void **state)
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

static size_t count_with(struct fixture *f, const char *text, const char *state)
{
    return find(f, &(struct job_listing){.state = state, .text = text, .limit = 10})->count;
}

static void listing_looks_for_text(void **state)
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

static void unfinished_jobs_are_found_oldest_first(void **state)
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

static void blobs_are_remembered(void **state)
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

static void looking_for_a_key_commits_nothing(void **state)
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

#define MANY 2000

static void many_submissions_share_commits(void **state)
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

static void closing_finishes_what_is_queued(void **state)
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

static void one_folder_has_one_owner(void **state)
{
    struct fixture *f = *state;
    struct job_store *second;
    assert_int_equal(job_store_open(&f->loop, f->dir, &second), ERR_STATE);
    assert_null(second);
}

static void set_version(struct fixture *f, const char *sql)
{
    char path[128];
    sqlite3 *db;
    snprintf(path, sizeof path, "%s/jobs.sqlite", f->dir);
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    assert_int_equal(sqlite3_exec(db, sql, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
}

static void a_newer_schema_is_refused(void **state)
{
    struct fixture *f = *state;
    close_store(f);
    set_version(f, "PRAGMA user_version = 1000");
    assert_int_equal(open_store(f), ERR_VERSION);
    set_version(f, "PRAGMA user_version = 5");
    assert_int_equal(open_store(f), 0);
}

static const char first_id[] = "01JOB000000000000000000001";

static void a_trace_is_kept(void **state)
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

/* A folder of the first version: its jobs are there, none is paused, they are nobody's, and nobody
 * knows which request brought them. */
static void an_older_schema_is_brought_up(void **state)
{
    struct fixture *f = *state;
    const bool paused = true;
    int error = 1;
    insert_plain(f, 1);
    close_store(f);
    set_version(f, "DROP TABLE blob_assets; DROP INDEX blobs_by_blob;"
                   "DROP INDEX frames_by_exr; DROP INDEX frames_by_png;"
                   "DROP INDEX jobs_by_owner; DROP INDEX jobs_by_owner_state;"
                   "ALTER TABLE jobs DROP COLUMN trace; ALTER TABLE jobs DROP COLUMN owner;"
                   "ALTER TABLE jobs DROP COLUMN paused;"
                   "PRAGMA user_version = 1");
    assert_int_equal(open_store(f), 0);
    struct found found = get(f, first_id);
    assert_true(found.there && !found.row.paused);
    assert_string_equal(found.row.owner, "");
    assert_string_equal(found.row.trace, "");
    job_store_steer(f->store, found.row.id, NULL, &paused, on_done, &error);
    settle(f);
    assert_int_equal(error, 0);
    assert_true(get(f, first_id).row.paused);
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

static void owners_have_jobs_and_keys_of_their_own(void **state)
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

static void steering_sets_what_is_given(void **state)
{
    struct fixture *f = *state;
    const bool paused = true, going = false;
    const int32_t priority = -42;
    int error = 1;
    insert_plain(f, 1);
    struct found before = get(f, first_id);
    job_store_steer(f->store, before.row.id, NULL, &paused, on_done, &error);
    settle(f);
    assert_int_equal(error, 0);
    assert_true(get(f, first_id).row.paused);
    assert_int_equal(get(f, first_id).row.priority, before.row.priority);
    job_store_steer(f->store, before.row.id, &priority, NULL, on_done, &error);
    settle(f);
    close_store(f);
    assert_int_equal(open_store(f), 0);
    assert_true(get(f, first_id).row.paused);
    assert_int_equal(get(f, first_id).row.priority, -42);
    assert_string_equal(get(f, first_id).state, before.state);
    job_store_steer(f->store, before.row.id, &priority, &going, on_done, &error);
    settle(f);
    assert_false(get(f, first_id).row.paused);
    job_store_steer(f->store, "none", &priority, &going, on_done, &error);
    settle(f);
    assert_int_equal(error, ERR_NOT_FOUND);
}

static void one_text_is_looked_for_at_a_time(void **state)
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

/* The end that is stored first stays what it is: the change that meets it leaves no trace. */
static void ended_jobs_are_not_steered(void **state)
{
    static const char *const ends[] = {"finished", "failed", "cancelled"};
    struct fixture *f = *state;
    const bool paused = true;
    const int32_t priority = 77;
    for (int i = 0; i < 3; i++) {
        int error = 1;
        insert_plain(f, i);
        job_store_update(f->store, make_row(i).id, ends[i], NULL, NULL, NULL, NULL);
        job_store_steer(f->store, make_row(i).id, &priority, &paused, on_done, &error);
        settle(f);
        assert_int_equal(error, ERR_NOT_FOUND);
        assert_false(get(f, make_row(i).id).row.paused);
        assert_int_not_equal(get(f, make_row(i).id).row.priority, priority);
    }
}

static void a_damaged_file_is_refused(void **state)
{
    struct fixture *f = *state;
    char path[128];
    close_store(f);
    snprintf(path, sizeof path, "%s/jobs.sqlite", f->dir);
    FILE *file = fopen(path, "wb");
    for (int i = 0; i < 1000; i++) fputs("no database at all ", file);
    fclose(file);
    assert_int_equal(open_store(f), ERR_CORRUPT);
    unlink(path);
    assert_int_equal(open_store(f), 0);
}

#define TEST(f) cmocka_unit_test_setup_teardown(f, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_job_survives_a_restart),
        TEST(an_unknown_job_is_no_error),
        TEST(keys_make_submission_idempotent),
        TEST(a_key_counts_within_one_commit),
        TEST(updates_set_what_is_given),
        TEST(reports_do_not_pile_up),
        TEST(frames_are_kept_by_number_and_go_with_their_job),
        TEST(frames_bring_their_jobs_report),
        TEST(the_newest_report_stays),
        TEST(listing_pages_from_the_newest),
        TEST(listing_looks_for_text),
        TEST(unfinished_jobs_are_found_oldest_first),
        TEST(blobs_are_remembered),
        TEST(looking_for_a_key_commits_nothing),
        TEST(many_submissions_share_commits),
        TEST(closing_finishes_what_is_queued),
        TEST(one_folder_has_one_owner),
        TEST(a_newer_schema_is_refused),
        TEST(a_trace_is_kept),
        TEST(an_older_schema_is_brought_up),
        TEST(owners_have_jobs_and_keys_of_their_own),
        TEST(steering_sets_what_is_given),
        TEST(ended_jobs_are_not_steered),
        TEST(one_text_is_looked_for_at_a_time),
        TEST(a_damaged_file_is_refused),
    };
    return cmocka_run_group_tests_name("job_store", tests, NULL, NULL);
}
