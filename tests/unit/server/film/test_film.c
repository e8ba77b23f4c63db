/* The film: tiles in any order, blocks once, patches the same however the image is cut. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "server/film/film.h"
#include "tests/unit/server/reconstruct/synthetic.h"
#include "tests/unit/unit.h"

static uint32_t random_state = 1;

static uint32_t next_random(uint32_t below)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (random_state >> 8) % below;
}

static void shuffle(uint32_t *items, uint32_t count)
{
    for (uint32_t i = count; i > 1; i--) {
        uint32_t j = next_random(i), t = items[i - 1];
        items[i - 1] = items[j];
        items[j] = t;
    }
}

static void land(struct film *film, const struct plan *plan, uint32_t tile)
{
    struct samples *samples = synthetic_tile(plan, tile);
    assert_int_equal(film_land(film, tile, 0, samples), 0);
}

/* Every pixel of a patch is what the synthetic scene says of it, wherever it is cut. */
static void assert_patch(const struct plan *plan, const struct patch *patch)
{
    size_t i = 0;
    for (int32_t y = patch->rect.y0; y < patch->rect.y1; y++) {
        for (int32_t x = patch->rect.x0; x < patch->rect.x1; x++, i++) {
            struct synthetic_pixel p = synthetic_pixel(plan, x, y);
            assert_true(patch->depth[i] == p.depth);
            assert_int_equal(patch->id[i], p.id);
            for (int c = 0; c < 3; c++) {
                assert_true(fabsf(patch->albedo[c][i] - p.albedo[c]) < 1e-5f);
                assert_true(fabsf(patch->normal[c][i] - p.normal[c]) < 1e-4f);
                assert_true(fabsf(patch->indirect[c][i] - p.indirect[c]) < 1e-3f * p.indirect[c]);
            }
            assert_true(patch->lights[0].irradiance[i] == p.irradiance);
            assert_int_equal(patch->lights[0].visibility[i], p.visibility & 255u);
            for (uint32_t k = 0; k < plan->sub_samples; k++) {
                assert_true(fabsf(patch->sub_depth[k][i] - p.sub_depth[k]) <=
                            2e-3f * p.sub_depth[k]);
                assert_int_equal(patch->sub_id[k][i], synthetic_sub_id(p.id));
            }
        }
    }
}

/* Rows from the top of which no pixel is outside of blocks that were seen. */
static int32_t rows_seen(const struct film *film, const uint8_t *seen, int32_t height)
{
    int32_t rows = height;
    for (uint32_t i = 0; i < film_block_count(film); i++) {
        const int32_t top = film_block_rect(film, i).y0;
        if (!seen[i] && top < rows) rows = top;
    }
    return rows;
}

static void run_film(int32_t width, int32_t height, int32_t tile_px, int32_t block_px,
                     int32_t halo_px)
{
    struct plan plan;
    struct film *film;
    synthetic_plan(&plan, width, height, tile_px);
    assert_int_equal(film_create(&plan, block_px, halo_px, halo_px, &film), 0);
    struct tile_grid grid;
    tile_grid_init(&grid, width, height, tile_px);
    uint32_t tiles = tile_grid_count(&grid), *order = calloc(tiles, sizeof *order);
    for (uint32_t i = 0; i < tiles; i++) order[i] = i;
    shuffle(order, tiles);
    uint32_t done = 0, block;
    uint8_t *seen = calloc(film_block_count(film), 1);
    assert_int_equal(film_rows_done(film), 0);
    for (uint32_t i = 0; i < tiles; i++) {
        land(film, &plan, order[i]);
        while (film_next_ready(film, &block)) {
            struct patch *patch;
            assert_int_equal(seen[block]++, 0);
            assert_int_equal(film_gather(film, block, &patch), 0);
            assert_patch(&plan, patch);
            patch_destroy(&patch);
            assert_false(film_complete(film));
            film_block_done(film, block);
            assert_int_equal(film_rows_done(film), rows_seen(film, seen, height));
            done++;
        }
    }
    assert_int_equal(done, film_block_count(film));
    assert_true(film_complete(film));
    assert_int_equal(film_bytes(film), 0);
    free(order);
    free(seen);
    film_destroy(&film);
    assert_null(film);
}

