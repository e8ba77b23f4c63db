/* The folder of a store of jobs: what was answered is there after a restart, it has one owner,
 * other schemas and damaged files are noticed. */
#include <sqlite3.h>
#include <stdio.h>
#include <unistd.h>

#include "tests/unit/server/store/job_store_fixture.h"
#include "tests/unit/unit.h"

EACH_TEST(setup, teardown);

TEST(a_job_survives_a_restart)
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

TEST(one_folder_has_one_owner)
{
    struct fixture *f = *state;
    struct job_store *second;
    assert_int_equal(job_store_open(&f->loop, f->dir, false, &second), ERR_STATE);
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

TEST(a_newer_schema_is_refused)
{
    struct fixture *f = *state;
    close_store(f);
    set_version(f, "PRAGMA user_version = 1000");
    assert_int_equal(open_store(f), ERR_VERSION);
    set_version(f, "PRAGMA user_version = 9");
    assert_int_equal(open_store(f), 0);
}

/* A folder of the first version: its jobs are there, none is paused, they are nobody's, and nobody
 * knows which request brought them. */
TEST(an_older_schema_is_brought_up)
{
    struct fixture *f = *state;
    const bool paused = true;
    int error = 1;
    insert_plain(f, 1);
    close_store(f);
    set_version(f, "DROP TABLE marks; DROP TABLE thumbnails; DROP TABLE webhooks;"
                   "DROP TABLE asset_owners; DROP TABLE removals;"
                   "DROP TABLE blob_assets; DROP INDEX blobs_by_blob;"
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

TEST(a_damaged_file_is_refused)
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
