/* Passes on the film: sums in their order whatever else happens, spreads as if all samples had come
 * at once, nothing touched while it is read, everything in the last reconstruction. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/film/film.h"
#include "server/film/passes.h"
#include "tests/unit/server/synthetic_paths.h"

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

static bool near(float got, double expected, double relative)
{
    return fabs((double)got - expected) <= relative * expected + 1e-30;
}

/* The merged spread of every pixel is that of all samples taken together, computed in double. */
static void spreads_are_those_of_all_samples(void **state)
{
    static const uint32_t spps[] = {2, 16, 17, 100, 700};
    (void)state;
    for (size_t k = 0; k < sizeof spps / sizeof spps[0]; k++) {
        struct plan plan;
        synthetic_paths_plan(&plan, 5, 4, 8, spps[k]);
        struct samples *sum = synthetic_pass(&plan, 0, 0);
        for (uint32_t p = 1; p < plan_pass_count(&plan); p++) {
            uint32_t first, count;
            struct samples *more = synthetic_pass(&plan, 0, p);
            plan_pass_range(&plan, p, &first, &count);
            passes_add(sum, (struct pass_counts){.paths = first}, more,
                       (struct pass_counts){.paths = count});
            samples_destroy(&more);
        }
        for (int32_t i = 0; i < 20; i++)
            for (uint32_t c = 0; c < 3; c++) {
                const double all = synthetic_spread(i % 5, i / 5, 0, spps[k], c);
                assert_true(near(samples_f32(sum, PLANE_PATH_SPREAD, c)[i], all, 2e-6));
            }
        samples_destroy(&sum);
    }
}

/* A bright pixel with little noise: the difference of means is small beside them. */
static void spreads_keep_their_digits(void **state)
{
    struct plan plan;
    double expected = 0;
    (void)state;
    synthetic_paths_plan(&plan, 1, 1, 8, 4096);
    plan.planes = PLANE_BIT(PATH_RADIANCE) | PLANE_BIT(PATH_SPREAD);
    struct samples_layout layout;
    struct samples *sum, *more;
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 1, 1), 0);
    assert_int_equal(samples_create(&layout, &sum), 0);
    assert_int_equal(samples_create(&layout, &more), 0);
    samples_f32(sum, PLANE_PATH_RADIANCE, 0)[0] = 16 * 1000.0f;
    for (uint32_t p = 1; p < plan_pass_count(&plan); p++) {
        uint32_t first, count;
        plan_pass_range(&plan, p, &first, &count);
        /* Passes of constant radiance 1000 and 1000.5 in turn. */
        const double value = p % 2 ? 1000.5 : 1000.0;
        const double mean = (double)samples_f32(sum, PLANE_PATH_RADIANCE, 0)[0] / first;
        expected += (value - mean) * (value - mean) * first * count / (first + count);
        samples_f32(more, PLANE_PATH_RADIANCE, 0)[0] = (float)(value * count);
        passes_add(sum, (struct pass_counts){.paths = first}, more,
                   (struct pass_counts){.paths = count});
    }
    assert_true(near(samples_f32(sum, PLANE_PATH_SPREAD, 0)[0], expected, 1e-6));
    assert_true(expected > 100 && samples_f32(sum, PLANE_PATH_SPREAD, 1)[0] == 0.0f);
    samples_destroy(&sum);
    samples_destroy(&more);
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
            const struct patch_paths *p = &patch->paths;
            if (passes < least) least = passes;
            for (uint32_t c = 0; c < 3; c++) {
                assert_true(p->radiance[c][i] ==
                            synthetic_passes_sum(plan, PLANE_PATH_RADIANCE, x, y, passes, c));
                assert_true(
                    p->diffuse_indirect[c][i] ==
                    synthetic_passes_sum(plan, PLANE_PATH_DIFFUSE_INDIRECT, x, y, passes, c));
            }
            assert_true(p->coverage[i] ==
                        synthetic_passes_sum(plan, PLANE_PATH_COVERAGE, x, y, passes, 0));
            assert_true(p->open[i] ==
                        synthetic_passes_sum(plan, PLANE_PATH_OCCLUSION, x, y, passes, 0));
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
}

