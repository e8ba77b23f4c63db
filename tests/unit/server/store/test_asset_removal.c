/* What goes with an asset that is given up, and what keeps it: server/store/asset_removal.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/store/removal_case.h"

EACH_TEST(setup, teardown);

TEST(what_is_held_goes_when_it_is_not)
{
    struct fixture *f = *state;
    const struct digest d = store(f, "held");
    own(f, "a", &d);
    assert_int_equal(give_up(f, "a", &d), 0);
    pass(f);
    assert_true(is_there(f, &d) && is_noted(f, &d));
    objects_release(&f->objects, &d);
    assert_true(goes(f, &d));
}

/* Submitted by somebody who needs no mark. */
TEST(what_anothers_job_names_goes_when_that_has_ended)
{
    struct fixture *f = *state;
    const struct digest d = bring(f, "b", "named");
    char hex[DIGEST_HEX_BYTES], text[128];
    struct job_row row = {
        .id = "01JOB000000000000000000001", .document = text, .state = "queued", .owner = "a"};
    int inserted = 1, ended = 1;
    digest_to_hex(&d, hex);
    snprintf(text, sizeof text, "{\"scene\":{\"asset\":\"%s\"}}", hex);
    job_store_insert(f->store, &row, NULL, NULL, on_inserted, &inserted);
    assert_int_equal(give_up(f, "b", &d), 0);
    pass(f);
    assert_int_equal(inserted, 0);
    assert_true(is_there(f, &d) && is_noted(f, &d));
    job_store_update(f->store, row.id, "finished", NULL, NULL, on_done, &ended);
    assert_true(goes(f, &d));
    assert_int_equal(ended, 0);
}

/* More than one pass takes, and some of them have to wait. */
TEST(a_round_comes_to_all)
{
    enum { COUNT = 3 * REMOVAL_PASS_FILES + 1, APART = REMOVAL_PASS_FILES };
    struct fixture *f = *state;
    struct digest all[COUNT];
    size_t left = 0, kept = 0;
    char text[32];
    assert_int_equal(asset_tables_begin(f->db), 0);
    for (int i = 0; i < COUNT; i++) {
        snprintf(text, sizeof text, "one of many: %d", i);
        all[i] = store(f, text);
        if (i % APART != 0) objects_release(&f->objects, &all[i]);
        assert_int_equal(asset_removals_add(f->db, &all[i]), 0);
    }
    assert_int_equal(asset_tables_end(f->db, 0), 0);
    assert_int_equal(pass(f), 4);
    for (int i = 0; i < COUNT; i++) {
        const bool waits = objects_is_held(&f->objects, &all[i]); /* or is beside one that is */
        kept += waits;
        assert_true(is_there(f, &all[i]) == waits && is_noted(f, &all[i]) == waits);
    }
    assert_int_equal(asset_removals_count(f->db, &left), 0);
    assert_true(left == kept && kept >= 4 && kept < COUNT);
    for (int k = 0; k < COUNT; k += APART) objects_release(&f->objects, &all[k]);
    (void)pass(f);
    for (int i = 0; i < COUNT; i++) assert_false(is_there(f, &all[i]) || is_noted(f, &all[i]));
}

/* The same by the timer, of as many as one pass takes and one more. */
TEST(the_store_looks_at_all_in_time)
{
    enum { COUNT = REMOVAL_PASS_FILES + 1 };
    struct fixture *f = *state;
    struct digest all[COUNT];
    char text[32];
    for (int i = 0; i < COUNT; i++) {
        snprintf(text, sizeof text, "one of many: %d", i);
        all[i] = store(f, text);
        objects_release(&f->objects, &all[i]);
        job_store_doubt_asset(f->store, &all[i]);
    }
    for (int i = 0; i < COUNT; i++) assert_true(goes(f, &all[i]));
}

/* An upload that is under way relies on its note. */
TEST(a_note_of_what_is_held_stays)
{
    struct fixture *f = *state;
    const struct digest d = store(f, "uploaded");
    own(f, "a", &d);
    assert_int_equal(asset_removals_add(f->db, &d), 0);
    job_store_resume_removals(f->store);
    assert_true(is_noted(f, &d));
    objects_release(&f->objects, &d);
    (void)pass(f);
    assert_true(is_there(f, &d) && !is_noted(f, &d));
}

TEST(what_is_held_goes_with_the_next_start)
{
    struct fixture *f = *state;
    const struct digest d = store(f, "held");
    own(f, "a", &d);
    assert_int_equal(give_up(f, "a", &d), 0);
    assert_false(has(f, "a", &d));
    assert_true(is_there(f, &d) && is_noted(f, &d));
    objects_release(&f->objects, &d);
    job_store_resume_removals(f->store);
    assert_false(is_there(f, &d) || is_noted(f, &d));
}

TEST(the_last_owner_takes_it_along)
{
    struct fixture *f = *state;
    const struct digest d = bring(f, "a", "shared");
    own(f, "b", &d);
    assert_int_equal(give_up(f, "c", &d), ERR_NOT_FOUND);
    assert_int_equal(give_up(f, "a", &d), 0);
    assert_int_equal(give_up(f, "a", &d), ERR_NOT_FOUND);
    assert_true(is_there(f, &d) && has(f, "b", &d));
    assert_false(is_noted(f, &d));
    assert_int_equal(give_up(f, "b", &d), 0);
    assert_false(is_there(f, &d) || has(f, "b", &d));
}

