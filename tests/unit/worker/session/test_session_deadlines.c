/* When a worker leaves by itself: never answered, idle, or at the end of its lifetime. */
#include <string.h>

#include "proto/link/message.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/session/session_fixture.h"

ALL_TESTS(ignore_broken_pipes, NULL);

static void until_ended(struct world *w, int most_ms)
{
    for (int i = 0; !w->ended && i < most_ms; i++) turn(w);
}

/* Opens a world whose deadlines count from now. */
static struct world *open_with(uint32_t connect_within_s, uint32_t idle_exit_s, uint32_t lifetime_s)
{
    const struct options deadlines = {
        .connect_within_s = connect_within_s, .idle_exit_s = idle_exit_s, .lifetime_s = lifetime_s};
    return world_open_with(1, false, &deadlines);
}

TEST(a_coordinator_that_never_answers_is_given_up)
{
    struct world *w = open_with(1, 0, 0);
    accept_link(w); /* and no word */
    until_ended(w, PATIENCE_MS);
    assert_true(w->ended);
    assert_int_equal(w->end, SESSION_END_FAILED);
    assert_non_null(strstr(w->text, "has not answered within 1 s"));
    world_close(w);
}

TEST(one_that_answered_once_is_not)
{
    struct world *w = open_with(1, 0, 0);
    welcome(w, LIFE | 1);
    expect_nothing(w);
    drop_link(w);
    until_ended(w, 4000);
    assert_false(w->ended);
    world_close(w);
}

TEST(an_idle_worker_says_goodbye)
{
    struct world *w = open_with(0, 1, 0);
    struct wire_frame_view f;
    welcome(w, LIFE | 1);
    expect(w, MESSAGE_BYE, &f);
    assert_int_equal(w->end, SESSION_END_TOLD);
    assert_string_equal(w->text, "");
    world_close(w);
}

TEST(a_tile_in_hand_is_no_idling)
{
    struct world *w = open_with(0, 1, 0);
    struct wire_frame_view f;
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    until_ended(w, 4000);
    assert_false(w->ended);
    hold = false;
    assert_int_equal(expect_result(w), 1);
    send_ack(w, 9, 1);
    expect(w, MESSAGE_BYE, &f);
    world_close(w);
}

TEST(without_its_coordinator_a_worker_idles)
{
    struct world *w = open_with(0, 1, 0);
    welcome(w, LIFE | 1);
    expect_nothing(w);
    drop_link(w);
    until_ended(w, PATIENCE_MS);
    assert_true(w->ended);
    assert_int_equal(w->end, SESSION_END_TOLD);
    world_close(w);
}

TEST(before_its_lifetime_ends_a_worker_gives_back_what_it_has_not_begun)
{
    struct world *w = open_with(0, 0, 2);
    struct wire_frame_view f;
    struct message_returned back;
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    send_tile(w, 9, 2);
    expect(w, MESSAGE_RETURN, &f);
    assert_int_equal(message_decode_returned(f.payload, f.payload_bytes, &back), 0);
    assert_int_equal(back.index, 2);
    assert_false(w->ended);
    hold = false;
    assert_int_equal(expect_result(w), 1);
    send_ack(w, 9, 1);
    expect(w, MESSAGE_BYE, &f);
    assert_int_equal(w->end, SESSION_END_TOLD);
    world_close(w);
}

TEST(at_its_end_it_gives_back_the_rest)
{
    struct world *w = open_with(0, 0, 2);
    struct wire_frame_view f;
    struct message_returned back;
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    expect(w, MESSAGE_RETURN, &f);
    assert_int_equal(message_decode_returned(f.payload, f.payload_bytes, &back), 0);
    assert_int_equal(back.index, 1);
    expect(w, MESSAGE_BYE, &f);
    assert_int_equal(w->end, SESSION_END_TOLD);
    world_close(w);
}