static void tell_story(int32_t width, int32_t height, int32_t tile_px, int32_t block_px,
                       int32_t halo_px, uint32_t spp)
{
    struct story s = {.tiles = 0};
    struct tile_grid grid;
    synthetic_paths_plan(&s.plan, width, height, tile_px, spp);
    assert_int_equal(film_create(&s.plan, block_px, halo_px, &s.film), 0);
    assert_int_equal(tile_grid_init(&grid, width, height, tile_px), 0);
    s.tiles = tile_grid_count(&grid);
    s.passes = plan_pass_count(&s.plan);
    assert_true(s.tiles <= 256 && film_block_count(s.film) <= 256);
    while (!film_complete(s.film)) {
        const uint32_t what = next_random(8);
        uint32_t block;
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

static void any_order_gives_the_same_sums(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        tell_story(40, 24, 8, 16, 0, 100);
        tell_story(33, 20, 16, 8, 0, 130);
        tell_story(40, 24, 8, 16, 1, 40); /* blocks share tiles */
        tell_story(24, 24, 8, 64, 0, 16);
        tell_story(9, 9, 8, 64, 0, 520);
    }
    assert_true(waited > 100);
}

static void passes_wait_while_a_block_reads(void **state)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t block;
    (void)state;
    synthetic_paths_plan(&plan, 8, 8, 8, 100);
    assert_int_equal(film_create(&plan, 8, 0, &film), 0);
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
static void waiting_passes_come_soon(void **state)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t first, second, block;
    (void)state;
    synthetic_paths_plan(&plan, 16, 8, 16, 64);
    assert_int_equal(film_create(&plan, 8, 0, &film), 0);
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
    assert_int_equal(film_create(&plan, 8, 0, &film), 0);
    land(film, &plan, 0, 0);
    assert_true(film_next_ready(film, &first));
    land(film, &plan, 0, 1);
    film_destroy(&film);
}

static void passes_land_in_their_order(void **state)
{
    struct plan plan;
    struct film *film;
    uint32_t block;
    (void)state;
    synthetic_paths_plan(&plan, 8, 8, 8, 33);
    assert_int_equal(film_create(&plan, 8, 0, &film), 0);
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

/* Sums that a hostile worker makes overflow stay where no assertion and no other pixel minds. */
static void hostile_sums_do_no_harm(void **state)
{
    struct plan plan;
    struct samples_layout layout;
    struct samples *sum, *more;
    (void)state;
    synthetic_paths_plan(&plan, 2, 1, 8, 64);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 2, 1), 0);
    assert_int_equal(samples_create(&layout, &sum), 0);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 2, 1), 0);
    assert_int_equal(samples_create(&layout, &more), 0);
    samples_f32(sum, PLANE_PATH_RADIANCE, 0)[0] = 3e38f;
    samples_f32(more, PLANE_PATH_RADIANCE, 0)[0] = 3e38f;
    samples_f32(more, PLANE_PATH_RADIANCE, 0)[1] = 16.0f;
    passes_add(sum, (struct pass_counts){.paths = 16}, more, (struct pass_counts){.paths = 16});
    passes_add(sum, (struct pass_counts){.paths = 32}, more, (struct pass_counts){.paths = 32});
    assert_true(isinf(samples_f32(sum, PLANE_PATH_RADIANCE, 0)[0]));
    assert_true(samples_f32(sum, PLANE_PATH_RADIANCE, 0)[1] == 32.0f);
    samples_destroy(&sum);
    samples_destroy(&more);
}

/* Rays of glossy lobes are as many as bounce rays; what a lobe is the first pass has said. */
static void lobes_are_weighted_by_their_number(void **state)
{
    static const enum plane_id planes[] = {PLANE_GLOSSY_MEAN, PLANE_GLOSSY_HALF,
                                           PLANE_GLOSSY_NEARNESS};
    struct plan plan;
    struct samples_layout layout;
    struct samples *sum, *more;
    (void)state;
    synthetic_target_plan(&plan, 3, 1, 8, 0.1f);
    plan.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_HALF);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 3, 1), 0);
    assert_int_equal(samples_create(&layout, &sum), 0);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 3, 1), 0);
    assert_int_equal(samples_create(&layout, &more), 0);
    for (int k = 0; k < 3; k++)
        for (uint32_t c = 0; c < (k < 2 ? 4u : 1u); c++) {
            samples_u16(sum, planes[k], c)[1] = half_from_float(1.0f + (float)c);
            samples_u16(more, planes[k], c)[1] = half_from_float(4.0f);
        }
    samples_u16(sum, PLANE_GLOSSY_LOBE, 3)[1] = 777;
    passes_add(sum, (struct pass_counts){.paths = 9, .bounces = 9}, more,
               (struct pass_counts){.bounces = 16});
    for (int k = 0; k < 3; k++)
        for (uint32_t c = 0; c < (k < 2 ? 4u : 1u); c++) {
            assert_true(near(half_to_float(samples_u16(sum, planes[k], c)[1]),
                             (9 * (1.0 + c) + 16 * 4.0) / 25, 1e-3));
            assert_int_equal(samples_u16(sum, planes[k], c)[0], 0);
        }
    assert_int_equal(samples_u16(sum, PLANE_GLOSSY_LOBE, 3)[1], 777);
    samples_destroy(&sum);
    samples_destroy(&more);
}

