/* Cuts into blocks: constants stay constants, no cut of the image and no thread changes a bit, and
 * what blocks cost. */
#include <math.h>
#include <stdlib.h>

#include "proto/runtime/thread_pool.h"
#include "tests/unit/server/reconstruct/block_scene.h"
#include "tests/unit/unit.h"

TEST(a_constant_field_stays_constant)
{
    static const int32_t sizes[][2] = {{70, 70}, {1, 1}, {1, 40}, {67, 1}, {2, 3}};
    for (uint32_t subs = 0; subs <= 3; subs++) {
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            struct plan plan;
            struct block_statistics sum;
            struct world world = plain;
            world.tilt = 1.1f;
            make_plan(&plan, sizes[i][0], sizes[i][1]);
            plan.sub_samples = subs;
            if (subs == 0)
                plan.planes &= ~(PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) |
                                 PLANE_BIT(SUB_ALBEDO) | PLANE_BIT(SUB_ID));
            struct image *image = render(&plan, &world, 16, 0, &sum, NULL);
            float first = picture_at(image, "R", 0, 0);
            assert_true(fabsf(first - 0.5f) < 1e-4f);
            for (int32_t y = 0; y < plan.height_px; y++) {
                for (int32_t x = 0; x < plan.width_px; x++) {
                    assert_true(picture_at(image, "G", x, y) == first);
                    assert_true(picture_at(image, "A", x, y) == 1.0f);
                }
            }
            assert_int_equal(sum.sub_samples_unmatched, 0);
            assert_int_equal(sum.pixels_background, 0);
            image_destroy(&image);
        }
    }
}

static void assert_same(const struct image *a, const struct image *b)
{
    size_t pixels = (size_t)a->width_px * (size_t)a->height_px;
    assert_int_equal(a->channel_count, b->channel_count);
    assert_memory_equal(a->data, b->data, pixels * a->channel_count * sizeof(float));
}

/* Tiles land on one thread while blocks are gathered and reconstructed on others. */
struct threaded_block {
    struct pool_task task;
    const struct plan *plan;
    struct film *film;
    struct image *image;
    uint32_t block;
};

static void run_block(struct pool_task *task)
{
    struct threaded_block *b = (struct threaded_block *)task;
    struct patch *patch;
    struct block_statistics statistics;
    if (film_gather(b->film, b->block, &patch)) return;
    block_reconstruct(b->plan, patch, film_block_rect(b->film, b->block), b->image, &statistics);
    patch_destroy(&patch);
}

static void block_done(struct pool_task *task)
{
    struct threaded_block *b = (struct threaded_block *)task;
    film_block_done(b->film, b->block);
    free(b);
}

TEST(threads_make_the_same_picture)
{
    struct plan plan;
    struct film *film;
    struct image *image;
    struct thread_pool *pool;
    struct tile_grid grid;
    uv_loop_t loop;
    uint32_t block;
    synthetic_plan(&plan, 200, 150, 16);
    struct image *expected = render(&plan, NULL, 64, 0, NULL, NULL);
    tile_grid_init(&grid, 200, 150, 16);
    assert_int_equal(uv_loop_init(&loop), 0);
    assert_int_equal(thread_pool_create(&loop, "test", 4, NULL, &pool), 0);
    assert_int_equal(film_create(&plan, 64, 1, 1, &film), 0);
    assert_int_equal(image_create(ALL_LAYERS, 200, 150, &image), 0);
    for (uint32_t t = tile_grid_count(&grid); t-- > 0;) {
        assert_int_equal(film_land(film, t, 0, synthetic_tile(&plan, t)), 0);
        while (film_next_ready(film, &block)) {
            struct threaded_block *b = malloc(sizeof *b);
            *b = (struct threaded_block){
                {.run = run_block, .done = block_done}, &plan, film, image, block};
            thread_pool_submit(pool, &b->task);
        }
        uv_run(&loop, UV_RUN_NOWAIT);
    }
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_true(film_complete(film));
    assert_int_equal(film_bytes(film), 0);
    assert_same(expected, image);
    thread_pool_destroy(&pool);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_int_equal(uv_loop_close(&loop), 0);
    film_destroy(&film);
    image_destroy(&image);
    image_destroy(&expected);
}

TEST(no_cut_changes_a_bit)
{
    struct world world = plain;
    world.edge_x = 60.3f;
    world.slant = -0.37f;
    world.near_light = 10.0f;
    world.near_depth = 4.9f;
    static const int32_t cuts[][3] = {
        {16, 64, 0}, {64, 7, 0}, {32, 64, 5}, {8, 1, 0}, {128, 33, 2}};
    /* Thinner than a pixel: sub-samples look farther for a pixel that matches. */
    struct world thin = world;
    thin.slat_px = 0.3f;
    thin.slant = -0.05f;
    thin.near_depth = 2.0f;
    thin.far_light = 1.0f;
    const struct world *worlds[] = {&world, &thin, NULL};
    for (int n = 0; n < 3; n++) {
        struct plan plan;
        make_plan(&plan, 131, 67);
        struct image *whole = render(&plan, worlds[n], 200, 0, NULL, NULL);
        for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
            plan.tile_px = cuts[i][0];
            struct image *cut = render(&plan, worlds[n], cuts[i][1], cuts[i][2], NULL, NULL);
            assert_same(whole, cut);
            image_destroy(&cut);
        }
        image_destroy(&whole);
    }
}

TEST(it_is_quick)
{
    struct plan plan;
    struct world world = plain;
    double seconds;
    make_plan(&plan, 720, 720);
    world.edge_x = 300.0f;
    world.slant = 0.2f;
    for (int n = 0; n < 2; n++) {
        world.tilt = n ? 1.2f : 0.0f;
        struct image *image = render(&plan, &world, 64, 0, NULL, &seconds);
        print_message("# gather and reconstruction, all layers, tilt %.1f: %.0f ns a pixel\n",
                      (double)world.tilt, seconds / (720.0 * 720.0) * 1e9);
        image_destroy(&image);
    }
}
