/* Lens samples that light fields light: what they tell, and what their paths leave out. */
#include <stdlib.h>

#include "proto/half.h"
#include "proto/lens_pattern.h"
#include "proto/octahedron.h"
#include "proto/shared_exponent.h"
#include "tests/unit/worker/trace/field/lens_parts.h"

/* A board before a wall, both lit by a point beside the eye and from a floor below the picture, the
 * focus on the wall. */
static struct plan board_plan(struct scene_fixture *f, uint32_t light)
{
    const uint32_t red = fixture_material(f, 0.75f, 0.25f, 0.125f);
    const uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
    fixture_panel(f, grey, (float[]){0, 0, -6}, (float[]){9, 0, 0}, (float[]){0, 9, 0});
    fixture_panel(f, red, (float[]){-0.6f, 0, -2}, (float[]){0.6f, 0, 0}, (float[]){0, 2, 0});
    fixture_panel(f, grey, (float[]){0, -3.2f, -3}, (float[]){9, 0, 0}, (float[]){0, 0, -3});
    struct plan p = fixture_plan(SIDE, SIDE, (float[]){0, 0, 0}, 0.5f);
    struct plan_light *lamp = fixture_light(&p, LIGHT_POINT, 1);
    lamp->position[0] = 0.5f;
    p.planes = PLANES_LENS & ~PLANES_LENS_SURFACE;
    p.light_planes = 0;
    p.bounces = 1;
    p.lens_strata_per_axis = L;
    p.camera.aperture_radius = 0.3f;
    p.camera.focus_distance = 6;
    p.radiance_scale = 4;
    p.length_unit = 8;
    if (light == LENS_RELIGHT_OWN) return p;
    p.lens_relight = light;
    p.planes = PLANES_LENS | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(INDIRECT_MEAN);
    if (light == LENS_RELIGHT_DIFFUSE) p.light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    p.indirect_strata_per_axis = 1;
    return p;
}

/* What a path brings is the same number in parts, or some of it is left to the fields; of points
 * that the middle of the lens does not see, nothing is. */
static void expect_parts(uint32_t light)
{
    struct scene_fixture *f = fixture_new(), *g = fixture_new();
    struct plan own = board_plan(f, LENS_RELIGHT_OWN), lit = board_plan(g, light);
    if (light == LENS_RELIGHT_SKY)
        own.environment = lit.environment = (struct plan_environment){
            .kind = ENVIRONMENT_CONSTANT, .radiance = {1, 2, 4}, .power = 1};
    struct traced a = trace_all(f, &own), b = trace_all(g, &lit);
    uint32_t whole = 0, left_out = 0, less = 0;
    for (uint32_t k = 0; k < N; k++)
        for (size_t i = 0; i < SIDE * SIDE; i++) {
            float left[3], brought[3], all = 0.0f, sum = 0.0f;
            parts_of(&b, k, i, left, brought);
            for (uint32_t c = 0; c < 3; c++) {
                all += samples_f32(a.samples, PLANE_LENS_RADIANCE, k * 3 + c)[i];
                sum += left[c] + brought[c];
            }
            if (light == LENS_RELIGHT_DIFFUSE && is_black(brought)) {
                left_out++;
                assert_true(is_black(left));
                continue;
            }
            whole += !is_black(brought);
            assert_true(sum <= 1.01f * all);
            less += is_black(brought) && sum < 0.9f * all;
            if (!is_black(brought)) assert_true(fabsf(sum - all) < 0.01f * all);
        }
    assert_true(whole > 100);
    if (light == LENS_RELIGHT_DIFFUSE) assert_true(left_out > 8 * whole);
    if (light == LENS_RELIGHT_SKY) assert_true(less > 4 * whole);
    assert_true(count(&b, COUNTER_RAYS_LENS_CENTRES) >= SIDE * SIDE / 2);
    assert_true(count(&b, COUNTER_SKIPPED_LIGHT_FIELD) > 0);
    assert_int_equal(count(&a, COUNTER_RAYS_LENS_CENTRES), 0);
    assert_int_equal(count(&a, COUNTER_SKIPPED_LIGHT_FIELD), 0);
    traced_fini(&a);
    traced_fini(&b);
    free(f);
    free(g);
}

TEST(samples_bring_their_light_in_parts)
{
    expect_parts(LENS_RELIGHT_DIFFUSE);
    expect_parts(LENS_RELIGHT_INDIRECT);
    expect_parts(LENS_RELIGHT_SKY);
}

/* Both boards of glTF's model, as rough as that. */
static struct plan glossy_plan(struct scene_fixture *f, uint32_t light, float roughness)
{
    struct plan p = board_plan(f, light);
    for (uint32_t k = 0; k < 2; k++) {
        f->materials[k].model = MODEL_GLTF;
        f->materials[k].specular = 1.0f;
        f->materials[k].ior = 1.5f;
        f->materials[k].roughness = roughness;
    }
    p.environment =
        (struct plan_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 2, 4}, .power = 1};
    if (light == LENS_RELIGHT_OWN) return p;
    p.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(LENS_LOBE) | PLANE_BIT(ID);
    p.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT;
    return p;
}