TEST(patches_are_the_same_however_the_image_is_cut)
{
    static const int32_t cases[][5] = {
        {100, 70, 16, 64, 1}, {100, 70, 32, 64, 0}, {100, 70, 64, 64, 1}, {65, 129, 8, 16, 3},
        {1, 1, 8, 64, 1},     {1, 50, 16, 8, 1},    {130, 1, 16, 64, 1},  {33, 33, 32, 7, 9},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        run_film(cases[i][0], cases[i][1], cases[i][2], cases[i][3], cases[i][4]);
    }
}

/* Under a filter of indirect light, what it reads is there as far as the halo goes. */
static void assert_far(const struct plan *plan, const struct patch *patch)
{
    size_t i = 0;
    for (int32_t y = patch->rect.y0; y < patch->rect.y1; y++) {
        for (int32_t x = patch->rect.x0; x < patch->rect.x1; x++, i++) {
            struct synthetic_pixel p = synthetic_pixel(plan, x, y);
            assert_true(patch->depth[i] == p.depth);
            assert_int_equal(patch->id[i], p.id);
            assert_true(patch->bounce_distance_min[i] == p.bounce_distance_min &&
                        patch->ambient_visibility[i] == p.open);
            for (int c = 0; c < 3; c++) {
                assert_true(fabsf(patch->normal[c][i] - p.normal[c]) < 1e-4f);
                assert_true(fabsf(patch->indirect[c][i] - p.indirect[c]) < 1e-3f * p.indirect[c]);
            }
        }
    }
}

TEST(filters_find_what_they_read)
{
    struct plan plan;
    struct film *film;
    struct tile_grid grid;
    uint32_t block, blocks = 0;
    synthetic_plan(&plan, 130, 100, 16);
    plan.planes |= PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(AMBIENT_VISIBILITY);
    plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    assert_int_equal(film_create(&plan, 32, PATCH_RING_PX, 23, &film), 0);
    tile_grid_init(&grid, 130, 100, 16);
    for (uint32_t i = 0; i < tile_grid_count(&grid); i++) land(film, &plan, i);
    for (; film_next_ready(film, &block); blocks++) {
        struct patch *patch;
        struct rect area = film_block_rect(film, block);
        assert_int_equal(film_gather(film, block, &patch), 0);
        struct rect core = rect_intersect(rect_grow(area, PATCH_RING_PX), patch->rect);
        assert_memory_equal(&patch->core, &core, sizeof core);
        assert_int_equal(patch->rect.x0, area.x0 > 23 ? area.x0 - 23 : 0);
        assert_far(&plan, patch);
        patch_destroy(&patch);
        film_block_done(film, block);
    }
    assert_int_equal(blocks, film_block_count(film));
    assert_int_equal(film_bytes(film), 0);
    film_destroy(&film);
}

TEST(a_tile_counts_once)
{
    struct plan plan;
    struct film *film;
    synthetic_plan(&plan, 64, 64, 32);
    assert_int_equal(film_create(&plan, 32, 0, 0, &film), 0);
    land(film, &plan, 2);
    struct samples *again = synthetic_tile(&plan, 2);
    assert_int_equal(film_land(film, 2, 0, again), ERR_EXISTS);
    uint32_t block;
    assert_true(film_next_ready(film, &block));
    film_block_done(film, block);
    assert_int_equal(film_bytes(film), 0);
    assert_int_equal(film_land(film, 2, 0, again), ERR_EXISTS); /* also when it is freed */
    assert_int_equal(film_land(film, 4, 0, again), ERR_RANGE);
    assert_false(film_next_ready(film, &block));
    samples_destroy(&again);
    film_destroy(&film);
}

