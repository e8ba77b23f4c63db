/* Tiles that a worker's session leases: what it asks for, what it traces of each, and how their
 * results go back; leases and other messages that break the link. */
#include <string.h>
#include <sys/socket.h>

#include "proto/count_map.h"
#include "proto/link/message.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/session/session_fixture.h"

ALL_TESTS(ignore_broken_pipes, NULL);

TEST(a_tile_is_fetched_for_traced_and_answered)
{
    struct world *w = world_open(2, false);
    welcome(w, LIFE | 1);
    for (int i = 0; w->asked == 0 && i < PATIENCE_MS; i++) expect_nothing(w);
    assert_int_equal(w->asked, 4);
    send_frame(w, 9);
    send_tile(w, 9, 3);
    send_tile(w, 9, 4);
    serve_blob(w);
    assert_int_equal(expect_result(w) + expect_result(w), 7);
    send_ack(w, 9, 3);
    send_ack(w, 9, 4);
    expect_nothing(w);
    assert_int_equal(w->asked, 6);
    assert_int_equal(loads, 1);
    send_frame(w, 10); /* the scene is still there */
    send_tile(w, 10, 5);
    assert_int_equal(expect_result(w), 5);
    assert_int_equal(loads, 1);
    world_close(w);
}

TEST(results_are_kept_until_acknowledged)
{
    struct world *w = world_open(1, false);
    warm_up(w);
    send_tile(w, 9, 1);
    send_tile(w, 9, 2);
    assert_int_equal(expect_result(w), 1);
    assert_int_equal(expect_result(w), 2);
    send_ack(w, 9, 1);
    expect_nothing(w);
    drop_link(w);
    welcome(w, LIFE | 2); /* the same coordinator: the rest is said again */
    assert_int_equal(expect_result(w), 2);
    /* Connected, a job's frame, connected. */
    assert_int_equal(w->worker_log.log.lines[LOG_INFO], 3);
    assert_int_equal(w->worker_log.log.lines[LOG_WARNING], 1);
    assert_true(told(w, "warning link lost", "trying again"));
    drop_link(w);
    welcome(w, (LIFE + (1ull << WORKER_ID_LIFE_SHIFT)) | 1); /* another one */
    expect_nothing(w);
    world_close(w);
}

TEST(illegal_messages_break_the_link)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    for (int i = 0; i < 6; i++) {
        welcome(w, LIFE | 1);
        switch (i) {
        case 0: /* no such frame */
            send_tile(w, 1234, 0);
            break;
        case 1:
            message_encode_welcome(&w->w, &(struct message_welcome){LIFE | 1, 40});
            put(w, MESSAGE_WELCOME, NULL, 0);
            break;
        case 2:
            message_encode_want(&w->w, &(struct message_want){1});
            put(w, MESSAGE_WANT, NULL, 0);
            break;
        case 3: /* outside the frame */
            send_frame(w, 9);
            message_encode_tile(
                &w->w,
                &(struct message_tile){.frame_id = 9, .generation = 1, .rect = {704, 0, 736, 32}});
            put(w, MESSAGE_TILE, NULL, 0);
            break;
        case 4: /* a pass too many */
            send_frame(w, 9);
            send_pass(w, 9, 0, 3);
            break;
        default:
            assert_int_equal(send(w->fd, "no frame at all, but long enough", 32, 0), 32);
        }
        while (next(w, &f, PATIENCE_MS)) {
        }
        drop_link(w);
    }
    assert_false(w->ended);
    world_close(w);
}

TEST(a_lease_names_its_pass)
{
    struct world *w = world_open(1, false);
    warm_up(w);
    for (uint32_t pass = 3; pass-- > 0;) {
        send_pass(w, 9, 1, pass);
        assert_int_equal(expect_result(w), 1);
        assert_int_equal(traced_pass, pass);
        send_ack(w, 9, 1);
    }
    world_close(w);
}

/* A second set for a tile of 32 x 32, `damage` of its bytes spoilt. */
static void send_strata_maps(struct world *w, uint64_t frame_id, uint32_t index, uint32_t strata,
                             uint8_t largest, size_t damage)
{
    const int32_t x = (int32_t)(index % 20) * 32;
    const uint32_t maps = plan_strata_maps(&w->plan) > 1 ? 2 : 1;
    uint8_t strata_maps[2 * 32 * 32] = {0};
    struct bytes_writer packed;
    bytes_writer_init(&packed);
    for (int i = 0; i < 32; i++) strata_maps[i * 32] = largest;
    if (maps > 1) strata_maps[2 * 32 * 32 - 1] = 1;
    assert_int_equal(count_map_pack(&packed, strata_maps, maps, 32, 32), 0);
    memset(packed.data, 0xa5, damage);
    const struct message_tile m = {
        .frame_id = frame_id,
        .index = index,
        .generation = 1,
        .pass = {.number = plan_pass_count(&w->plan), .strata = strata},
        .rect = {x, 0, x + 32, 32},
        .counts = packed.data,
        .counts_bytes = (uint32_t)packed.size_bytes,
    };
    message_encode_tile(&w->w, &m);
    put(w, MESSAGE_TILE, NULL, 0);
    bytes_writer_fini(&packed);
}

