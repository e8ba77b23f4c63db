/* Mirrors that lens samples look through. */
#include <stdlib.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "proto/shared_exponent.h"
#include "tests/unit/worker/trace/field/lens_parts.h"

/* A mirror three units ahead, `half` a side, that shows a red wall as far behind the eye. */
static struct plan mirror_plan(struct scene_fixture *f, float half, uint32_t mirrors)
{
    const uint32_t red = fixture_material(f, 0.75f, 0.25f, 0.125f);
    const uint32_t metal = fixture_material(f, 0.5f, 0.8f, 1);
    fixture_panel(f, metal, (float[]){0, 0, -3}, (float[]){half, 0, 0}, (float[]){0, half, 0});
    fixture_panel(f, red, (float[]){0, 0, 3}, (float[]){-20, 0, 0}, (float[]){0, 20, 0});
    f->materials[metal].metallic = 1;
    f->materials[metal].roughness = 0;
    struct plan p = fixture_plan(SIDE, SIDE, (float[]){0, 0, 0}, 0.5f);
    p.environment =
        (struct plan_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 2, 4}, .power = 1};
    p.planes = PLANES_LENS | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(INDIRECT_MEAN) |
               PLANE_BIT(BOUNCE_DISTANCE_MIN);
    p.light_planes = 0;
    p.bounces = 2;
    p.lens_strata_per_axis = L;
    p.lens_relight = LENS_RELIGHT_SKY;
    p.lens_mirrors = mirrors;
    p.indirect_strata_per_axis = 1;
    p.camera.aperture_radius = 0.1f;
    p.camera.focus_distance = 6;
    p.radiance_scale = 0.125f;
    p.length_unit = 8;
    return p;
}

/* What a mirror shows lies as far behind it as before, faces the eye and has the mirror's colour,
 * too; fields light it. */
TEST(mirrors_show_their_image)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = mirror_plan(f, 9, 2);
    struct traced t = trace_all(f, &p);
    const float red[3] = {0.5f * 0.75f, 0.8f * 0.25f, 0.125f};
    const float slope = 0.1f * SIDE * (1.0f / 9 - 1.0f / 6);
    uint32_t lit = 0;
    for (uint32_t k = 0; k < N; k++)
        for (size_t i = 0; i < SIDE * SIDE; i++) {
            float normal[3], albedo[3], left[3], light[3];
            const float z = 8 * half_to_float(samples_u16(t.samples, PLANE_LENS_DEPTH, k)[i]);
            octahedron_unpack8(samples_u16(t.samples, PLANE_LENS_NORMAL, k)[i], normal);
            shared_exponent_unpack(samples_u32(t.samples, PLANE_LENS_ALBEDO, k)[i],
                                   SHARED_EXPONENT_9, albedo);
            parts_of(&t, k, i, left, light);
            assert_true(fabsf(z - 9) < 0.01f);
            assert_true(normal[2] > 0.999f);
            for (int c = 0; c < 3; c++) assert_true(fabsf(albedo[c] - red[c]) < 2e-3f);
            assert_true(fabsf(half_to_float(samples_u16(t.samples, PLANE_LENS_SLOPE, k)[i]) -
                              slope) < 1e-3f);
            lit += is_black(light) && is_black(left);
        }
    assert_true(lit > N * SIDE * SIDE * 9 / 10);
    const float *depth = samples_f32(t.samples, PLANE_DEPTH, 0);
    assert_true(fabsf(depth[SIDE / 2 * SIDE + SIDE / 2] - 9) < 0.01f);
    assert_true(count(&t, COUNTER_RAYS_LENS_MIRRORS) >= (N + 1) * SIDE * SIDE);
    traced_fini(&t);
    free(f);
}

/* How many rays go on from a mirror `half` a side, in a plan of so many reflections. */
static uint64_t rays_on(float half, uint32_t mirrors, bool bent)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = mirror_plan(f, half, mirrors);
    if (bent) f->meshes[0].flags |= MESH_HAS_NORMALS;
    for (uint32_t k = 0; bent && k < 4; k++) {
        float *n = f->normals + (size_t)3 * k;
        n[0] = k & 1 ? 0.05f : -0.05f;
        n[2] = sqrtf(1.0f - n[0] * n[0]);
    }
    struct traced t = trace_all(f, &p);
    const uint64_t rays = count(&t, COUNTER_RAYS_LENS_MIRRORS);
    traced_fini(&t);
    free(f);
    return rays;
}

/* Looked through, a mirror that shines would be dark. */
TEST(mirrors_that_shine_are_met)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = mirror_plan(f, 9, 2);
    for (uint32_t m = 0; m < 2; m++)
        if (f->materials[m].metallic > 0) f->materials[m].emission[1] = 3;
    struct traced t = trace_all(f, &p);
    assert_int_equal(count(&t, COUNTER_RAYS_LENS_MIRRORS), 0);
    for (uint32_t k = 0; k < N; k++)
        for (size_t i = 0; i < SIDE * SIDE; i++) {
            float left[3], light[3];
            parts_of(&t, k, i, left, light);
            assert_true(left[1] >= 2.9f);
        }
    traced_fini(&t);
    free(f);
}

/* Bent ones and what is small are not looked through, nor any without a plan for it. */
TEST(only_flat_mirrors_are_looked_through)
{
    assert_true(rays_on(9, 1, false) >= (N + 1) * SIDE * SIDE);
    assert_true(rays_on(0.3f, 1, false) > 0);
    assert_int_equal(rays_on(0.1f, 1, false), 0);
    assert_int_equal(rays_on(9, 0, false), 0);
    assert_int_equal(rays_on(9, 1, true), 0);
}
