/* Frames that ask for more when all has landed: for a target of error, and second sets of rays.
 * Their files do not tell who traced them or when. */
#include "proto/count_map.h"
#include "tests/unit/server/job/frame/frame_fixture.h"
#include "tests/unit/unit.h"

/* Workers that take turns, some of which fail, until the frame has its files. */
static void render_target(struct bench *b, bool badly, int32_t tile_px)
{
    struct fleet_tile held[16];
    unsigned holding = 0;
    uint32_t seed = 5;
    double share = 0.0;
    clear_counts(b);
    b->extended = 0;
    begin(b, tile_px);
    while (b->frame) {
        while (b->frame && holding < 16 && lease(b, 1, ~0u, &held[holding])) holding++;
        if (holding > 0) {
            seed = seed * 1664525u + 1013904223u;
            const unsigned at = badly ? (seed >> 8) % holding : 0;
            const struct fleet_tile tile = held[at];
            held[at] = held[--holding];
            if (badly && seed >> 29 == 1)
                frame_returned(b->frame, 1, &tile, FLEET_GIVEN_BACK);
            else
                assert_int_equal(send_tile(b, 1, &tile, 0), 0);
        }
        uv_run(&b->loop, holding == 0 || !badly ? UV_RUN_DEFAULT : UV_RUN_NOWAIT);
        if (!b->frame) break;
        assert_true(frame_traced_share(b->frame) >= share && frame_traced_share(b->frame) < 1.0);
        share = frame_traced_share(b->frame);
    }
    assert_int_equal(b->failed, 0);
    assert_int_equal(b->encoded, 1);
    assert_int_equal(b->traced, 1);
}

EACH_TEST(bench_set_up, bench_tear_down);

TEST(targets_take_rounds)
{
    struct bench *b = *state;
    b->path_spp = 9;
    b->target = 0.05f;
    render_target(b, false, 16);
    const struct digest exr = b->exr;
    const struct statistics first = b->statistics;
    assert_true(b->extended > 0 && first.target_rounds == b->extended + 1);
    assert_true(first.target_error <= 50000 && first.target_error > 30000);
    assert_true(first.target_paths > 9 * 75 * 70 && first.target_threshold > 0);
    assert_true(first.indirect_pixels_filtered > 0);
    assert_true(first.indirect_pixels_filtered + first.indirect_pixels_skipped <= 4 * 75 * 70);
    render_target(b, true, 16);
    assert_true(digest_equal(&exr, &b->exr));
    assert_true(b->statistics.target_paths == first.target_paths);
    assert_true(b->statistics.target_error == first.target_error);
    b->target = 1000.0f; /* met at once */
    render_target(b, false, 16);
    assert_int_equal(b->extended, 0);
    assert_true(b->statistics.target_rounds == 1 && b->statistics.target_paths == 9 * 75 * 70);
}

/* Second sets of bounce rays: the files do not show who traced them, when, or in what tiles. */
TEST(second_sets_give_the_same_files)
{
    struct bench *b = *state;
    b->rate = true;
    for (b->path_spp = 0; b->path_spp <= 40; b->path_spp += 40) {
        render_target(b, false, 16);
        const struct digest exr = b->exr;
        const struct statistics first = b->statistics;
        assert_int_equal(b->extended, 1);
        assert_true(first.adaptive_first_rays > 16 * 4000 && first.adaptive_first_rays < 16 * 5250);
        assert_true(first.adaptive_second_rays > 0 &&
                    first.adaptive_second_rays <= 81 * first.adaptive_first_rays / 16);
        assert_true(first.indirect_pixels_filtered > 0);
        static const int32_t sizes[] = {16, 8, 33, 256};
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            render_target(b, true, sizes[i]);
            assert_true(digest_equal(&exr, &b->exr));
            assert_true(b->statistics.adaptive_second_rays == first.adaptive_second_rays);
            assert_true(b->statistics.adaptive_first_rays == first.adaptive_first_rays);
            assert_true(b->statistics.indirect_pixels_filtered == first.indirect_pixels_filtered);
        }
    }
    b->rate = false;
}

static unsigned draws_of(struct bench *b, bool unwatched)
{
    struct fleet_tile tile;
    clear_counts(b);
    b->unwatched = unwatched;
    begin(b, 16);
    while (lease(b, 1, ~0u, &tile)) {
        assert_int_equal(send_tile(b, 1, &tile, 0), 0);
        if (b->frame) uv_run(&b->loop, UV_RUN_NOWAIT);
    }
    run(b);
    assert_int_equal(b->encoded, 1);
    b->unwatched = false;
    return b->drawn;
}

/* Three passes are drawn as they come, or all at once. */
TEST(unwatched_blocks_are_drawn_once)
{
    struct bench *b = *state;
    b->path_spp = 40;
    const unsigned watched = draws_of(b, false);
    const struct digest exr = b->exr;
    const unsigned once = draws_of(b, true);
    assert_true(once > 0 && watched >= 2 * once);
    assert_true(digest_equal(&exr, &b->exr));
}

/* Leases of the second set carry what the tile's pixels get, as often as they are given. */
static void check_second_lease(struct bench *b, uint32_t maps)
{
    struct fleet_tile tile, again;
    uint8_t strata_maps[2 * 32 * 32];
    assert_true(lease(b, 1, ~0u, &tile));
    assert_int_equal(plan_pass_check(&b->plan, &tile.pass), 0);
    const int32_t width = rect_width(tile.rect), height = rect_height(tile.rect);
    const size_t area = (size_t)width * (size_t)height;
    assert_int_equal(
        count_map_unpack(tile.counts, tile.counts_bytes, maps, width, height, strata_maps), 0);
    assert_memory_equal(strata_maps, tile.pass.strata_map, area);
    if (maps > 1)
        assert_memory_equal(strata_maps + area, tile.pass.lobes, area);
    else
        assert_null(tile.pass.lobes);
    assert_int_equal(plan_strata_map_check(&tile.pass, area), 0);
    frame_returned(b->frame, 1, &tile, FLEET_GIVEN_BACK);
    assert_true(lease(b, 2, ~0u, &again));
    assert_true(again.index == tile.index && again.generation == tile.generation + 1);
    assert_memory_equal(again.counts, tile.counts, tile.counts_bytes);
}

TEST(leases_carry_second_sets)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    for (uint32_t maps = 1; maps <= 2; maps++) {
        b->rate = true;
        b->lobes = maps > 1;
        b->path_spp = 0;
        b->extended = 0;
        begin(b, 32);
        while (b->extended == 0) {
            while (lease(b, 1, ~0u, &tile)) {
                assert_true(tile.counts == NULL && tile.pass.strata_map == NULL);
                send_tile(b, 1, &tile, 0);
            }
            uv_run(&b->loop, UV_RUN_ONCE);
        }
        check_second_lease(b, maps);
        frame_drop(&b->frame);
        run(b);
    }
    b->rate = b->lobes = false;
}

/* Dropped while it decides, or in a later round. */
TEST(a_target_may_be_dropped)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->path_spp = 9;
    b->target = 0.05f;
    for (unsigned rounds = 0; rounds < 2; rounds++) {
        b->extended = 0;
        begin(b, 32);
        while (b->extended < rounds || frame_tiles_waiting(b->frame) > 0) {
            while (lease(b, 1, ~0u, &tile)) send_tile(b, 1, &tile, 0);
            uv_run(&b->loop, UV_RUN_ONCE);
            if (b->extended == rounds && frame_tiles_waiting(b->frame) == 0) break;
        }
        frame_drop(&b->frame);
        run(b);
    }
    assert_int_equal(b->failed, 0);
}
