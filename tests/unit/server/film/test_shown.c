/* Patches of surfaces alone: they end around what is shown, however the picture is cut into tiles.
 */
#include <string.h>

#include "server/film/film.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

enum { WIDTH = 100, HEIGHT = 70, BLOCK = 64, HALO = 20, MARGIN = 3 };

/* Lands all tiles; surfaces are in `shown` alone. */
static struct film *land_all(struct plan *plan, int32_t tile_px, struct rect shown)
{
    struct film *film;
    struct tile_grid grid;
    synthetic_paths_plan(plan, WIDTH, HEIGHT, tile_px, 4);
    assert_int_equal(film_create(plan, BLOCK, 2, HALO, &film), 0);
    assert_int_equal(tile_grid_init(&grid, WIDTH, HEIGHT, tile_px), 0);
    for (uint32_t tile = 0; tile < tile_grid_count(&grid); tile++) {
        struct samples *s = synthetic_pass(plan, tile, 0);
        const struct rect r = tile_grid_rect(&grid, tile);
        float *coverage = samples_f32(s, PLANE_PATH_COVERAGE, 0);
        for (int32_t i = 0; i < rect_area(r); i++) {
            const int32_t x = r.x0 + i % rect_width(r), y = r.y0 + i / rect_width(r);
            coverage[i] = x >= shown.x0 && x < shown.x1 && y >= shown.y0 && y < shown.y1 ? 2 : 0;
        }
        assert_int_equal(film_land(film, tile, 0, s), 0);
    }
    return film;
}

static void assert_rect(struct rect r, int32_t x0, int32_t y0, int32_t x1, int32_t y1)
{
    assert_int_equal(r.x0, x0);
    assert_int_equal(r.y0, y0);
    assert_int_equal(r.x1, x1);
    assert_int_equal(r.y1, y1);
}

TEST(patches_end_around_what_is_shown)
{
    /* The last two blocks show nothing; the second shows a part of which the first's halo has 20.
     */
    static const struct rect expected[][2] = {{{50, 30, 64, 40}, {47, 27, 84, 43}},
                                              {{64, 30, 90, 40}, {47, 27, 93, 43}}};
    for (int32_t tile_px = 16; tile_px <= 64; tile_px *= 2) {
        struct plan plan;
        struct film *film = land_all(&plan, tile_px, (struct rect){50, 30, 90, 40});
        uint32_t block, blocks = 0;
        while (film_next_ready(film, &block)) {
            struct rect shown;
            struct patch *patch;
            assert_int_equal(film_gather_shown(film, block, MARGIN, &shown, &patch), 0);
            blocks++;
            if (block >= 2) {
                assert_true(rect_is_empty(shown));
                assert_null(patch);
            } else {
                const struct rect *e = expected[block];
                assert_rect(shown, e[0].x0, e[0].y0, e[0].x1, e[0].y1);
                assert_rect(patch->rect, e[1].x0, e[1].y0, e[1].x1, e[1].y1);
                const size_t i = patch_pixel(patch, shown.x0, 35);
                assert_true(patch->path_radiance[1][i] ==
                            synthetic_passes_sum(&plan, PLANE_PATH_RADIANCE, shown.x0, 35, 1, 1));
            }
            patch_destroy(&patch);
            film_block_done(film, block);
        }
        assert_int_equal(blocks, 4);
        film_destroy(&film);
    }
}

TEST(nothing_shown_has_no_patch)
{
    struct plan plan;
    struct film *film = land_all(&plan, 32, (struct rect){0, 0, 0, 0});
    uint32_t block;
    while (film_next_ready(film, &block)) {
        struct rect shown;
        struct patch *patch;
        assert_int_equal(film_gather_shown(film, block, MARGIN, &shown, &patch), 0);
        assert_true(rect_is_empty(shown));
        assert_null(patch);
        film_block_done(film, block);
    }
    assert_true(film_complete(film));
    film_destroy(&film);
}
