/* Passes on the film: sums in their order whatever else happens, nothing touched while it is read,
 * everything in the last reconstruction. */
#include "server/film/film.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

static uint32_t random_state = 1;

static uint32_t next_random(uint32_t below)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (random_state >> 8) % below;
}

static void land(struct film *film, const struct plan *plan, uint32_t tile, uint32_t pass)
{
    struct samples *s = synthetic_pass(plan, tile, pass);
    assert_non_null(s);
    assert_int_equal(film_land(film, tile, pass, s), 0);
}

/* How many passes a patch's pixel holds, by its count of samples. */
static uint32_t passes_of(const struct plan *plan, float spp)
{
    uint32_t passes = 1;
    while ((float)plan_pass_spp(plan, passes) < spp) passes++;
    assert_true((float)plan_pass_spp(plan, passes) == spp);
    return passes;
}

/* Every pixel holds whole passes, added up in their order: to the bit. */
static uint32_t check_patch(const struct plan *plan, const struct patch *patch)
{
    uint32_t least = UINT32_MAX;
    size_t i = 0;
    for (int32_t y = patch->rect.y0; y < patch->rect.y1; y++) {
        for (int32_t x = patch->rect.x0; x < patch->rect.x1; x++, i++) {
            const uint32_t passes = passes_of(plan, patch->paths.spp[i]);
            if (passes < least) least = passes;
            for (uint32_t c = 0; c < 3; c++) {
                assert_true(patch->path_radiance[c][i] ==
                            synthetic_passes_sum(plan, PLANE_PATH_RADIANCE, x, y, passes, c));
                assert_true(
                    patch->path_diffuse_indirect[c][i] ==
                    synthetic_passes_sum(plan, PLANE_PATH_DIFFUSE_INDIRECT, x, y, passes, c));
            }
            assert_true(patch->path_coverage[i] ==
                        synthetic_passes_sum(plan, PLANE_PATH_COVERAGE, x, y, passes, 0));
            assert_true(patch->path_visibility[i] ==
                        synthetic_passes_sum(plan, PLANE_PATH_VISIBILITY, x, y, passes, 0));
            assert_true(patch->depth[i] == synthetic_pixel(plan, x, y).depth);
        }
    }
    return least;
}

/* Passes that waited for a reader, over all stories: else they would show nothing. */
static uint64_t waited;

struct story {
    struct plan plan;
    struct film *film;
    uint32_t tiles, passes;
    uint32_t next[256];  /* pass of each tile */
    uint32_t drawn[256]; /* times, of each block */
    uint32_t out[8], out_count;
    uint64_t now_us;
};

static void land_any(struct story *s)
{
    const uint32_t start = next_random(s->tiles);
    for (uint32_t i = 0; i < s->tiles; i++) {
        const uint32_t tile = (start + i) % s->tiles;
        if (s->next[tile] == s->passes) continue;
        land(s->film, &s->plan, tile, s->next[tile]++);
        break;
    }
    waited += film_pending(s->film) > 0;
}

/* Whatever has landed since it went out, a block reads what was there then. */
static void finish_any(struct story *s)
{
    const uint32_t at = next_random(s->out_count), block = s->out[at];
    struct patch *patch;
    assert_int_equal(film_gather(s->film, block, &patch), 0);
    const uint32_t least = check_patch(&s->plan, patch);
    patch_destroy(&patch);
    s->drawn[block]++;
    s->out[at] = s->out[--s->out_count];
    assert_int_equal(film_block_done(s->film, block), least == s->passes);
    film_rest(s->film, block,
              s->now_us + next_random(40)); /* some until a later pass, or the last */
}

static void tell_story(int32_t width, int32_t height, int32_t tile_px, int32_t block_px,
                       int32_t halo_px, uint32_t spp)
{
    struct story s = {.tiles = 0};
    struct tile_grid grid;
    synthetic_paths_plan(&s.plan, width, height, tile_px, spp);
    assert_int_equal(film_create(&s.plan, block_px, halo_px, halo_px, &s.film), 0);
    assert_int_equal(tile_grid_init(&grid, width, height, tile_px), 0);
    s.tiles = tile_grid_count(&grid);
    s.passes = plan_pass_count(&s.plan);
    assert_true(s.tiles <= 256 && film_block_count(s.film) <= 256);
    while (!film_complete(s.film)) {
        const uint32_t what = next_random(8);
        uint32_t block;
        film_tell_time(s.film, s.now_us++);
        if (what < 4)
            land_any(&s);
        else if (what < 6 && s.out_count < 8 && film_next_ready(s.film, &block))
            s.out[s.out_count++] = block;
        else if (s.out_count > 0)
            finish_any(&s);
    }
    for (uint32_t b = 0; b < film_block_count(s.film); b++)
        assert_in_range(s.drawn[b], 1, s.passes);
    assert_int_equal(film_bytes(s.film), 0);
    assert_int_equal(film_pending(s.film), 0);
    film_destroy(&s.film);
}

TEST(any_order_gives_the_same_sums)
{
    for (int i = 0; i < 4; i++) {
        tell_story(40, 24, 8, 16, 0, 100);
        tell_story(33, 20, 16, 8, 0, 130);
        tell_story(40, 24, 8, 16, 1, 40); /* blocks share tiles */
        tell_story(24, 24, 8, 64, 0, 16);
        tell_story(9, 9, 8, 64, 0, 520);
    }
    assert_true(waited > 100);
}