/* Halves are means: each counts as often as it was sampled. */
static void bounces_are_weighted_by_their_number(void **state)
{
    struct plan plan;
    struct samples_layout layout;
    struct samples *sum, *more;
    (void)state;
    synthetic_target_plan(&plan, 3, 1, 8, 0.1f);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 3, 1), 0);
    assert_int_equal(samples_create(&layout, &sum), 0);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 3, 1), 0);
    assert_int_equal(samples_create(&layout, &more), 0);
    assert_int_equal(layout.planes & ~PLANES_PATH,
                     PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(REFLECTOR) | PLANE_BIT(OPEN));
    for (uint32_t c = 0; c < 6; c++) {
        samples_u16(sum, PLANE_INDIRECT_HALVES, c)[0] = half_from_float(1.0f);
        samples_u16(more, PLANE_INDIRECT_HALVES, c)[0] = half_from_float(4.0f);
        samples_u16(sum, PLANE_INDIRECT_HALVES, c)[1] = half_from_float(65504.0f);
        samples_u16(more, PLANE_INDIRECT_HALVES, c)[1] = half_from_float(65504.0f);
    }
    samples_u16(sum, PLANE_REFLECTOR, 0)[0] = half_from_float(REFLECTOR_NONE);
    samples_u16(more, PLANE_REFLECTOR, 0)[0] = half_from_float(2.0f);
    samples_u16(sum, PLANE_REFLECTOR, 0)[1] = half_from_float(0.5f);
    samples_u16(more, PLANE_REFLECTOR, 0)[1] = half_from_float(3.0f);
    samples_u16(more, PLANE_OPEN, 0)[0] = half_from_float(1.0f);
    passes_add(sum, (struct pass_counts){.paths = 9, .bounces = 9}, more,
               (struct pass_counts){.bounces = 16});
    assert_true(near(half_to_float(samples_u16(sum, PLANE_INDIRECT_HALVES, 0)[0]),
                     (5 * 1.0 + 8 * 4.0) / 13, 1e-3));
    assert_true(near(half_to_float(samples_u16(sum, PLANE_INDIRECT_HALVES, 3)[0]),
                     (4 * 1.0 + 8 * 4.0) / 12, 1e-3));
    assert_true(half_to_float(samples_u16(sum, PLANE_INDIRECT_HALVES, 5)[1]) == 65504.0f);
    assert_true(half_to_float(samples_u16(sum, PLANE_REFLECTOR, 0)[0]) == 2.0f);
    assert_true(half_to_float(samples_u16(sum, PLANE_REFLECTOR, 0)[1]) == 0.5f);
    assert_true(near(half_to_float(samples_u16(sum, PLANE_OPEN, 0)[0]), 16.0 / 25, 1e-3));
    assert_true(samples_f32(sum, PLANE_PATH_RADIANCE, 0)[0] == 0.0f);
    samples_destroy(&sum);
    samples_destroy(&more);
}

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

