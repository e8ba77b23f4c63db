/* Paths: what they must agree on whatever the tiles and passes, and what their parts add up to.
 * Closed forms are in tests/golden. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/path/path_fixture.h"

TEST(tiles_do_not_matter)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    struct traced whole = trace_all(f, &p);
    struct rect odd = {5, 3, 18, 20};
    struct traced part = trace(f, &p, odd);
    for (int32_t y = odd.y0; y < odd.y1; y++)
        for (uint32_t c = 0; c < 3; c++)
            assert_memory_equal(plane(&part, PLANE_PATH_RADIANCE, c) +
                                    (y - odd.y0) * rect_width(odd),
                                plane(&whole, PLANE_PATH_RADIANCE, c) + y * SIDE_PX + odd.x0,
                                (size_t)rect_width(odd) * sizeof(float));
    traced_fini(&part);
    traced_fini(&whole);
    free(f);
}

/* Passes of a job are different samples, all of them, of the same light. */
TEST(passes_continue_each_other)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f), longer = p;
    struct traced t = trace_all(f, &p);
    longer.paths.spp = 64;
    struct samples *first = trace_pass(&t, &longer, 0), *second = trace_pass(&t, &longer, 1);
    const float *a = samples_f32(first, PLANE_PATH_RADIANCE, 0);
    const float *b = samples_f32(second, PLANE_PATH_RADIANCE, 0);
    double sums[2] = {0, 0};
    int equal = 0;
    for (int i = 0; i < SIDE_PX * SIDE_PX; i++) {
        sums[0] += (double)a[i];
        sums[1] += (double)b[i];
        equal += a[i] > 0.0f && a[i] == b[i];
    }
    assert_true(sums[0] > 0 && fabs(sums[0] - sums[1]) < 0.05 * sums[0]);
    assert_true(equal < SIDE_PX * SIDE_PX / 10);
    samples_destroy(&first);
    samples_destroy(&second);
    traced_fini(&t);
    free(f);
}

TEST(parts_add_up)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    struct traced t = trace_all(f, &p);
    double lit = 0;
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < SIDE_PX * SIDE_PX; i++) {
            double all = (double)plane(&t, PLANE_PATH_RADIANCE, c)[i];
            double sum = (double)plane(&t, PLANE_PATH_EMISSION, c)[i] +
                         (double)plane(&t, PLANE_PATH_DIRECT, c)[i] +
                         (double)plane(&t, PLANE_PATH_INDIRECT, c)[i];
            assert_near(all, sum, 1e-4 * all + 1e-6);
            lit += all;
        }
    assert_true(lit > 1);
    traced_fini(&t);
    free(f);
}

/* On a scene of one Lambert material its albedo times the demodulated light is the light. */
TEST(demodulation_divides_by_albedo)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, SIDE_PX);
    f->materials[0].base_color[2] = 0.25f;
    fixture_panel(f, 0, (float[]){-1, 1, 0}, (float[]){0, 0, -1}, (float[]){0, 1, 0});
    fixture_ceiling_light(&p, 0, 3, 0, 0.5f, 1);
    p.light_planes = 0;
    p.planes = PLANES_PATH & ~PATH_BIT(VISIBILITY);
    p.bounces = 2;
    p.paths.spp = 4;
    struct traced t = trace_all(f, &p);
    const double albedo[3] = {0.5, 0.5, 0.25};
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < SIDE_PX * SIDE_PX; i++) {
            double direct = (double)plane(&t, PLANE_PATH_DIRECT, c)[i];
            double indirect = (double)plane(&t, PLANE_PATH_INDIRECT, c)[i];
            double white = (double)plane(&t, PLANE_PATH_DIFFUSE_DIRECT, c)[i];
            double bounced = (double)plane(&t, PLANE_PATH_DIFFUSE_INDIRECT, c)[i];
            assert_near(direct, albedo[c] * white, 1e-4 * direct + 1e-6);
            assert_near(indirect, albedo[c] * bounced, 1e-4 * indirect + 1e-6);
        }
    assert_near(mean(&t, PLANE_PATH_ALBEDO, 2, 4), 0.25, 1e-5);
    assert_near(mean(&t, PLANE_PATH_COVERAGE, 0, 4), 1.0, 1e-6);
    traced_fini(&t);
    free(f);
}

TEST(no_bounce_means_no_indirect_light)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    p.bounces = 0;
    struct traced t = trace_all(f, &p);
    for (uint32_t c = 0; c < 3; c++) assert_near(mean(&t, PLANE_PATH_INDIRECT, c, 16), 0, 0);
    assert_true(mean(&t, PLANE_PATH_DIRECT, 0, 16) > 0.01);
    traced_fini(&t);
    free(f);
}

/* A point light cannot be met: without bounces no ray looks for it. */
TEST(last_rays_that_meet_nothing_are_skipped)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    p.bounces = 0;
    p.lights[0].type = LIGHT_POINT;
    struct traced t = trace_all(f, &p);
    assert_int_equal(count(&t, COUNTER_RAYS_INDIRECT), 0);
    assert_true(count(&t, COUNTER_SKIPPED_LAST_SEGMENT) > 0);
    assert_true(count(&t, COUNTER_RAYS_SHADOW) > 0);
    traced_fini(&t);
    free(f);
}

/* The same light counted by light samples alone and by both ways: with a rough metal both matter.
 * A rectangle without bounces, once found by scattering mostly, since another that is a thousand
 * times as strong is behind a wall. */
