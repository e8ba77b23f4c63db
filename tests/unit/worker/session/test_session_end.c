/* What ends a worker's session: a refusal, an order to stop, its parent's end, a load that hangs;
 * and which loads do not, though they take long. */
#include <string.h>

#include "proto/link/message.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/session/session_fixture.h"

ALL_TESTS(ignore_broken_pipes, NULL);

TEST(a_refusal_ends_the_worker)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    accept_link(w);
    expect(w, MESSAGE_HELLO, &f);
    message_encode_refused(&w->w, &(struct message_refused){ERR_MISMATCH, "install the same"});
    put(w, MESSAGE_REFUSED, NULL, 0);
    for (int i = 0; !w->ended && i < PATIENCE_MS; i++) turn(w);
    assert_int_equal(w->end, SESSION_END_REFUSED);
    assert_string_equal(w->text, "install the same");
    world_close(w);
}

TEST(told_to_stop_it_finishes_what_it_traces)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    struct message_returned back;
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    send_tile(w, 9, 2);
    while (tracing < 2) turn(w);
    session_stop(w->session);
    expect(w, MESSAGE_RETURN, &f);
    assert_int_equal(message_decode_returned(f.payload, f.payload_bytes, &back), 0);
    assert_int_equal(back.index, 2);
    send_tile(w, 9, 5); /* it crosses: back at once */
    expect(w, MESSAGE_RETURN, &f);
    assert_int_equal(message_decode_returned(f.payload, f.payload_bytes, &back), 0);
    assert_int_equal(back.index, 5);
    hold = false;
    assert_int_equal(expect_result(w), 1);
    assert_false(w->ended);
    send_ack(w, 9, 1);
    expect(w, MESSAGE_BYE, &f);
    assert_true(w->ended);
    assert_int_equal(w->end, SESSION_END_TOLD);
    world_close(w);
}

TEST(told_twice_it_leaves_at_once)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    while (tracing < 2) turn(w);
    session_stop(w->session);
    expect_nothing(w);
    session_stop(w->session);
    expect(w, MESSAGE_RETURN, &f);
    expect(w, MESSAGE_BYE, &f);
    assert_int_equal(w->end, SESSION_END_TOLD);
    world_close(w);
}

TEST(with_its_parent_it_ends)
{
    struct world *w = world_open(1, false);
    w->options.exit_with_parent = true;
    welcome(w, LIFE | 1);
    expect_nothing(w);
    drop_link(w);
    for (int i = 0; !w->ended && i < PATIENCE_MS; i++) turn(w);
    assert_int_equal(w->end, SESSION_END_FAILED);
    world_close(w);
}

static void expect_end_of_load(struct world *w, const char *part)
{
    struct wire_frame_view f;
    struct message_returned back;
    for (int i = 0; !w->ended && i < 2 * PATIENCE_MS; i++) turn(w);
    assert_true(w->ended);
    assert_int_equal(w->end, SESSION_END_FAILED);
    if (!strstr(w->text, part)) fail_msg("\"%s\" lacks \"%s\"", w->text, part);
    expect(w, MESSAGE_RETURN, &f);
    assert_int_equal(message_decode_returned(f.payload, f.payload_bytes, &back), 0);
    assert_int_equal(back.index, 1);
    expect(w, MESSAGE_BYE, &f);
}

TEST(a_load_that_makes_no_step_ends_the_worker)
{
    struct world *w = world_open(1, false);
    w->options.loading_ms = 200;
    load_hangs = true;
    start_tile(w, 1);
    serve_blob(w);
    expect_end_of_load(w, "a load has made no step for 1 s");
    load_hangs = false;
    world_close(w);
}

TEST(one_that_spins_ends_it_sooner)
{
    struct world *w = world_open(1, false);
    w->options.loading_ms = 500;
    load_hangs = load_spins = true;
    start_tile(w, 1);
    serve_blob(w);
    expect_end_of_load(w, "a load has made no step for 0 s");
    load_hangs = false;
    world_close(w);
}

TEST(one_that_lacks_memory_fails_its_tile_and_ends_the_worker)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    struct message_tile_fault fault;
    load_error = ERR_MEMORY;
    start_tile(w, 1);
    serve_blob(w);
    expect(w, MESSAGE_FAULT, &f);
    assert_int_equal(message_decode_tile_fault(f.payload, f.payload_bytes, &fault), 0);
    assert_int_equal(fault.code, ERR_MEMORY);
    expect(w, MESSAGE_BYE, &f);
    assert_true(w->ended);
    assert_int_equal(w->end, SESSION_END_FAILED);
    load_error = 0;
    world_close(w);
}

TEST(one_that_fails_otherwise_does_not)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    load_error = ERR_LIMIT;
    start_tile(w, 1);
    serve_blob(w);
    expect(w, MESSAGE_FAULT, &f);
    expect_nothing(w);
    assert_false(w->ended);
    load_error = 0;
    world_close(w);
}

TEST(a_long_load_that_makes_steps_does_not)
{
    struct world *w = world_open(1, false);
    w->options.loading_ms = 100;
    load_steps = 1500 / LOAD_STEP_MS;
    start_tile(w, 1);
    serve_blob(w);
    assert_int_equal(expect_result(w), 1);
    assert_false(w->ended);
    world_close(w);
}

TEST(nor_does_one_that_waits_for_a_thread)
{
    struct world *w = world_open(1, false);
    struct message_blob_get get;
    w->options.loading_ms = 100;
    warm_up(w);
    const uint32_t traced = tracing;
    hold = true;
    send_tile(w, 9, 1); /* takes the one thread */
    for (int i = 0; tracing == traced && i < PATIENCE_MS; i++) turn(w);
    give_map(w);
    send_frame(w, 10);
    send_tile(w, 10, 2);
    for (int i = 0; !w->ended && i < PATIENCE_MS / 2; i++) turn(w);
    assert_false(w->ended);
    hold = false;
    assert_int_equal(expect_result(w), 1);
    expect_get(w, &get);
    answer(w, &get);
    assert_int_equal(expect_result(w), 2);
    world_close(w);
}