/* Of a second set each pixel counts by its own rays. */
static void second_sets_are_weighted_pixel_by_pixel(void **state)
{
    static const uint8_t sides[] = {0, 3, 255, 1};
    struct plan plan;
    struct samples_layout layout;
    struct samples *sum, *more;
    (void)state;
    synthetic_rate_plan(&plan, 4, 1, 8, 9);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 4, 1), 0);
    assert_int_equal(samples_create(&layout, &sum), 0);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 4, 1), 0);
    assert_int_equal(samples_create(&layout, &more), 0);
    assert_int_equal(layout.planes, PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(OPEN));
    for (int i = 0; i < 4; i++) {
        for (uint32_t c = 0; c < 3; c++) {
            samples_u16(sum, PLANE_INDIRECT_MEAN, c)[i] = half_from_float(1.0f);
            samples_u16(more, PLANE_INDIRECT_MEAN, c)[i] = half_from_float(sides[i] ? 4.0f : 0.0f);
        }
        samples_u16(sum, PLANE_OPEN, 0)[i] = half_from_float(1.0f);
        samples_u16(sum, PLANE_REFLECTOR, 0)[i] = half_from_float(2.0f);
        samples_f32(sum, PLANE_PATH_RADIANCE, 0)[i] = 5.0f;
    }
    const struct plan_pass pass = {.number = 1, .strata = 255, .sides = sides};
    struct pass_counts counts = {.paths = 9, .bounces = 16}, second = pass_counts_of(&pass);
    assert_true(second.bounces == 0 && second.paths == 0);
    passes_add(sum, counts, more, second);
    pass_counts_add(&counts, &second);
    assert_true(counts.bounces == 16 && counts.paths == 9 && counts.sides == sides);
    for (int i = 0; i < 4; i++) {
        const double n = sides[i] * sides[i];
        for (uint32_t c = 0; c < 3; c++)
            assert_true(near(half_to_float(samples_u16(sum, PLANE_INDIRECT_MEAN, c)[i]),
                             (16.0 + 4.0 * n) / (16.0 + n), 1e-3));
        assert_true(
            near(half_to_float(samples_u16(sum, PLANE_OPEN, 0)[i]), 16.0 / (16.0 + n), 2e-3));
        assert_true(half_to_float(samples_u16(sum, PLANE_REFLECTOR, 0)[i]) == 2.0f);
        assert_true(samples_f32(sum, PLANE_PATH_RADIANCE, 0)[i] == 5.0f);
    }
    samples_destroy(&sum);
    samples_destroy(&more);
}

/* Those of glossy lobes by theirs, light and weights alike. */
static void second_sets_of_lobes_are_weighted_by_their_own(void **state)
{
    static const uint8_t sides[] = {9, 0, 2, 0}, lobes[] = {0, 3, 255, 1};
    struct plan plan;
    struct samples_layout layout;
    struct samples *sum, *more;
    (void)state;
    synthetic_rate_plan(&plan, 4, 1, 8, 9);
    plan.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_SPAN);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 4, 1), 0);
    assert_int_equal(samples_create(&layout, &sum), 0);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 4, 1), 0);
    assert_int_equal(samples_create(&layout, &more), 0);
    assert_int_equal(layout.planes,
                     PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(OPEN) | PLANE_BIT(GLOSSY_MEAN));
    for (int i = 0; i < 4; i++) {
        for (uint32_t c = 0; c < 4; c++) {
            samples_u16(sum, PLANE_GLOSSY_MEAN, c)[i] = half_from_float(1.0f);
            samples_u16(more, PLANE_GLOSSY_MEAN, c)[i] = half_from_float(lobes[i] ? 3.0f : 0.0f);
        }
        samples_u16(sum, PLANE_GLOSSY_NEARNESS, 0)[i] = half_from_float(0.5f);
    }
    const struct plan_pass pass = {.number = 1, .strata = 255, .sides = sides, .lobes = lobes};
    struct pass_counts counts = {.paths = 9, .bounces = 16}, second = pass_counts_of(&pass);
    passes_add(sum, counts, more, second);
    pass_counts_add(&counts, &second);
    assert_true(counts.bounces == 16 && counts.sides == sides && counts.lobes == lobes);
    for (int i = 0; i < 4; i++) {
        const double n = lobes[i] * lobes[i];
        for (uint32_t c = 0; c < 4; c++)
            assert_true(near(half_to_float(samples_u16(sum, PLANE_GLOSSY_MEAN, c)[i]),
                             (16.0 + 3.0 * n) / (16.0 + n), 1e-3));
        assert_true(half_to_float(samples_u16(sum, PLANE_GLOSSY_NEARNESS, 0)[i]) == 0.5f);
    }
    samples_destroy(&sum);
    samples_destroy(&more);
}

/* Of second sets through the lens the means stand by themselves, and the shares of what meets a
 * surface are weighted. */
