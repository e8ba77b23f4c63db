/* Passes of later rounds: blocks that read a tile that got more are made again, and read how many
 * rays each pixel has. */
#include "server/film/film.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

static void land_pass(struct film *film, const struct plan *plan, uint32_t tile,
                      const struct plan_pass *pass)
{
    assert_int_equal(film_land_pass(film, tile, pass, synthetic_pass_of(plan, tile, pass)), 0);
}

static unsigned settle(struct film *film)
{
    uint32_t block;
    unsigned count = 0;
    struct patch *patch;
    for (; film_next_ready(film, &block); count++) {
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_true(patch->bounces[0] >= 9.0f && patch->paths.spp[0] >= 9.0f);
        patch_destroy(&patch);
        assert_true(film_block_done(film, block));
    }
    return count;
}

/* Blocks read how many rays each pixel has. */
TEST(patches_tell_of_second_sets)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t block, more[4] = {0, 1, 0, 0};
    uint8_t strata_map[32 * 32] = {0};
    synthetic_rate_plan(&plan, 64, 64, 32, 0);
    assert_int_equal(film_create(&plan, 64, 1, 1, &film), 0);
    const struct plan_pass first = plan_scheduled_pass(&plan, 0);
    for (uint32_t t = 0; t < 4; t++) land_pass(film, &plan, t, &first);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_true(patch->bounces[0] == 16.0f && patch->bounces[64 * 64 - 1] == 16.0f);
    assert_true(patch->bounce_distance_max &&
                patch->bounce_distance_max[1] >= patch->bounce_distance_min[1]);
    patch_destroy(&patch);
    assert_true(film_block_done(film, block) && film_complete(film));
    strata_map[5] = 3;
    strata_map[31 * 32 + 31] = 7;
    const struct plan_pass second = {.number = 1, .strata = 7, .strata_map = strata_map};
    film_begin_round(film, more);
    land_pass(film, &plan, 1, &second);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    for (int i = 0; i < 64 * 64; i++)
        assert_true(patch->bounces[i] == (i == 37 ? 25.0f : i == 31 * 64 + 63 ? 65.0f : 16.0f));
    patch_destroy(&patch);
    assert_true(film_block_done(film, block) && film_complete(film));
    film_release(film);
    film_destroy(&film);
}

/* Under a target tiles stay, and only blocks that read one that got more are made again. */
TEST(rounds_settle_blocks_again)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t block, more[16] = {0};
    synthetic_target_plan(&plan, 64, 64, 16, 0.1f);
    assert_int_equal(film_create(&plan, 32, 1, 1, &film), 0);
    const struct plan_pass first = plan_scheduled_pass(&plan, 0);
    for (uint32_t t = 0; t < 16; t++) land_pass(film, &plan, t, &first);
    assert_int_equal(settle(film), 4);
    assert_true(film_complete(film));
    const uint64_t bytes = film_bytes(film);
    assert_true(bytes > 0);
    more[0] = 2; /* in the corner of the first block */
    film_begin_round(film, more);
    assert_false(film_complete(film));
    const struct plan_pass a = {1, 9, 7, 4, NULL, NULL}, b = {2, 16, 16, 0, NULL, NULL},
                           c = {3, 32, 4, 0, NULL, NULL};
    struct samples *s = synthetic_pass_of(&plan, 0, &b);
    assert_int_equal(film_land_pass(film, 0, &b, s), ERR_RANGE); /* before its turn */
    assert_int_equal(film_land_pass(film, 5, &a, s), ERR_RANGE); /* was not asked for more */
    land_pass(film, &plan, 0, &a);
    assert_false(film_next_ready(film, &block));
    assert_int_equal(film_land_pass(film, 0, &b, s), 0);
    assert_true(film_next_ready(film, &block) && block == 0);
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_true(patch->paths.spp[0] == 32.0f && patch->bounces[0] == 25.0f);
    assert_true(patch->paths.spp[20] == 9.0f && patch->bounces[20] == 9.0f);
    assert_true(patch->paths.split_spp[0] == 8 + 4 + 16 && patch->paths.split_length[0] > 8.0f);
    patch_destroy(&patch);
    assert_true(film_block_done(film, block));
    assert_true(film_complete(film) && film_bytes(film) == bytes);
    more[0] = 0;
    more[5] = 1; /* all four read it */
    film_begin_round(film, more);
    for (block = 0; block < 4; block++)
        film_rest(film, block, UINT64_MAX); /* each is drawn once a round */
    const struct plan_pass d = {1, 9, 4, 2, NULL, NULL};
    land_pass(film, &plan, 5, &d);
    assert_int_equal(settle(film), 4);
    s = synthetic_pass_of(&plan, 0, &c);
    assert_int_equal(film_land_pass(film, 0, &c, s), ERR_RANGE);
    samples_destroy(&s);
    film_release(film);
    assert_int_equal(film_bytes(film), 0);
    film_destroy(&film);
}