TEST(a_tile_of_another_size_is_refused)
{
    struct plan plan;
    struct film *film;
    synthetic_plan(&plan, 50, 64, 32);
    assert_int_equal(film_create(&plan, 64, 1, 1, &film), 0);
    struct samples *first = synthetic_tile(&plan, 0);
    assert_int_equal(film_land(film, 1, 0, first), ERR_MISMATCH); /* the last column is narrower */
    assert_int_equal(film_land(film, 0, 0, first), 0);
    film_destroy(&film); /* frees what has landed */
}

TEST(memory_is_bounded_by_what_is_needed)
{
    struct plan plan;
    struct film *film;
    synthetic_plan(&plan, 64, 1024, 16);
    assert_int_equal(film_create(&plan, 64, 1, 1, &film), 0);
    uint64_t most = 0, tile_bytes = 0;
    for (uint32_t tile = 0; tile < 4 * 64; tile++) {
        uint32_t block;
        land(film, &plan, tile);
        if (!tile_bytes) tile_bytes = film_bytes(film);
        if (film_bytes(film) > most) most = film_bytes(film);
        while (film_next_ready(film, &block)) film_block_done(film, block);
    }
    /* Row by row: a block row of 4 x 4 tiles, its lower halo, and what is kept for the next one. */
    assert_true(most <= tile_bytes * 4 * 6);
    assert_true(film_complete(film));
    film_destroy(&film);
}

TEST(hostile_depths_stay_finite)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    synthetic_plan(&plan, 8, 8, 8);
    assert_int_equal(film_create(&plan, 8, 1, 1, &film), 0);
    struct samples *s = synthetic_tile(&plan, 0);
    for (int i = 0; i < 64; i++) {
        samples_f32(s, PLANE_DEPTH, 0)[i] = 3e38f;
        samples_u16(s, PLANE_SUB_DEPTH, 0)[i] = half_from_float(HALF_MAX);
        samples_u16(s, PLANE_SUB_DEPTH, 1)[i] = half_from_float(SUB_DEPTH_MISS);
    }
    assert_int_equal(film_land(film, 0, 0, s), 0);
    uint32_t block;
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_true(isfinite(patch->depth[0] * patch->depth[0]));
    assert_true(isfinite(patch->sub_depth[0][0] * patch->sub_depth[0][0]));
    assert_true(patch->sub_depth[1][0] == 0.0f);
    assert_true(patch->sub_normal[1][2][0] == 0.0f);
    patch_destroy(&patch);
    film_destroy(&film);
}

/* All that has landed is there to be read, and each block comes once, when it may. */
TEST(blocks_are_held_back)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t block, blocks = 0;
    synthetic_plan(&plan, 150, 70, 32);
    assert_int_equal(film_create(&plan, 64, 2, 5, &film), 0);
    film_hold(film, true);
    for (uint32_t tile = 0; tile < 5 * 3; tile++) {
        land(film, &plan, tile);
        assert_false(film_next_ready(film, &block));
    }
    const struct rect rects[] = {{0, 0, 150, 70}, {63, 31, 65, 33}, {149, 69, 150, 70}};
    for (size_t i = 0; i < sizeof rects / sizeof *rects; i++) {
        assert_int_equal(film_gather_rect(film, rects[i], &patch), 0);
        assert_memory_equal(&patch->rect, &rects[i], sizeof rects[i]);
        assert_patch(&plan, patch);
        patch_destroy(&patch);
    }
    film_hold(film, false);
    while (film_next_ready(film, &block)) {
        blocks++;
        assert_true(film_block_done(film, block));
    }
    assert_int_equal(blocks, film_block_count(film));
    assert_true(film_complete(film) && film_bytes(film) == 0);
    film_destroy(&film);
}

TEST(impossible_films_are_refused)
{
    struct plan plan;
    struct film *film;
    synthetic_plan(&plan, 64, 64, 32);
    assert_int_equal(film_create(&plan, 0, 0, 0, &film), ERR_RANGE);
    assert_int_equal(film_create(&plan, 64, 0, -1, &film), ERR_RANGE);
    plan.tile_px = 1;
    assert_int_equal(film_create(&plan, 64, 1, 1, &film), ERR_RANGE);
    assert_null(film);
}
