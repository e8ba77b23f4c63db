/* How much of a frame is traced: bounce rays, samples of the lens and of paths all count, and what
 * is still to come. */
#include "tests/unit/server/job/frame/frame_fixture.h"
#include "tests/unit/unit.h"

EACH_TEST(bench_set_up, bench_tear_down);

/* Bounce rays belong to the first pass. */
TEST(the_share_counts_bounce_rays)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->path_spp = 32;
    b->beside = INDIRECT_FILTER_CONSTANT;
    begin(b, 256);
    assert_true(lease(b, 1, ~0u, &tile));
    assert_int_equal(send_tile(b, 1, &tile, 0), 0);
    run(b);
    assert_true(frame_traced_share(b->frame) == 25.0 / 41.0);
    frame_drop(&b->frame);
    run(b);
}

/* Samples of the lens belong to the first pass, and second sets are to come. */
TEST(the_share_counts_lens_samples)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->lens = true;
    begin(b, 256);
    assert_true(lease(b, 1, ~0u, &tile));
    assert_int_equal(send_tile(b, 1, &tile, 0), 0);
    while (b->accepted == 0) uv_run(&b->loop, UV_RUN_ONCE);
    /* 4 bounce rays and 9 samples of the lens, and 9 more in the mean */
    assert_true(frame_traced_share(b->frame) == 13.0 / 22.0);
    frame_drop(&b->frame);
    run(b);
}

/* Passes differ in length: the share counts samples. */
TEST(the_share_counts_samples)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->path_spp = 64;
    begin(b, 256);
    assert_int_equal(frame_tiles_total(b->frame), 3);
    for (uint32_t pass = 0; pass < 2; pass++) {
        assert_true(frame_traced_share(b->frame) == 0.25 * pass);
        assert_true(lease(b, 1, ~0u, &tile));
        assert_int_equal(tile.pass.number, pass);
        assert_int_equal(tile.generation, pass + 1);
        assert_int_equal(frame_tiles_waiting(b->frame), 0);
        assert_int_equal(send_tile(b, 1, &tile, 0), 0);
        assert_int_equal(send_tile(b, 1, &tile, 0), VERDICT_DUPLICATE);
        run(b);
        assert_int_equal(frame_tiles_waiting(b->frame), 1);
        assert_int_equal(send_tile(b, 1, &tile, 0), VERDICT_DUPLICATE);
    }
    assert_int_equal(frame_tiles_landed(b->frame), 2);
    assert_true(frame_traced_share(b->frame) == 0.5);
    assert_int_equal(b->encoded, 0);
    /* A result of another pass does not fit: it has planes that this one has not. */
    assert_true(lease(b, 1, ~0u, &tile));
    tile.pass.number = 0;
    assert_int_equal(send_tile(b, 1, &tile, 0), 0);
    run(b);
    assert_int_equal(b->corrupt, 1);
    frame_drop(&b->frame);
}
