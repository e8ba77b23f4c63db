/* Sums of passes: spreads as if all samples had come at once, means weighted by how many rays each
 * pass had, pixel by pixel where these differ. */
#include <math.h>

#include "server/film/passes.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

static bool near(float got, double expected, double relative)
{
    return fabs((double)got - expected) <= relative * expected + 1e-30;
}

static struct samples *empty_pass(const struct plan *plan, uint32_t pass)
{
    struct samples_layout layout;
    struct samples *samples;
    assert_int_equal(samples_layout_init(&layout, plan, pass, plan->width_px, plan->height_px), 0);
    assert_int_equal(samples_create(&layout, &samples), 0);
    return samples;
}

/* The merged spread of every pixel is that of all samples taken together, computed in double. */
TEST(spreads_are_those_of_all_samples)
{
    static const uint32_t spps[] = {2, 16, 17, 100, 700};
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
                assert_true(near(samples_f32(sum, PLANE_PATH_M2, c)[i], all, 2e-6));
            }
        samples_destroy(&sum);
    }
}

/* A bright pixel with little noise: the difference of means is small beside them. */
TEST(spreads_keep_their_digits)
{
    struct plan plan;
    double expected = 0;
    synthetic_paths_plan(&plan, 1, 1, 8, 4096);
    plan.planes = PLANE_BIT(PATH_RADIANCE) | PLANE_BIT(PATH_M2);
    struct samples *sum = empty_pass(&plan, 1), *more = empty_pass(&plan, 1);
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
    assert_true(near(samples_f32(sum, PLANE_PATH_M2, 0)[0], expected, 1e-6));
    assert_true(expected > 100 && samples_f32(sum, PLANE_PATH_M2, 1)[0] == 0.0f);
    samples_destroy(&sum);
    samples_destroy(&more);
}