static void rate_plan(struct world *w)
{
    w->plan.indirect_filter = INDIRECT_FILTER_ADAPTIVE;
    w->plan.adaptive = (struct plan_adaptive){.mu = 1, .rays_max = 100};
    w->plan.planes &=
        ~(PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(GLOSSY_HALF));
}

TEST(a_lease_has_its_pixels_strata_map)
{
    struct world *w = world_open(1, false);
    rate_plan(w);
    warm_up(w);
    send_strata_maps(w, 9, 1, 7, 7, 0);
    assert_int_equal(expect_result(w), 1);
    assert_int_equal(traced_strata, 7 * 32);
    send_ack(w, 9, 1);
    send_pass(w, 9, 2, 1);
    assert_int_equal(expect_result(w), 2);
    assert_int_equal(traced_strata, 0);
    world_close(w);
}

/* And those of its glossy lobes, where the plan has them. */
TEST(a_lease_has_its_lobes_strata_map)
{
    struct world *w = world_open(1, false);
    rate_plan(w);
    w->plan.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_SPAN);
    warm_up(w);
    send_strata_maps(w, 9, 1, 7, 7, 0);
    assert_int_equal(expect_result(w), 1);
    assert_true(traced_strata == 7 * 32 && traced_lobes == 1);
    world_close(w);
}

/* Strata maps that are none, too many, none of the plan's, or for a plan without. */
TEST(strata_maps_that_do_not_fit_break_the_link)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    const struct plan plain = w->plan;
    for (int i = 0; i < 6; i++) {
        w->plan = plain;
        if (i < 5) rate_plan(w);
        welcome(w, LIFE | 1);
        send_frame(w, 9);
        switch (i) {
        case 0:
            send_strata_maps(w, 9, 1, 7, 7, 12);
            break;
        case 1: /* the largest is not what the lease says */
            send_strata_maps(w, 9, 1, 8, 7, 0);
            break;
        case 2: /* more rays than the plan has: 9 and 100 */
            send_strata_maps(w, 9, 1, 10, 10, 0);
            break;
        case 3: /* no pixel gets any */
            send_strata_maps(w, 9, 1, 0, 0, 0);
            break;
        case 4: /* the pass without its strata map */
            send_pass(w, 9, 1, plan_pass_count(&w->plan));
            break;
        default:
            send_strata_maps(w, 9, 1, 7, 7, 0);
        }
        while (next(w, &f, PATIENCE_MS)) {
        }
        drop_link(w);
    }
    assert_false(w->ended);
    world_close(w);
}

TEST(a_cancelled_frame_is_stopped)
{
    struct world *w = world_open(1, false);
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    send_tile(w, 9, 2);
    while (tracing < 2) turn(w); /* the first was tile 0 */
    message_encode_cancel(&w->w, &(struct message_cancel){9});
    put(w, MESSAGE_CANCEL, NULL, 0);
    expect_nothing(w);
    hold = false;
    expect_nothing(w);
    assert_int_equal(w->asked, 5); /* 2, and 3 for those that are through */
    send_frame(w, 10);
    send_tile(w, 10, 3);
    assert_int_equal(expect_result(w), 3);
    world_close(w);
}

TEST(a_drained_worker_asks_again_after_a_tile)
{
    struct world *w = world_open(1, false);
    warm_up(w);
    expect_nothing(w);
    uint32_t asked = w->asked;
    message_encode_drain(&w->w, &(struct message_drain){0});
    put(w, MESSAGE_DRAIN, NULL, 0);
    expect_nothing(w);
    assert_int_equal(session_state(w->session), SESSION_DRAINING);
    assert_int_equal(w->asked, asked);
    send_tile(w, 9, 1);
    assert_int_equal(expect_result(w), 1);
    expect_nothing(w);
    assert_int_equal(session_state(w->session), SESSION_WORKING);
    assert_true(w->asked > asked);
    world_close(w);
}

TEST(beats_tell_of_progress)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    struct message_beat m = {0};
    warm_up(w);
    for (int i = 0; i < PATIENCE_MS && m.progress < 34; i++) {
        turn(w);
        read_some(w);
        while (wire_frame_inbox_next(&w->inbox, &f) == 0)
            if (f.type == MESSAGE_BEAT)
                assert_int_equal(message_decode_beat(f.payload, f.payload_bytes, &m), 0);
    }
    assert_true(m.progress >= 34); /* 32 rows and two parts */
    assert_true(m.rss_bytes > 0 && m.peak_rss_bytes > 0 && m.cpu_us > 0);
    assert_int_equal(m.phase, BEAT_IDLE);
    world_close(w);
}
