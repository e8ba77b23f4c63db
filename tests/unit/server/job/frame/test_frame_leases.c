/* A frame's leases, with workers that behave and workers that do not: who gets a tile, what comes
 * of it when it is returned, spoilt, late or hopeless; the files' bytes do not tell. */
#include <string.h>

#include "tests/unit/server/job/frame/frame_fixture.h"
#include "tests/unit/unit.h"

EACH_TEST(bench_set_up, bench_tear_down);

/* Only a tile that nobody else has, and that has not landed, waits again. */
TEST(a_return_tells_whether_the_tile_waits)
{
    struct bench *b = *state;
    struct fleet_tile tile, copy;
    begin(b, 32);
    assert_true(lease(b, 1, ~0u, &tile));
    assert_true(frame_copy(b->frame, 2, ~0u, &tile, &copy));
    assert_false(frame_returned(b->frame, 1, &tile, FLEET_GIVEN_BACK)); /* the copy is under way */
    assert_true(frame_returned(b->frame, 2, &copy, FLEET_GIVEN_BACK));
    assert_false(frame_returned(b->frame, 2, &copy, FLEET_GIVEN_BACK));
    assert_true(lease(b, 1, ~0u, &tile));
    assert_true(frame_copy(b->frame, 2, ~0u, &tile, &copy));
    assert_int_equal(send_tile(b, 2, &copy, 0), 0);
    assert_false(frame_returned(b->frame, 1, &tile, FLEET_GIVEN_BACK)); /* the copy was first */
    frame_drop(&b->frame);
}

TEST(bad_workers_change_nothing)
{
    struct bench *b = *state;
    struct fleet_tile tile, late = {0};
    render_in_order(b, 32);
    struct digest exr = b->exr;
    b->accepted = 0;
    begin(b, 32);
    uint32_t total = frame_tiles_total(b->frame);
    unsigned turn = 0;
    while (b->frame) {
        while (b->frame && lease(b, 1 + turn % 3, ~0u, &tile)) {
            uint64_t worker = 1 + turn % 3;
            switch (turn++ % 7) {
            case 0: /* dies, and its result comes late: after another has the tile, or before */
                frame_returned(b->frame, worker, &tile, FLEET_GIVEN_BACK);
                if (turn % 2) {
                    late = tile;
                    assert_true(lease(b, worker + 1, ~0u, &tile));
                    assert_int_equal(tile.index, late.index);
                    assert_int_equal(send_tile(b, worker, &late, 0), VERDICT_STALE);
                    assert_int_equal(send_tile(b, worker + 1, &tile, 0), 0);
                } else {
                    assert_int_equal(send_tile(b, worker + 9, &tile, 0), 0);
                }
                break;
            case 1: /* sends rubbish */
                assert_int_equal(send_tile(b, worker, &tile, 64), 0);
                break;
            case 2: /* cannot */
                frame_faulted(b->frame, worker,
                              &(struct message_tile_fault){.frame_id = 9,
                                                           .index = tile.index,
                                                           .generation = tile.generation,
                                                           .code = ERR_MEMORY});
                break;
            case 3: /* somebody else sends first, then twice */
                assert_int_equal(send_tile(b, worker + 1, &tile, 0), VERDICT_FOREIGN);
                assert_int_equal(send_tile(b, worker, &tile, 0), 0);
                assert_int_equal(send_tile(b, worker, &tile, 0), VERDICT_DUPLICATE);
                break;
            default:
                assert_int_equal(send_tile(b, worker, &tile, 0), 0);
            }
        }
        run(b);
    }
    assert_int_equal(b->failed, 0);
    assert_int_equal(b->accepted, total);
    assert_true(b->corrupt > 0 && late.frame_id == 9);
    assert_true(digest_equal(&exr, &b->exr));
}

TEST(a_hopeless_tile_fails_the_frame)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    begin(b, 64);
    for (uint64_t worker = 1; worker <= 3; worker++) {
        assert_non_null(b->frame);
        assert_true(lease(b, worker, ~0u, &tile));
        struct message_tile_fault fault = {.frame_id = 9,
                                           .index = tile.index,
                                           .generation = tile.generation,
                                           .code = ERR_CORRUPT,
                                           .text = "the blob has no such mesh"};
        frame_faulted(b->frame, worker, &fault);
    }
    assert_int_equal(b->failed, 1);
    assert_null(b->frame);
    assert_int_equal(b->fault.code, ERR_CORRUPT);
    assert_non_null(strstr(b->fault.detail, "no such mesh"));
}

/* Dropped with work on the pool: nothing more is told, nothing leaks. */
TEST(a_dropped_frame_is_silent)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    begin(b, 32);
    for (int i = 0; i < 12 && lease(b, 1, ~0u, &tile); i++) send_tile(b, 1, &tile, 0);
    frame_drop(&b->frame);
    run(b);
    assert_int_equal(b->accepted + b->drawn + b->encoded + b->failed, 0);
}

TEST(capabilities_are_asked_for)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    begin(b, 32);
    frame_drop(&b->frame);
    b->plan.capabilities = CAPABILITY_DIRECT | CAPABILITY_INDIRECT;
    struct frame_options options = {
        .id = 9, .layers = LAYER_BEAUTY, .plan = &b->plan, .pool = b->pool, .objects = &b->objects};
    assert_int_equal(frame_create(&options, &b->frame), 0);
    assert_false(lease(b, 1, CAPABILITY_DIRECT, &tile));
    assert_true(lease(b, 1, CAPABILITY_DIRECT | CAPABILITY_INDIRECT, &tile));
    frame_drop(&b->frame);
}