TEST(both_ways_agree_with_one)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    p.bounces = 0;
    p.paths.spp = 256;
    struct traced both = trace_all(f, &p);
    struct plan one = p;
    fixture_panel(f, 0, (float[]){0, 5.9f, 0}, (float[]){0, 0, -3}, (float[]){-3, 0, 0});
    struct plan_light *hidden = fixture_ceiling_light(&one, 0, 6, 0, 0.5f, 1);
    for (int k = 0; k < 3; k++) hidden->color[k] = 1e3f;
    struct traced rare = trace_all(f, &one);
    expect_equal_light(&both, &rare, PLANE_PATH_DIRECT, 16);
    assert_true(mean(&rare, PLANE_PATH_M2, 0, 16) > 2 * mean(&both, PLANE_PATH_M2, 0, 16));
    traced_fini(&rare);
    traced_fini(&both);
    free(f);
}

TEST(spread_is_the_samples_own)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    p.paths.spp = 1;
    struct traced t = trace_all(f, &p);
    for (int i = 0; i < SIDE_PX * SIDE_PX; i++)
        assert_near((double)plane(&t, PLANE_PATH_M2, 1)[i], 0, 0);
    traced_fini(&t);
    free(f);
}

/* A panel that ends at a pixel's edge: with a box the next pixel does not see it, with a tent an
 * eighth of it does, since that much of the tent lies beyond the edge. */
TEST(tents_reach_into_the_next_pixel)
{
    struct scene_fixture *f = fixture_new();
    uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
    fixture_panel(f, grey, (float[]){-10, 0, 0}, (float[]){10, 0, 0}, (float[]){0, 10, 0});
    struct plan p = fixture_plan(4, 4, (float[]){0, 0, 1}, 1.0f);
    p.light_planes = 0;
    p.planes = PLANES_PATH & ~PATH_BIT(VISIBILITY);
    p.paths.spp = 4096;
    for (uint32_t filter = PIXEL_FILTER_BOX; filter <= PIXEL_FILTER_TENT; filter++) {
        p.paths.pixel_filter = filter;
        struct traced t = trace_all(f, &p);
        for (uint32_t pass = 1; pass < plan_pass_count(&p); pass++) {
            struct samples *more = NULL;
            struct rect all = {0, 0, 4, 4};
            assert_int_equal(
                trace_tile(&t, (struct tile_job){.plan = &p, .rect = all}, pass, &more), 0);
            for (int i = 0; i < 16; i++)
                plane(&t, PLANE_PATH_COVERAGE, 0)[i] +=
                    samples_f32(more, PLANE_PATH_COVERAGE, 0)[i];
            samples_destroy(&more);
        }
        const float *seen = plane(&t, PLANE_PATH_COVERAGE, 0) + 4;
        double beyond = filter == PIXEL_FILTER_TENT ? 0.125 : 0.0;
        assert_near((double)seen[0] / 4096, 1, 0);
        assert_near((double)seen[1] / 4096, 1 - beyond, 0.003);
        assert_near((double)seen[2] / 4096, beyond, 0.003);
        assert_near((double)seen[3] / 4096, 0, 0);
        traced_fini(&t);
    }
    free(f);
}

TEST(passes_and_maps_are_checked)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    struct traced t = trace_all(f, &p);
    struct rect all = {0, 0, SIDE_PX, SIDE_PX};
    struct samples *s = NULL;
    assert_int_equal(
        trace_tile(&t, (struct tile_job){.plan = &p, .rect = all}, plan_pass_count(&p), &s),
        ERR_RANGE);
    p.environment.kind = ENVIRONMENT_MAP;
    p.environment.power = 1.0f;
    assert_int_equal(trace_tile(&t, (struct tile_job){.plan = &p, .rect = all}, 0, &s),
                     ERR_MISSING);
    traced_fini(&t);
    free(f);
}

/* In a closed room every path ends somewhere, and a counter says how: on black, by chance, or below
 * the surface that sends it on. */
TEST(every_path_ends_once)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = fixture_plan(SIDE_PX, SIDE_PX, (float[]){0, 0, 0}, 0.8f);
    const uint32_t grey = fixture_material(f, 0.6f, 0.5f, 0.4f);
    const uint32_t black = fixture_material(f, 0, 0, 0), glossy = fixture_material(f, 1, 1, 1);
    f->materials[glossy].specular = 1.0f;
    f->materials[glossy].roughness = 0.5f;
    f->materials[glossy].metallic = 0.5f;
    const uint32_t walls[6] = {grey, black, glossy, grey, glossy, grey};
    for (int k = 0; k < 6; k++) {
        float c[3] = {0}, u[3] = {0}, v[3] = {0};
        c[k / 2] = k & 1 ? 2.0f : -2.0f;
        u[(k / 2 + 1) % 3] = v[(k / 2 + 2) % 3] = 2.0f;
        fixture_panel(f, walls[k], c, u, v);
    }
    fixture_ceiling_light(&p, 0, 1, 0, 0.5f, 1);
    p.light_planes = 0;
    p.planes = PLANES_PATH & ~PATH_BIT(VISIBILITY);
    p.bounces = 200; /* none comes so far */
    p.paths.spp = 16;
    struct traced t = trace_all(f, &p);
    const uint64_t paths = count(&t, COUNTER_RAYS_PRIMARY);
    const uint64_t black_ends = count(&t, COUNTER_SKIPPED_BLACK_ALBEDO);
    const uint64_t chance = count(&t, COUNTER_SKIPPED_ROULETTE);
    const uint64_t below = count(&t, COUNTER_SKIPPED_BOUNCE_BELOW_HORIZON);
    assert_int_equal(paths, SIDE_PX * SIDE_PX * 16);
    assert_true(black_ends > paths / 10 && chance > paths / 10 && below > 0);
    assert_int_equal(black_ends + chance + below, paths);
    traced_fini(&t);
    free(f);
}
