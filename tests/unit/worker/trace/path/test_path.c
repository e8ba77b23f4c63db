/* Paths: what they must agree on whatever the tiles and passes, and what their parts add up to.
 * Closed forms are in tests/golden. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

static void assert_near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance)) print_message("%.9g is not %.9g within %g\n", a, b, tolerance);
    assert_true(fabs(a - b) <= tolerance);
}

#define PATH_BIT(plane) PLANE_BIT(PATH_##plane)

enum { SIDE_PX = 24 };

/* A coloured floor, a mirror-like metal wall, a matt box top and a ceiling light. */
static struct plan room(struct scene_fixture *f)
{
    struct plan p = floor_plan(f, 3.0f, SIDE_PX);
    f->materials[0].base_color[1] = 0.25f;
    uint32_t metal = fixture_material(f, 0.9f, 0.8f, 0.7f);
    f->materials[metal].metallic = 1.0f;
    f->materials[metal].roughness = 0.3f;
    f->materials[metal].specular = 1.0f;
    uint32_t glossy = fixture_material(f, 0.2f, 0.6f, 0.2f);
    f->materials[glossy].specular = 1.0f;
    f->materials[glossy].roughness = 0.4f;
    fixture_panel(f, metal, (float[]){-2, 1, 0}, (float[]){0, 0, -1}, (float[]){0, 1, 0});
    fixture_panel(f, glossy, (float[]){1, 0.5f, 0}, (float[]){0.5f, 0, 0}, (float[]){0, 0, -0.5f});
    fixture_ceiling_light(&p, 0, 3, 0, 0.5f, 1);
    p.lights[0].color[1] = 0.5f;
    p.light_planes = 0;
    p.planes = PLANES_PATH & ~PATH_BIT(VISIBILITY);
    p.bounces = 3;
    p.paths.spp = 16;
    return p;
}

static float *plane(const struct traced *t, enum plane_id id, uint32_t c)
{
    float *v = samples_f32(t->samples, id, c);
    assert_non_null(v);
    return v;
}

static double mean(const struct traced *t, enum plane_id id, uint32_t c, uint32_t spp)
{
    double sum = 0;
    const float *v = plane(t, id, c);
    int32_t area = t->samples->layout.width_px * t->samples->layout.height_px;
    for (int32_t i = 0; i < area; i++) sum += (double)v[i];
    return sum / area / spp;
}

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

