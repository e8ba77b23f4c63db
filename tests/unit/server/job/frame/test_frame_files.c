/* A frame's stored files: their bytes do not tell how it was cut into tiles, in what order these
 * came or what was in memory before; who holds them. */
#include "server/reconstruct/patch/scratch.h"
#include "tests/unit/server/job/frame/frame_fixture.h"
#include "tests/unit/unit.h"

static bool is_nobodys(void *ctx, const struct digest *d)
{
    (void)ctx, (void)d;
    return true;
}

EACH_TEST(bench_set_up, bench_tear_down);

TEST(files_are_held_by_who_is_told_of_them)
{
    struct bench *b = *state;
    render_in_order(b, 64);
    const struct digest *const files[] = {&b->exr, &b->png};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(objects_remove(&b->objects, files[i], is_nobodys, NULL), ERR_STATE);
        objects_release(&b->objects, files[i]);
        assert_int_equal(objects_remove(&b->objects, files[i], is_nobodys, NULL), 0);
        assert_false(objects_have(&b->objects, files[i], NULL));
    }
}

TEST(tiles_of_any_size_give_the_same_files)
{
    struct bench *b = *state;
    render_in_order(b, 32);
    struct digest exr = b->exr, png = b->png;
    static const int32_t sizes[] = {8, 16, 64, 100, 256};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        b->accepted = b->encoded = b->traced = 0;
        b->drawn_px = 0;
        render_in_order(b, sizes[i]);
        assert_true(digest_equal(&exr, &b->exr));
        assert_true(digest_equal(&png, &b->png));
    }
    assert_true(objects_have(&b->objects, &exr, NULL) && objects_have(&b->objects, &png, NULL));
}

TEST(filters_do_not_see_tiles)
{
    struct bench *b = *state;
    static const int32_t sizes[] = {8, 64, 100};
    b->lights = 3; /* two of them rectangles */
    for (b->filter = SHADOW_FILTER_AXIS_ALIGNED; b->filter <= SHADOW_FILTER_SHEARED; b->filter++) {
        clear_counts(b);
        render_in_order(b, 32);
        const struct digest exr = b->exr, png = b->png;
        const struct statistics first = b->statistics;
        assert_true(first.shadow_pixels_filtered > 1000);
        assert_true(first.shadow_pixels_filtered + first.shadow_pixels_alone +
                        first.shadow_pixels_unlit >=
                    2 * 203 * 131);
        assert_true(first.shadow_cpu_us > 0);
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            clear_counts(b);
            render_in_order(b, sizes[i]);
            assert_true(digest_equal(&exr, &b->exr));
            assert_true(digest_equal(&png, &b->png));
            assert_true(b->statistics.shadow_pixels_filtered == first.shadow_pixels_filtered);
            assert_true(b->statistics.shadow_pixels_alone == first.shadow_pixels_alone);
            assert_true(b->statistics.shadow_pixels_unlit == first.shadow_pixels_unlit);
            assert_true(b->statistics.shadow_blocks_skipped == first.shadow_blocks_skipped);
        }
    }
}

/* Where no filter runs, none is counted. */
TEST(unfiltered_frames_count_nothing)
{
    struct bench *b = *state;
    render_in_order(b, 32);
    assert_true(b->statistics.reconstruct_cpu_us > 0);
    assert_true(b->statistics.shadow_cpu_us == 0);
    assert_true(b->statistics.shadow_pixels_filtered + b->statistics.shadow_pixels_alone +
                    b->statistics.shadow_pixels_unlit + b->statistics.shadow_blocks_skipped ==
                0);
}

/* Workers that hold many tiles and send them in any order, while the loop runs now and then. */
static void render_paths(struct bench *b, int32_t tile_px, uint32_t spp)
{
    struct fleet_tile held[24];
    unsigned holding = 0;
    uint32_t seed = 11;
    double share = 0;
    b->accepted = b->encoded = b->traced = 0;
    b->path_spp = spp;
    begin(b, tile_px);
    const uint32_t passes = plan_pass_count(&b->plan), total = frame_tiles_total(b->frame);
    while (b->frame) {
        while (b->frame && holding < 24 && lease(b, 1, ~0u, &held[holding])) {
            assert_true(held[holding].pass.number < passes);
            holding++;
        }
        if (holding > 0) {
            seed = seed * 1664525u + 1013904223u;
            const unsigned at = (seed >> 8) % holding;
            assert_int_equal(send_tile(b, 1, &held[at], 0), 0);
            held[at] = held[--holding];
        }
        uv_run(&b->loop, holding == 0 || seed >> 30 == 0 ? UV_RUN_DEFAULT : UV_RUN_NOWAIT);
        if (!b->frame) break;
        assert_true(frame_traced_share(b->frame) >= share && frame_traced_share(b->frame) <= 1.0);
        share = frame_traced_share(b->frame);
        assert_true(share < 1.0 || frame_tiles_landed(b->frame) == total);
    }
    assert_int_equal(b->accepted, total);
    assert_int_equal(b->failed, 0);
    assert_int_equal(b->encoded, 1);
    assert_int_equal(b->traced, 1);
    const unsigned blocks = b->beside ? 1 : 4; /* of 75 x 70 pixels */
    assert_in_range(b->drawn, blocks, blocks * passes);
}

TEST(passes_give_the_same_files_in_any_order)
{
    struct bench *b = *state;
    static const int32_t sizes[] = {8, 256};
    render_paths(b, 32, 300);
    struct digest exr = b->exr, png = b->png;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        render_paths(b, sizes[i], 300);
        assert_true(digest_equal(&exr, &b->exr));
        assert_true(digest_equal(&png, &b->png));
    }
    render_paths(b, 32, 7); /* a single pass */
    render_paths(b, 32, 17);
}

/* A light field is there with the first pass and is filtered anew with each; it counts once. */
TEST(light_fields_beside_paths_do_not_see_tiles)
{
    struct bench *b = *state;
    static const int32_t sizes[] = {8, 256};
    for (b->beside = INDIRECT_FILTER_CONSTANT; b->beside <= INDIRECT_FILTER_BLEND; b->beside++) {
        render_paths(b, 32, 100);
        const struct digest exr = b->exr;
        const struct statistics first = b->statistics;
        assert_true(first.indirect_pixels_filtered > 4000);
        assert_true(first.indirect_pixels_filtered + first.indirect_pixels_skipped == 75 * 70);
        assert_true(first.indirect_cpu_us > 0 && first.shadow_cpu_us == 0);
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            render_paths(b, sizes[i], 100);
            assert_true(digest_equal(&exr, &b->exr));
            assert_true(b->statistics.indirect_pixels_filtered == first.indirect_pixels_filtered);
        }
    }
}

/* What one frame leaves in memory is not seen by the next, also where one was dropped in the midst
 * of its work, and memory may go at any time. */
TEST(frames_share_memory)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->lights = 3;
    b->filter = SHADOW_FILTER_SHEARED;
    render_in_order(b, 64);
    const struct digest exr = b->exr;
    assert_int_equal(scratch_create(&b->scratch), 0);
    for (int round = 0; round < 3; round++) {
        b->lens = round == 1; /* other arrays than the frame that is compared */
        begin(b, 64);
        for (int i = 0; i < 9 && lease(b, 1, ~0u, &tile); i++) send_tile(b, 1, &tile, 0);
        frame_drop(&b->frame);
        scratch_trim(b->scratch, round == 2 ? 0 : (size_t)1 << 20);
        b->lens = false;
        clear_counts(b);
        render_in_order(b, 64);
        assert_true(digest_equal(&exr, &b->exr));
    }
    scratch_destroy(&b->scratch);
}