/* Sums that a hostile worker makes overflow stay where no assertion and no other pixel minds. */
TEST(hostile_sums_do_no_harm)
{
    struct plan plan;
    synthetic_paths_plan(&plan, 2, 1, 8, 64);
    struct samples *sum = empty_pass(&plan, 0), *more = empty_pass(&plan, 1);
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
TEST(lobes_are_weighted_by_their_number)
{
    static const enum plane_id planes[] = {PLANE_GLOSSY_MEAN, PLANE_GLOSSY_HALF,
                                           PLANE_GLOSSY_NEARNESS};
    struct plan plan;
    synthetic_target_plan(&plan, 3, 1, 8, 0.1f);
    plan.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_HALF);
    struct samples *sum = empty_pass(&plan, 0), *more = empty_pass(&plan, 1);
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
TEST(bounces_are_weighted_by_their_number)
{
    struct plan plan;
    synthetic_target_plan(&plan, 3, 1, 8, 0.1f);
    struct samples *sum = empty_pass(&plan, 0), *more = empty_pass(&plan, 1);
    assert_int_equal(more->layout.planes & ~PLANES_PATH, PLANE_BIT(INDIRECT_HALVES) |
                                                             PLANE_BIT(BOUNCE_DISTANCE_MIN) |
                                                             PLANE_BIT(AMBIENT_VISIBILITY));
    for (uint32_t c = 0; c < 6; c++) {
        samples_u16(sum, PLANE_INDIRECT_HALVES, c)[0] = half_from_float(1.0f);
        samples_u16(more, PLANE_INDIRECT_HALVES, c)[0] = half_from_float(4.0f);
        samples_u16(sum, PLANE_INDIRECT_HALVES, c)[1] = half_from_float(65504.0f);
        samples_u16(more, PLANE_INDIRECT_HALVES, c)[1] = half_from_float(65504.0f);
    }
    samples_u16(sum, PLANE_BOUNCE_DISTANCE_MIN, 0)[0] = half_from_float(BOUNCE_DISTANCE_NONE);
    samples_u16(more, PLANE_BOUNCE_DISTANCE_MIN, 0)[0] = half_from_float(2.0f);
    samples_u16(sum, PLANE_BOUNCE_DISTANCE_MIN, 0)[1] = half_from_float(0.5f);
    samples_u16(more, PLANE_BOUNCE_DISTANCE_MIN, 0)[1] = half_from_float(3.0f);
    samples_u16(more, PLANE_AMBIENT_VISIBILITY, 0)[0] = half_from_float(1.0f);
    passes_add(sum, (struct pass_counts){.paths = 9, .bounces = 9}, more,
               (struct pass_counts){.bounces = 16});
    assert_true(near(half_to_float(samples_u16(sum, PLANE_INDIRECT_HALVES, 0)[0]),
                     (5 * 1.0 + 8 * 4.0) / 13, 1e-3));
    assert_true(near(half_to_float(samples_u16(sum, PLANE_INDIRECT_HALVES, 3)[0]),
                     (4 * 1.0 + 8 * 4.0) / 12, 1e-3));
    assert_true(half_to_float(samples_u16(sum, PLANE_INDIRECT_HALVES, 5)[1]) == 65504.0f);
    assert_true(half_to_float(samples_u16(sum, PLANE_BOUNCE_DISTANCE_MIN, 0)[0]) == 2.0f);
    assert_true(half_to_float(samples_u16(sum, PLANE_BOUNCE_DISTANCE_MIN, 0)[1]) == 0.5f);
    assert_true(
        near(half_to_float(samples_u16(sum, PLANE_AMBIENT_VISIBILITY, 0)[0]), 16.0 / 25, 1e-3));
    assert_true(samples_f32(sum, PLANE_PATH_RADIANCE, 0)[0] == 0.0f);
    samples_destroy(&sum);
    samples_destroy(&more);
}

/* Of a second set each pixel counts by its own rays. */
TEST(second_sets_are_weighted_pixel_by_pixel)
{
    static const uint8_t strata_map[] = {0, 3, 255, 1};
    struct plan plan;
    synthetic_rate_plan(&plan, 4, 1, 8, 9);
    struct samples *sum = empty_pass(&plan, 0), *more = empty_pass(&plan, 1);
    assert_int_equal(more->layout.planes, PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(AMBIENT_VISIBILITY));
    for (int i = 0; i < 4; i++) {
        for (uint32_t c = 0; c < 3; c++) {
            samples_u16(sum, PLANE_INDIRECT_MEAN, c)[i] = half_from_float(1.0f);
            samples_u16(more, PLANE_INDIRECT_MEAN, c)[i] =
                half_from_float(strata_map[i] ? 4.0f : 0.0f);
        }
        samples_u16(sum, PLANE_AMBIENT_VISIBILITY, 0)[i] = half_from_float(1.0f);
        samples_u16(sum, PLANE_BOUNCE_DISTANCE_MIN, 0)[i] = half_from_float(2.0f);
        samples_f32(sum, PLANE_PATH_RADIANCE, 0)[i] = 5.0f;
    }
    const struct plan_pass pass = {.number = 1, .strata = 255, .strata_map = strata_map};
    struct pass_counts counts = {.paths = 9, .bounces = 16}, second = pass_counts_of(&pass);
    assert_true(second.bounces == 0 && second.paths == 0);
    passes_add(sum, counts, more, second);
    pass_counts_add(&counts, &second);
    assert_true(counts.bounces == 16 && counts.paths == 9 && counts.strata_map == strata_map);
    for (int i = 0; i < 4; i++) {
        const double n = strata_map[i] * strata_map[i];
        for (uint32_t c = 0; c < 3; c++)
            assert_true(near(half_to_float(samples_u16(sum, PLANE_INDIRECT_MEAN, c)[i]),
                             (16.0 + 4.0 * n) / (16.0 + n), 1e-3));
        assert_true(near(half_to_float(samples_u16(sum, PLANE_AMBIENT_VISIBILITY, 0)[i]),
                         16.0 / (16.0 + n), 2e-3));
        assert_true(half_to_float(samples_u16(sum, PLANE_BOUNCE_DISTANCE_MIN, 0)[i]) == 2.0f);
        assert_true(samples_f32(sum, PLANE_PATH_RADIANCE, 0)[i] == 5.0f);
    }
    samples_destroy(&sum);
    samples_destroy(&more);
}

/* Those of glossy lobes by theirs, light and weights alike. */
TEST(second_sets_of_lobes_are_weighted_by_their_own)
{
    static const uint8_t strata_map[] = {9, 0, 2, 0}, lobes[] = {0, 3, 255, 1};
    struct plan plan;
    synthetic_rate_plan(&plan, 4, 1, 8, 9);
    plan.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_SPAN);
    struct samples *sum = empty_pass(&plan, 0), *more = empty_pass(&plan, 1);
    assert_int_equal(more->layout.planes, PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(AMBIENT_VISIBILITY) |
                                              PLANE_BIT(GLOSSY_MEAN));
    for (int i = 0; i < 4; i++) {
        for (uint32_t c = 0; c < 4; c++) {
            samples_u16(sum, PLANE_GLOSSY_MEAN, c)[i] = half_from_float(1.0f);
            samples_u16(more, PLANE_GLOSSY_MEAN, c)[i] = half_from_float(lobes[i] ? 3.0f : 0.0f);
        }
        samples_u16(sum, PLANE_GLOSSY_NEARNESS, 0)[i] = half_from_float(0.5f);
    }
    const struct plan_pass pass = {
        .number = 1, .strata = 255, .strata_map = strata_map, .lobes = lobes};
    struct pass_counts counts = {.paths = 9, .bounces = 16}, second = pass_counts_of(&pass);
    passes_add(sum, counts, more, second);
    pass_counts_add(&counts, &second);
    assert_true(counts.bounces == 16 && counts.strata_map == strata_map && counts.lobes == lobes);
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
TEST(second_sets_through_the_lens_land)
{
    static const uint8_t strata_map[] = {0, 6, 0, 6};
    const struct plan plan = {.width_px = 4,
                              .height_px = 1,
                              .tile_px = 32,
                              .lens_strata_per_axis = 2,
                              .lens_extra = 9,
                              .planes = PLANES_LENS | PLANES_LENS_SECOND_SET};
    struct samples *sum = empty_pass(&plan, 0), *more = empty_pass(&plan, 1);
    assert_true(more->layout.planes == PLANES_LENS_SECOND_SET);
    for (int i = 0; i < 4; i++) {
        samples_f32(sum, PLANE_LENS_RADIANCE, 5)[i] = 3.0f;
        samples_u16(sum, PLANE_LENS_COVERAGE, 0)[i] = half_from_float(1.0f);
        for (uint32_t c = 0; c < 4; c++)
            samples_f32(more, PLANE_LENS_SECOND_SET, c)[i] = strata_map[i] ? (float)c + 1.0f : 0.0f;
    }
    const struct plan_pass pass = {.number = 1, .strata = 6, .strata_map = strata_map};
    passes_add(sum, (struct pass_counts){0}, more, pass_counts_of(&pass));
    for (int i = 0; i < 4; i++) {
        const float seen = half_to_float(samples_u16(sum, PLANE_LENS_COVERAGE, 0)[i]);
        for (uint32_t c = 0; c < 4; c++)
            assert_true(samples_f32(sum, PLANE_LENS_SECOND_SET, c)[i] ==
                        (strata_map[i] ? (float)c + 1.0f : 0.0f));
        assert_true(samples_f32(sum, PLANE_LENS_RADIANCE, 5)[i] == 3.0f);
        assert_true(near(seen, strata_map[i] ? 4.0 / 40.0 : 1.0, 1e-3));
    }
    samples_destroy(&sum);
    samples_destroy(&more);
}