static void second_sets_through_the_lens_land(void **state)
{
    static const uint8_t sides[] = {0, 6, 0, 6};
    const struct plan plan = {.width_px = 4,
                              .height_px = 1,
                              .tile_px = 32,
                              .lens_strata_per_axis = 2,
                              .lens_extra = 9,
                              .planes = PLANES_LENS | PLANES_LENS_MORE};
    struct samples_layout layout;
    struct samples *sum, *more;
    (void)state;
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 4, 1), 0);
    assert_int_equal(samples_create(&layout, &sum), 0);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 4, 1), 0);
    assert_true(layout.planes == PLANES_LENS_MORE);
    assert_int_equal(samples_create(&layout, &more), 0);
    for (int i = 0; i < 4; i++) {
        samples_f32(sum, PLANE_LENS_RADIANCE, 5)[i] = 3.0f;
        samples_u16(sum, PLANE_LENS_COVERAGE, 0)[i] = half_from_float(1.0f);
        for (uint32_t c = 0; c < 4; c++)
            samples_f32(more, PLANE_LENS_MORE, c)[i] = sides[i] ? (float)c + 1.0f : 0.0f;
    }
    const struct plan_pass pass = {.number = 1, .strata = 6, .sides = sides};
    passes_add(sum, (struct pass_counts){0}, more, pass_counts_of(&pass));
    for (int i = 0; i < 4; i++) {
        const float seen = half_to_float(samples_u16(sum, PLANE_LENS_COVERAGE, 0)[i]);
        for (uint32_t c = 0; c < 4; c++)
            assert_true(samples_f32(sum, PLANE_LENS_MORE, c)[i] ==
                        (sides[i] ? (float)c + 1.0f : 0.0f));
        assert_true(samples_f32(sum, PLANE_LENS_RADIANCE, 5)[i] == 3.0f);
        assert_true(near(seen, sides[i] ? 4.0 / 40.0 : 1.0, 1e-3));
    }
    samples_destroy(&sum);
    samples_destroy(&more);
}

/* Blocks read how many rays each pixel has. */
static void patches_tell_of_second_sets(void **state)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t block, more[4] = {0, 1, 0, 0};
    uint8_t sides[32 * 32] = {0};
    (void)state;
    synthetic_rate_plan(&plan, 64, 64, 32, 0);
    assert_int_equal(film_create(&plan, 64, 1, &film), 0);
    const struct plan_pass first = plan_scheduled_pass(&plan, 0);
    for (uint32_t t = 0; t < 4; t++) land_pass(film, &plan, t, &first);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_true(patch->bounces[0] == 16.0f && patch->bounces[64 * 64 - 1] == 16.0f);
    assert_true(patch->reflector_far && patch->reflector_far[1] >= patch->reflector[1]);
    patch_destroy(&patch);
    assert_true(film_block_done(film, block) && film_complete(film));
    sides[5] = 3;
    sides[31 * 32 + 31] = 7;
    const struct plan_pass second = {.number = 1, .strata = 7, .sides = sides};
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
static void rounds_settle_blocks_again(void **state)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    uint32_t block, more[16] = {0};
    (void)state;
    synthetic_target_plan(&plan, 64, 64, 16, 0.1f);
    assert_int_equal(film_create(&plan, 32, 1, &film), 0);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spreads_are_those_of_all_samples),
        cmocka_unit_test(bounces_are_weighted_by_their_number),
        cmocka_unit_test(lobes_are_weighted_by_their_number),
        cmocka_unit_test(rounds_settle_blocks_again),
        cmocka_unit_test(second_sets_are_weighted_pixel_by_pixel),
        cmocka_unit_test(second_sets_of_lobes_are_weighted_by_their_own),
        cmocka_unit_test(second_sets_through_the_lens_land),
        cmocka_unit_test(patches_tell_of_second_sets),
        cmocka_unit_test(spreads_keep_their_digits),
        cmocka_unit_test(any_order_gives_the_same_sums),
        cmocka_unit_test(passes_wait_while_a_block_reads),
        cmocka_unit_test(waiting_passes_come_soon),
        cmocka_unit_test(passes_land_in_their_order),
        cmocka_unit_test(hostile_sums_do_no_harm),
    };
    return cmocka_run_group_tests_name("passes", tests, NULL, NULL);
}