static struct samples *trace_pass(struct traced *t, const struct plan *p, uint32_t pass)
{
    struct samples *s = NULL;
    struct rect all = {0, 0, SIDE_PX, SIDE_PX};
    assert_int_equal(trace_tile(t, (struct tile_job){.plan = p, .rect = all}, pass, &s), 0);
    return s;
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

static void expect_equal_light(const struct traced *a, const struct traced *b, enum plane_id plane,
                               uint32_t spp)
{
    for (uint32_t c = 0; c < 3; c++) {
        const double spread = mean(a, PLANE_PATH_M2, c, spp) + mean(b, PLANE_PATH_M2, c, spp);
        assert_near(mean(a, plane, c, spp), mean(b, plane, c, spp),
                    4 * sqrt(spread / ((double)spp * SIDE_PX * SIDE_PX)));
    }
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

/* Points, spots, rectangles, a directional light and shining meshes over the room. */
static struct plan lit_room(struct scene_fixture *f, uint32_t points, uint32_t meshes[3])
{
    struct plan p = room(f);
    p.bounces = 1;
    p.paths.spp = 512;
    fixture_ceiling_light(&p, -1.5f, 0.4f, 1, 0.1f, 1)->color[1] = 9.0f;
    for (uint32_t k = 0; k < points; k++) {
        struct plan_light *l = fixture_light(&p, k % 3 ? LIGHT_POINT : LIGHT_SPOT, 1);
        const float at[3] = {0.7f * (float)(k % 4) - 1.0f, 0.2f + 0.1f * (float)k,
                             0.5f * (float)(k / 4) - 1.0f};
        memcpy(l->position, at, sizeof at);
        l->direction[0] = l->direction[2] = 0.0f, l->direction[1] = -1.0f;
        l->cos_outer = 0.3f, l->cos_inner = 0.8f;
        for (int c = 0; c < 3; c++) l->color[c] = 0.1f;
    }
    struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    sun->direction[0] = 0.6f, sun->direction[1] = -0.8f, sun->direction[2] = 0.0f;
    for (uint32_t k = 0; k < 3; k++) {
        const float at[3] = {1.2f - 0.8f * (float)k, 0.05f + 0.3f * (float)k, -1.2f};
        meshes[k] = fixture_material(f, 0, 0, 0);
        fixture_panel(f, meshes[k], at, (float[]){0.1f, 0, 0}, (float[]){0, 0, 0.1f});
    }
    return p;
}

/* Adds what the tile's passes from `from` on hold to `sum`. */
static void add_passes(struct traced *t, const struct plan *p, uint32_t from, struct traced *sum)
{
    static const enum plane_id planes[] = {PLANE_PATH_DIRECT, PLANE_PATH_INDIRECT, PLANE_PATH_M2};
    for (uint32_t pass = from; pass < plan_pass_count(p); pass++) {
        struct samples *s = trace_pass(t, p, pass);
        for (size_t n = 0; n < 3; n++)
            for (uint32_t c = 0; c < 3; c++)
                for (int i = 0; i < SIDE_PX * SIDE_PX; i++)
                    plane(sum, planes[n], c)[i] += samples_f32(s, planes[n], c)[i];
        samples_destroy(&s);
    }
}

/* Traces all passes of a picture. */
static struct traced trace_passes(struct scene_fixture *f, const struct plan *p)
{
    struct traced t = trace_all(f, p);
    add_passes(&t, p, 1, &t);
    return t;
}

static void add_picture(struct scene_fixture *f, const struct plan *p, struct traced *sum)
{
    struct traced t = {0};
    open_traced(f, &t);
    add_passes(&t, p, 0, sum);
    traced_fini(&t);
}

/* All lights together bring what each brings alone, where there is nothing to choose: few points,
 * which all are sampled, and more. */
TEST(lights_add_up)
{
    for (uint32_t points = 2; points <= 12; points += 10) {
        struct scene_fixture *f = fixture_new();
        uint32_t meshes[3];
        struct plan p = lit_room(f, points, meshes), one = p;
        struct traced sum;
        one.light_count = 1;
        one.lights[0] = p.lights[0];
        sum = trace_passes(f, &one);
        for (uint32_t k = 1; k < p.light_count; k++) {
            one.lights[0] = p.lights[k];
            add_picture(f, &one, &sum);
        }
        one.light_count = 0;
        one.paths.emitter_power = p.paths.emitter_power = 1.0f;
        for (uint32_t k = 0; k < 3; k++) {
            f->materials[meshes[k]].emission[k] = 4.0f;
            add_picture(f, &one, &sum);
            f->materials[meshes[k]].emission[k] = 0.0f;
        }
        for (uint32_t k = 0; k < 3; k++) f->materials[meshes[k]].emission[k] = 4.0f;
        struct traced all = trace_passes(f, &p);
        expect_equal_light(&all, &sum, PLANE_PATH_DIRECT, 512);
        expect_equal_light(&all, &sum, PLANE_PATH_INDIRECT, 512);
        traced_fini(&all);
        traced_fini(&sum);
        free(f);
    }
}

/* Emitters without area, in one place with each other and with what they light, beside the camera
 * and as bright as they may be; lights on surfaces; normals of nothing. */
TEST(odd_lights_give_finite_light)
{
    struct scene_fixture *f = fixture_new();
    uint32_t meshes[3];
    struct plan p = lit_room(f, 12, meshes);
    p.paths.spp = 16;
    p.paths.emitter_power = 1.0f;
    for (uint32_t k = 0; k < 3; k++) {
        const float on[3] = {0, 0, 0}, x[3] = {0.5f, 0, 0}, z[3] = {0, 0, -0.5f}, none[3] = {0};
        f->materials[meshes[k]].emission[k] = k == 0 ? 1e12f : 1.0f;
        f->materials[meshes[k]].flags |= MATERIAL_DOUBLE_SIDED;
        fixture_panel(f, meshes[k], on, x, z);    /* in the floor's place */
        fixture_panel(f, meshes[k], on, x, none); /* without area */
        fixture_panel(f, meshes[k], (float[]){0.01f, 4.0f, 0}, (float[]){1e-3f, 0, 0},
                      (float[]){0, 0, -1e-3f}); /* beside the eye */
    }
    for (uint32_t k = 0; k < p.light_count; k++)
        if (p.lights[k].type == LIGHT_POINT) p.lights[k].position[1] = 0.0f;
    struct traced t = trace_all(f, &p);
    assert_true(mean(&t, PLANE_PATH_RADIANCE, 1, 16) > 0.0);
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < SIDE_PX * SIDE_PX; i++)
            assert_true(isfinite(plane(&t, PLANE_PATH_RADIANCE, c)[i]));
    traced_fini(&t);
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