/* How many samples tell of a lobe. With their environment and all that was scattered before left to
 * fields, these bring what the lamp alone sends them, by both lobes. */
static uint32_t lobes_of(float roughness)
{
    struct scene_fixture *f = fixture_new(), *g = fixture_new();
    struct plan bare = glossy_plan(f, LENS_RELIGHT_OWN, roughness);
    struct plan lit = glossy_plan(g, LENS_RELIGHT_SKY, roughness);
    bare.environment = (struct plan_environment){.kind = ENVIRONMENT_NONE};
    bare.bounces = 0;
    struct traced a = trace_all(f, &bare), b = trace_all(g, &lit);
    uint32_t lobes = 0;
    for (uint32_t k = 0; k < N; k++)
        for (size_t i = 0; i < SIDE * SIDE; i++) {
            float lobe[3];
            shared_exponent_unpack(samples_u32(b.samples, PLANE_LENS_LOBE, k)[i], SHARED_EXPONENT_9,
                                   lobe);
            if (is_black(lobe)) continue;
            lobes++;
            for (uint32_t c = 0; c < 3; c++) {
                const float lamp = samples_f32(a.samples, PLANE_LENS_RADIANCE, k * 3 + c)[i];
                const float left = samples_f32(b.samples, PLANE_LENS_RADIANCE, k * 3 + c)[i];
                assert_true(lobe[c] > 0.02f && lobe[c] < 0.2f);
                assert_true(lamp > 0.0f && fabsf(left - lamp) < 1e-4f * lamp);
            }
        }
    traced_fini(&a);
    traced_fini(&b);
    free(f);
    free(g);
    return lobes;
}

/* Those of them that are wide beside the lens. */
TEST(lobes_are_left_to_fields)
{
    assert_true(lobes_of(0.5f) > N * SIDE * SIDE / 2);
    assert_int_equal(lobes_of(0.15f), 0);
}

/* Depth and normal are those of the surface, albedo its own. */
TEST(samples_tell_of_their_surface)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = board_plan(f, LENS_RELIGHT_DIFFUSE);
    struct traced t = trace_all(f, &p);
    uint32_t near = 0;
    for (uint32_t k = 0; k < N; k++)
        for (size_t i = 0; i < SIDE * SIDE; i++) {
            float normal[3], albedo[3];
            const float z = 8 * half_to_float(samples_u16(t.samples, PLANE_LENS_DEPTH, k)[i]);
            const bool board = z < 3;
            octahedron_unpack8(samples_u16(t.samples, PLANE_LENS_NORMAL, k)[i], normal);
            shared_exponent_unpack(samples_u32(t.samples, PLANE_LENS_ALBEDO, k)[i],
                                   SHARED_EXPONENT_9, albedo);
            assert_true(fabsf(z - (board ? 2.0f : 6.0f)) < 0.002f);
            assert_true(normal[2] > 0.999f);
            assert_true(fabsf(albedo[0] - (board ? 0.75f : 0.5f)) < 1e-3f);
            near += board;
        }
    assert_true(near > 100);
    traced_fini(&t);
    free(f);
}

/* A pixel's samples do not depend on the tile that holds it, whatever lies around that. */
TEST(tiles_do_not_show)
{
    struct scene_fixture *f = fixture_new(), *g = fixture_new();
    struct plan p = board_plan(f, LENS_RELIGHT_DIFFUSE), q = board_plan(g, LENS_RELIGHT_DIFFUSE);
    const struct rect part = {17, 10, 31, 30};
    struct traced whole = trace_all(f, &p), tile = trace(g, &q, part);
    for (uint32_t k = 0; k < N; k++)
        for (int32_t y = part.y0; y < part.y1; y++)
            for (int32_t x = part.x0; x < part.x1; x++) {
                const size_t i = (size_t)(y * SIDE + x);
                const size_t j = (size_t)((y - part.y0) * rect_width(part) + x - part.x0);
                assert_int_equal(samples_u32(whole.samples, PLANE_LENS_OWN_LIGHT, k)[i],
                                 samples_u32(tile.samples, PLANE_LENS_OWN_LIGHT, k)[j]);
                assert_true(samples_f32(whole.samples, PLANE_LENS_RADIANCE, k * 3)[i] ==
                            samples_f32(tile.samples, PLANE_LENS_RADIANCE, k * 3)[j]);
            }
    traced_fini(&whole);
    traced_fini(&tile);
    free(f);
    free(g);
}

/* Slopes of `slope`, on their way: how many samples of the board there are, and how many of them
 * bring no light. */
