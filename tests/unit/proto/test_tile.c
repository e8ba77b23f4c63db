/* Rectangles, and grids that cover every pixel once. */
#include <stdlib.h>

#include "proto/error.h"
#include "proto/limits.h"
#include "proto/tile.h"
#include "tests/unit/unit.h"

TEST(rectangles)
{
    struct rect a = {0, 0, 10, 20}, b = {5, 15, 30, 40};
    struct rect both = rect_intersect(a, b);
    assert_int_equal(both.x0, 5);
    assert_int_equal(both.y0, 15);
    assert_int_equal(both.x1, 10);
    assert_int_equal(both.y1, 20);
    assert_false(rect_is_empty(both));
    assert_int_equal(rect_area(both), 25);
    assert_true(rect_is_empty(rect_intersect(a, (struct rect){10, 0, 20, 20})));
    assert_true(rect_is_empty(rect_intersect(a, (struct rect){40, 40, 50, 50})));
    assert_true(rect_is_empty((struct rect){3, 3, 3, 9}));
    struct rect grown = rect_grow(a, 2);
    assert_int_equal(rect_width(grown), 14);
    assert_int_equal(rect_height(grown), 24);
    assert_int_equal(grown.x0, -2);
    assert_true(rect_is_empty(rect_grow(a, -5)));
}

static void check_cover(int32_t width, int32_t height, int32_t side)
{
    struct tile_grid g;
    assert_int_equal(tile_grid_init(&g, width, height, side), ERR_OK);
    uint8_t *hits = calloc((size_t)width * (size_t)height, 1);
    assert_non_null(hits);
    for (uint32_t i = 0; i < tile_grid_count(&g); i++) {
        struct rect r = tile_grid_rect(&g, i);
        assert_false(rect_is_empty(r));
        assert_true(r.x0 >= 0 && r.y0 >= 0 && r.x1 <= width && r.y1 <= height);
        assert_true(rect_width(r) <= side && rect_height(r) <= side);
        for (int32_t y = r.y0; y < r.y1; y++)
            for (int32_t x = r.x0; x < r.x1; x++) hits[(size_t)y * (size_t)width + (size_t)x]++;
    }
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++)
        if (hits[i] != 1) fail_msg("pixel %zu is covered %u times", i, hits[i]);
    free(hits);
}

TEST(grids_cover_every_pixel_once)
{
    static const int32_t sides[] = {8, 16, 31, 64, 256};
    static const int32_t sizes[][2] = {{1, 1}, {7, 9}, {64, 64}, {65, 63}, {300, 17}, {8, 513}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (size_t k = 0; k < sizeof sides / sizeof *sides; k++)
            check_cover(sizes[i][0], sizes[i][1], sides[k]);
}

TEST(grids_know_their_limits)
{
    struct tile_grid g;
    assert_int_equal(tile_grid_init(&g, 0, 10, 16), ERR_RANGE);
    assert_int_equal(tile_grid_init(&g, 10, -1, 16), ERR_RANGE);
    assert_int_equal(tile_grid_init(&g, LIMIT_IMAGE_SIDE_PX + 1, 10, 16), ERR_RANGE);
    assert_int_equal(tile_grid_init(&g, 10, INT32_MAX, 16), ERR_RANGE);
    assert_int_equal(tile_grid_init(&g, 16384, 8193, 16), ERR_RANGE); /* too many pixels */
    assert_int_equal(tile_grid_init(&g, 16384, 8192, LIMIT_TILE_SIDE_MIN_PX), ERR_OK);
    assert_int_equal(tile_grid_count(&g), 2048 * 1024);
    assert_int_equal(tile_grid_init(&g, 10, 10, LIMIT_TILE_SIDE_MIN_PX - 1), ERR_RANGE);
    assert_int_equal(tile_grid_init(&g, 10, 10, LIMIT_TILE_SIDE_PX + 1), ERR_RANGE);
}
