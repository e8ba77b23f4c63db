/* What changes of a stored job: its state and report, its frames, which go with it, and what steers
 * it. */
#include <stdio.h>

#include "tests/unit/server/store/job_store_fixture.h"
#include "tests/unit/unit.h"

EACH_TEST(setup, teardown);

TEST(updates_set_what_is_given)
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
TEST(reports_do_not_pile_up)
{
    struct fixture *f = *state;
    struct job_store_totals totals;
    char text[80];
    int error = 1;
    insert_plain(f, 1);
    insert_plain(f, 2);
    for (int i = 0; i < 1000; i++) {
        snprintf(text, sizeof text, "{\"i\":%d,\"name\":null,\"comment\":null,\"labels\":[]}", i);
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
    assert_string_equal(two.report, text);
    assert_string_equal(two.document, text);
    assert_string_equal(two.state, "queued");
}

TEST(frames_are_kept_by_number_and_go_with_their_job)
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

TEST(frames_bring_their_jobs_report)
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
TEST(the_newest_report_stays)
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

TEST(steering_sets_what_is_given)
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

/* The end that is stored first stays what it is: the change that meets it leaves no trace. */
TEST(ended_jobs_are_not_steered)
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