static uint32_t board_samples(float slope, float as_it_travels, uint32_t *black)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = board_plan(f, LENS_RELIGHT_DIFFUSE);
    uint32_t samples = 0;
    *black = 0;
    p.camera.aperture_radius = slope / (SIDE * (1.0f / 2 - 1.0f / 6));
    struct traced t = trace_all(f, &p);
    for (uint32_t k = 0; k < N; k++)
        for (size_t i = 0; i < SIDE * SIDE; i++) {
            float left[3], brought[3];
            if (half_to_float(samples_u16(t.samples, PLANE_LENS_SLOPE, k)[i]) != as_it_travels)
                continue;
            parts_of(&t, k, i, left, brought);
            samples++;
            *black += is_black(left) && is_black(brought);
        }
    traced_fini(&t);
    free(f);
    return samples;
}

/* Fields do not light what they read as too far out of focus, though it is not by a hair. */
TEST(slopes_count_as_they_travel)
{
    uint32_t black;
    assert_true(board_samples(23.98f, 23.984375f, &black) > 100);
    assert_true(black > 10);
    assert_true(board_samples(23.995f, 24.0f, &black) > 100);
    assert_int_equal(black, 0);
}

/* All samples of a surface together have its albedo, finer than a step of one. */
TEST(albedos_are_right_in_the_mean)
{
    static const float albedo[3] = {0.7003f, 0.3001f, 0.0504f};
    struct scene_fixture *f = fixture_new();
    const uint32_t paint = fixture_material(f, albedo[0], albedo[1], albedo[2]);
    double sum[3] = {0};
    struct plan p = board_plan(f, LENS_RELIGHT_DIFFUSE);
    fixture_panel(f, paint, (float[]){0, 0, -1.5f}, (float[]){9, 0, 0}, (float[]){0, 9, 0});
    struct traced t = trace_all(f, &p);
    for (uint32_t k = 0; k < N; k++)
        for (size_t i = 0; i < SIDE * SIDE; i++) {
            float a[3];
            shared_exponent_unpack(samples_u32(t.samples, PLANE_LENS_ALBEDO, k)[i],
                                   SHARED_EXPONENT_9, a);
            for (int c = 0; c < 3; c++) {
                assert_true(fabsf(a[c] - albedo[c]) < 1.0f / 512);
                sum[c] += (double)a[c] / (N * SIDE * SIDE);
            }
        }
    for (int c = 0; c < 3; c++) assert_true(fabs(sum[c] - (double)albedo[c]) < 5e-5);
    traced_fini(&t);
    free(f);
}

/* Paths of second sets bring all of their light, whatever lights the first. */
static struct samples *second_set(uint32_t light, struct counters *counters)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = board_plan(f, light);
    uint8_t strata_map[SIDE * SIDE];
    struct samples *out;
    p.planes |= PLANE_BIT(LENS_SECOND_SET);
    p.lens_filter = LENS_FILTER_SHEARED;
    p.lens_extra = 9;
    for (int i = 0; i < SIDE * SIDE; i++) strata_map[i] = i % 5 == 0 ? PLAN_LENS_EXTRA_STRATA : 0;
    const struct plan_pass pass = {
        .number = 1, .strata = PLAN_LENS_EXTRA_STRATA, .strata_map = strata_map};
    struct traced t = trace_all(f, &p);
    const struct rect all = {0, 0, SIDE, SIDE};
    assert_int_equal(
        tile_trace_pass(
            t.tracer,
            &(struct tile_job){
                .scene = t.scene, .plan = &p, .pass = &pass, .rect = all, .counters = counters},
            &out),
        0);
    traced_fini(&t);
    free(f);
    return out;
}

TEST(second_sets_are_whole_paths)
{
    static const uint32_t lights[] = {LENS_RELIGHT_INDIRECT, LENS_RELIGHT_DIFFUSE};
    struct counters counters = {0};
    struct samples *own = second_set(LENS_RELIGHT_OWN, &counters);
    const size_t bytes = (size_t)SIDE * SIDE * sizeof(float);
    assert_true(samples_f32(own, PLANE_LENS_SECOND_SET, 0)[5 * SIDE] > 0.0f);
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) {
        counters = (struct counters){0};
        struct samples *lit = second_set(lights[i], &counters);
        for (uint32_t c = 0; c < 4; c++)
            assert_memory_equal(samples_f32(own, PLANE_LENS_SECOND_SET, c),
                                samples_f32(lit, PLANE_LENS_SECOND_SET, c), bytes);
        assert_int_equal(counters.value[COUNTER_RAYS_LENS_CENTRES], 0);
        assert_int_equal(counters.value[COUNTER_SKIPPED_LIGHT_FIELD], 0);
        samples_destroy(&lit);
    }
    samples_destroy(&own);
}