TEST(passes_wait_while_a_block_reads)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t block;
    synthetic_paths_plan(&plan, 8, 8, 8, 100);
    assert_int_equal(film_create(&plan, 8, 0, 0, &film), 0);
    land(film, &plan, 0, 0);
    const uint64_t one_tile = film_bytes(film);
    assert_true(film_next_ready(film, &block));
    land(film, &plan, 0, 1);
    land(film, &plan, 0, 2);
    assert_int_equal(film_pending(film), 2);
    assert_true(film_bytes(film) > one_tile);
    assert_false(film_next_ready(film, &block)); /* it is out: not twice */
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_true(patch->paths.spp[0] == 16.0f);
    assert_int_equal(check_patch(&plan, patch), 1);
    patch_destroy(&patch);
    assert_false(film_block_done(film, block));
    assert_int_equal(film_pending(film), 0);
    assert_int_equal(film_bytes(film), one_tile);
    assert_true(film_next_ready(film, &block)); /* both at once */
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_true(patch->paths.spp[0] == 64.0f);
    patch_destroy(&patch);
    assert_false(film_block_done(film, block));
    assert_false(film_next_ready(film, &block));
    land(film, &plan, 0, 3);
    assert_true(film_next_ready(film, &block));
    assert_true(film_block_done(film, block));
    assert_true(film_complete(film));
    assert_int_equal(film_bytes(film), 0);
    film_destroy(&film);
}

/* Two blocks read one tile: while one is out and a pass waits, the other is not handed out. */
TEST(waiting_passes_come_soon)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t first, second, block;
    synthetic_paths_plan(&plan, 16, 8, 16, 64);
    assert_int_equal(film_create(&plan, 8, 0, 0, &film), 0);
    land(film, &plan, 0, 0);
    assert_true(film_next_ready(film, &first));
    land(film, &plan, 0, 1);
    assert_false(film_next_ready(film, &second));
    assert_false(film_block_done(film, first));
    assert_int_equal(film_pending(film), 0);
    for (int i = 0; i < 2; i++) {
        assert_true(film_next_ready(film, &block));
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_true(patch->paths.spp[0] == 32.0f);
        patch_destroy(&patch);
        assert_false(film_block_done(film, block));
    }
    assert_false(film_next_ready(film, &block));
    film_destroy(&film); /* also with what waits */
    assert_int_equal(film_create(&plan, 8, 0, 0, &film), 0);
    land(film, &plan, 0, 0);
    assert_true(film_next_ready(film, &first));
    land(film, &plan, 0, 1);
    film_destroy(&film);
}

/* Draws while a block rests are left out, its last one never. */
TEST(blocks_rest_until_their_last_time)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t block;
    synthetic_paths_plan(&plan, 8, 8, 8, 150);
    const uint32_t passes = plan_pass_count(&plan);
    assert_int_equal(passes, 5);
    assert_int_equal(film_create(&plan, 8, 0, 0, &film), 0);
    land(film, &plan, 0, 0);
    assert_true(film_next_ready(film, &block)); /* the first comes at once */
    assert_false(film_block_done(film, block));
    film_rest(film, block, 1000);
    film_tell_time(film, 999);
    land(film, &plan, 0, 1);
    assert_false(film_next_ready(film, &block));
    film_tell_time(film, 1000);
    assert_false(film_next_ready(film, &block)); /* it waits for a further pass */
    land(film, &plan, 0, 2);
    assert_true(film_next_ready(film, &block));
    film_rest(film, block, UINT64_MAX);
    land(film, &plan, 0, 3); /* pending */
    assert_false(film_block_done(film, block));
    assert_false(film_next_ready(film, &block));
    assert_false(film_complete(film));
    land(film, &plan, 0, 4);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_int_equal(check_patch(&plan, patch), passes);
    patch_destroy(&patch);
    assert_true(film_block_done(film, block) && film_complete(film));
    film_destroy(&film);
}

TEST(passes_land_in_their_order)
{
    struct plan plan;
    struct film *film;
    uint32_t block;
    synthetic_paths_plan(&plan, 8, 8, 8, 33);
    assert_int_equal(film_create(&plan, 8, 0, 0, &film), 0);
    struct samples *later = synthetic_pass(&plan, 0, 1), *first = synthetic_pass(&plan, 0, 0);
    assert_int_equal(film_land(film, 0, 1, later), ERR_RANGE);
    assert_int_equal(film_land(film, 0, 0, later), ERR_MISMATCH); /* only paths */
    assert_int_equal(film_land(film, 0, 0, first), 0);
    first = synthetic_pass(&plan, 0, 0);
    assert_int_equal(film_land(film, 0, 0, first), ERR_EXISTS);
    assert_int_equal(film_land(film, 0, 1, first), ERR_MISMATCH);
    assert_int_equal(film_land(film, 0, 1, later), 0);
    land(film, &plan, 0, 2);
    assert_int_equal(film_land(film, 0, 3, first), ERR_RANGE); /* there are three */
    assert_true(film_next_ready(film, &block));
    assert_true(film_block_done(film, block));
    assert_int_equal(film_land(film, 0, 2, first), ERR_EXISTS);
    samples_destroy(&first);
    film_destroy(&film);
}