/* Both at once, in either order: one of them is refused. */
TEST(a_job_comes_before_it_or_is_refused)
{
    struct fixture *f = *state;
    const struct digest d = bring(f, "a", "raced");
    struct asset_claim claim = {.asset = d, .owner = "a"};
    struct outcome outcome = {.error = 1};
    bool found = true;
    int first = 1, second = 1, ended = 1, key = 1;
    submit(f, "01JOB000000000000000000001", NULL, &d, &first);
    job_store_remove_asset(f->store, &claim, on_gave_up, &outcome);
    settle(f);
    assert_int_equal(first, 0);
    assert_int_equal(outcome.error, ERR_STATE);
    assert_int_equal(outcome.users.count, 1);
    assert_string_equal(outcome.users.ids[0], "01JOB000000000000000000001");
    job_store_update(f->store, "01JOB000000000000000000001", "failed", NULL, NULL, on_done, &ended);
    job_store_remove_asset(f->store, &claim, on_gave_up, &outcome);
    settle(f);
    assert_int_equal(ended, 0);
    assert_int_equal(outcome.error, 0);
    submit(f, "01JOB000000000000000000002", "its-key", &d, &second);
    settle(f);
    assert_int_equal(second, ERR_NOT_FOUND);
    job_store_get(f->store, "01JOB000000000000000000002", on_found, &found);
    job_store_find_key(f->store, "a", "its-key", &(struct digest){{7}}, on_inserted, &key);
    settle(f);
    assert_false(found); /* nor is its key taken */
    assert_int_equal(key, 0);
}

/* The file went, and the process died before that was on record. */
TEST(a_start_finds_owners_without_their_asset)
{
    struct fixture *f = *state;
    char path[OBJECTS_PATH_BYTES];
    const struct digest asset = bring(f, "a", "scene"), blob = store(f, "blob");
    remember(f, "import", &blob, &asset, 1);
    job_store_resume_removals(f->store);
    assert_true(is_there(f, &asset) && is_there(f, &blob));
    objects_path(&f->objects, &asset, path);
    assert_int_equal(remove(path), 0);
    job_store_resume_removals(f->store);
    assert_false(is_there(f, &blob) || has(f, "a", &asset));
    assert_false(is_noted(f, &asset) || is_noted(f, &blob));
}

/* The same after the note: what is left are the file or its imports. */
TEST(a_start_goes_on_with_what_is_noted)
{
    struct fixture *f = *state;
    const struct digest asset = bring(f, "a", "scene"), blob = store(f, "blob");
    remember(f, "import", &blob, &asset, 1);
    assert_int_equal(asset_owners_drop(f->db, "a", &asset), 0);
    assert_int_equal(asset_removals_add(f->db, &asset), 0);
    job_store_resume_removals(f->store);
    assert_false(is_there(f, &asset) || is_there(f, &blob));
    assert_false(is_noted(f, &asset) || is_noted(f, &blob));
}

static int set_max_pages(struct fixture *f, int count)
{
    char text[64];
    snprintf(text, sizeof text, "PRAGMA max_page_count = %d", count);
    return sqlite3_exec(f->db, text, NULL, NULL, NULL);
}

/* Notes fill their page, and there is no other one. */
static void fill_database(struct fixture *f)
{
    struct digest d;
    int error = set_max_pages(f, 1); /* none beyond those that there are */
    for (int i = 0; i < 1000 && !error; i++) {
        digest_of(&i, sizeof i, &d);
        error = asset_removals_add(f->db, &d);
    }
    assert_int_equal(error, ERR_NO_SPACE);
}

TEST(a_full_disk_keeps_no_file_that_need_not_wait)
{
    struct fixture *f = *state;
    struct asset_users users;
    const struct digest d = bring(f, "a", "large"), held = store(f, "held");
    const struct asset_claim claim = {.asset = d, .owner = "a"},
                             waits = {.asset = held, .owner = "a"};
    own(f, "a", &held);
    fill_database(f);
    assert_int_equal(asset_removal_run(f->db, &f->room, &waits, &users), ERR_NO_SPACE);
    assert_true(is_there(f, &held) && asset_room_find(f->db, &f->room, &waits) == 0);
    assert_int_equal(asset_removal_run(f->db, &f->room, &claim, &users), ERR_NO_SPACE);
    assert_false(is_there(f, &d));
    assert_int_equal(asset_room_find(f->db, &f->room, &claim), ERR_NOT_FOUND);
    assert_int_equal(set_max_pages(f, 1000000), SQLITE_OK);
    assert_int_equal(asset_removal_run(f->db, &f->room, &claim, &users), 0);
    assert_false(has(f, "a", &d) || is_noted(f, &d));
    objects_release(&f->objects, &held);
}

TEST(a_picture_is_kept)
{
    struct fixture *f = *state;
    const struct digest scene = bring(f, "a", "scene"), picture = bring(f, "a", "picture");
    const struct frame_row frame = {.number = 1, .state = "finished", .exr = picture};
    int inserted = 1, recorded = 1;
    submit(f, "01JOB000000000000000000001", NULL, &scene, &inserted);
    job_store_update_frame(f->store, "01JOB000000000000000000001", &frame, NULL, on_done,
                           &recorded);
    settle(f);
    assert_int_equal(inserted, 0);
    assert_int_equal(recorded, 0);
    assert_int_equal(give_up(f, "a", &picture), 0);
    assert_false(has(f, "a", &picture));
    assert_true(is_there(f, &picture));
    job_store_resume_removals(f->store);
    assert_true(is_there(f, &picture));
}
