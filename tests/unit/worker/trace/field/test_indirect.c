/* One bounce against closed forms. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#include "proto/half.h"
#include "worker/shade/lambert.h"
#include "worker/trace/field/indirect.h"

/* Six quads around the floor plan's camera that face inwards. */
static void add_box(struct scene_fixture *f, uint32_t material)
{
    static const float c[6][3] = {{4, 2, 0},  {-4, 2, 0}, {0, 2, 4},
                                  {0, 2, -4}, {0, 6, 0},  {0, -2, 0}};
    for (int i = 0; i < 6; i++) {
        float u[3] = {0}, v[3] = {0};
        int axis = i < 2 ? 0 : i < 4 ? 2 : 1, a = (axis + 1) % 3, b = (axis + 2) % 3;
        u[a] = 4, v[b] = i % 2 ? 4 : -4;
        fixture_panel(f, material, c[i], u, v);
    }
}

/* All that a bounce can see has radiance 1: so has every sample. */
TEST(test_furnace)
{
    for (uint32_t l = 1; l <= 3; l++) {
        struct scene_fixture *f = fixture_new();
        struct plan p = floor_plan(f, 2.5f, 12);
        uint32_t glow = fixture_material(f, 0, 0, 0);
        for (int i = 0; i < 3; i++) f->materials[glow].emission[i] = 1.0f;
        add_box(f, glow);
        fixture_bounces(&p, l);
        struct traced t = trace_all(f, &p);
        for (int32_t i = 0; i < 144; i++) {
            for (uint32_t c = 0; c < 3; c++)
                assert_true(half_to_float(samples_u16(t.samples, PLANE_INDIRECT_MEAN, c)[i]) == 1);
            for (uint32_t c = 0; c < 6; c++)
                assert_true(half_to_float(samples_u16(t.samples, PLANE_INDIRECT_HALVES, c)[i]) ==
                            1);
            float nearest = half_to_float(samples_u16(t.samples, PLANE_BOUNCE_DISTANCE_MIN, 0)[i]);
            float least = INFINITY;
            for (uint32_t k = 0; k < l * l; k++) {
                const uint16_t *d = samples_u16(t.samples, PLANE_INDIRECT_STRATA, 4 * k + 3);
                least = fminf(least, half_to_float(d[i]));
                assert_true(half_to_float(d[i]) > 1.9f);
            }
            assert_true(nearest == least);
        }
        assert_int_equal(count(&t, COUNTER_RAYS_INDIRECT), 144 * l * l);
        assert_int_equal(count(&t, COUNTER_RAYS_INDIRECT_SHADOW), 0);
        traced_fini(&t);
        free(f);
    }
}

/* The same box marked as lights, whose emission is sampled elsewhere, or turned outwards: black. */
TEST(test_lights_do_not_count_twice)
{
    for (int outwards = 0; outwards < 2; outwards++) {
        struct scene_fixture *f = fixture_new();
        struct plan p = floor_plan(f, 2.5f, 8);
        uint32_t glow = fixture_material(f, 0, 0, 0);
        f->materials[glow].emission[0] = 1.0f;
        add_box(f, glow);
        for (uint32_t i = 1; i < f->mesh_count; i++)
            f->meshes[i].flags = outwards ? 0 : MESH_IS_LIGHT;
        for (uint32_t i = 6; outwards && i < f->triangle_count * 3; i += 3) {
            uint32_t a = f->triangles[i];
            f->triangles[i] = f->triangles[i + 1];
            f->triangles[i + 1] = a;
        }
        fixture_bounces(&p, 3);
        struct traced t = trace_all(f, &p);
        for (int32_t i = 0; i < 64; i++) {
            assert_int_equal(samples_u16(t.samples, PLANE_INDIRECT_MEAN, 0)[i], 0);
            assert_int_not_equal(samples_u16(t.samples, PLANE_BOUNCE_DISTANCE_MIN, 0)[i], 0);
        }
        traced_fini(&t);
        free(f);
    }
}

/* A wide ceiling lit from below at an angle, seen by a small floor: its radiance is albedo/pi * E.
 * Two suns of different power share the rays and must add up. */
TEST(test_lit_ceiling)
{
    for (int suns = 1; suns <= 2; suns++) {
        struct scene_fixture *f = fixture_new();
        struct plan p = floor_plan(f, 0.02f, 16);
        p.camera.half_width = p.camera.half_height = 0.005f;
        p.camera.eye[1] = 0.5f; /* below the ceiling */
        p.camera.half_width = p.camera.half_height = 0.02f;
        uint32_t white = fixture_material(f, 0.8f, 0.4f, 0.2f);
        fixture_panel(f, white, (float[]){0, 1, 0}, (float[]){200, 0, 0}, (float[]){0, 0, 200});
        float e = 0.0f;
        for (int i = 0; i < suns; i++) {
            struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
            sun->direction[0] = 0.6f, sun->direction[1] = 0.8f;
            sun->power = i ? 1.0f : 3.0f;
            sun->color[0] = sun->color[1] = sun->color[2] = i ? 0.5f : 2.0f;
            e += 0.8f * sun->color[0];
        }
        fixture_bounces(&p, 8);
        struct traced t = trace_all(f, &p);
        double sum[3] = {0};
        for (int32_t i = 0; i < 256; i++)
            for (uint32_t c = 0; c < 3; c++)
                sum[c] += (double)half_to_float(samples_u16(t.samples, PLANE_INDIRECT_MEAN, c)[i]);
        static const double albedo[3] = {0.8, 0.4, 0.2};
        for (int c = 0; c < 3; c++) {
            double expected = albedo[c] / 3.14159265358979 * (double)e;
            assert_true(fabs(sum[c] / 256 - expected) < 0.01 * expected);
        }
        assert_int_equal(count(&t, COUNTER_RAYS_INDIRECT_SHADOW) +
                             count(&t, COUNTER_SKIPPED_BELOW_HORIZON) - 256u * (uint32_t)suns,
                         count(&t, COUNTER_RAYS_INDIRECT));
        traced_fini(&t);
        free(f);
    }
}

/* A rectangle light behind a screen lights the wall, the wall the floor: compared with the same
 * integral by brute force over the wall. */
TEST(test_wall_lit_by_rectangle)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 0.5f, 8);
    p.camera.half_width = p.camera.half_height = 0.002f;
    uint32_t grey = fixture_material(f, 0.6f, 0.6f, 0.6f);
    fixture_panel(f, grey, (float[]){1, 1, 0}, (float[]){0, 1, 0},
                  (float[]){0, 0, -1}); /* faces -x */
    struct plan_light *light = fixture_light(&p, LIGHT_RECTANGLE, 1);
    *light = (struct plan_light){.type = LIGHT_RECTANGLE,
                                 .position = {0.2f, 1.0f, 0.0f},
                                 .direction = {1, 0, 0},
                                 .half_u = {0, 0.2f, 0},
                                 .half_v = {0, 0, 0.2f},
                                 .color = {5, 5, 5},
                                 .power = 1,
                                 .strata_per_axis = 1};
    fixture_bounces(&p, 16);
    p.planes &= ~PLANE_BIT(INDIRECT_STRATA);
    struct traced t = trace_all(f, &p);
    double got = 0.0, expected = 0.0;
    for (int32_t i = 0; i < 64; i++)
        got += (double)half_to_float(samples_u16(t.samples, PLANE_INDIRECT_MEAN, 0)[i]) / 64;
    enum { N = 60, M = 12 };
    for (int a = 0; a < N; a++)
        for (int b = 0; b < N; b++) {
            double y = 2.0 * (a + 0.5) / N, z = 2.0 * (b + 0.5) / N - 1.0, e = 0.0;
            for (int c = 0; c < M; c++)
                for (int d = 0; d < M; d++) {
                    double dy = 0.8 + 0.4 * (c + 0.5) / M - y, dz = -0.2 + 0.4 * (d + 0.5) / M - z;
                    double d2 = 0.64 + dy * dy + dz * dz;
                    e += 5.0 * 0.64 / (d2 * d2) * 0.16 / (M * M);
                }
            double d2 = 1.0 + y * y + z * z;
            /* radiance albedo/pi e, times cos cos / d^2 dA, over pi */
            expected += 0.6 / 3.14159265 * e * y / (d2 * d2) * (4.0 / (N * N)) / 3.14159265;
        }
    assert_true(fabs(got - expected) < 0.02 * expected);
    traced_fini(&t);
    free(f);
}

/* Directions are unit, in the upper half, and their mean height is that of a cosine: 2/3. */
TEST(test_lambert_samples)
{
    enum { L = 256 };
    double mean = 0.0, side = 0.0;
    for (int row = 0; row < L; row++)
        for (int column = 0; column < L; column += LANES) {
            _Alignas(64) float u[LANES], v[LANES];
            struct lanes3 d;
            for (int i = 0; i < LANES; i++) {
                u[i] = ((float)(column + i) + 0.5f) / L;
                v[i] = ((float)row + 0.5f) / L;
            }
            lambert_sample(u, v, &d);
            for (int i = 0; i < LANES; i++) {
                float length = d.x[i] * d.x[i] + d.y[i] * d.y[i] + d.z[i] * d.z[i];
                assert_true(fabsf(length - 1.0f) < 1e-5f && d.z[i] >= 0.0f);
                assert_true(lambert_pdf(d.z[i]) >= 0.0f);
                mean += (double)d.z[i];
                side += (double)(d.x[i] + d.y[i]);
            }
        }
    assert_true(fabs(mean / (L * L) - 2.0 / 3.0) < 3e-4);
    assert_true(fabs(side / (L * L)) < 1e-5);
}

/* Those of the square's outline, too, rise above the surface, by less than anyone sees. */
TEST(test_lambert_rim)
{
    static const float ends[] = {0.0f, 0.3f, 0.5f, 0x1.fffffep-1f};
    _Alignas(64) float u[LANES], v[LANES];
    struct lanes3 d;
    for (int i = 0; i < LANES; i++) u[i] = ends[i % 4], v[i] = ends[i / 4];
    lambert_sample(u, v, &d);
    for (int i = 0; i < LANES; i++) {
        const bool rim = i % 4 == 0 || i % 4 == 3 || i / 4 == 0 || i / 4 == 3;
        assert_true(d.z[i] > 0.0f && (d.z[i] < 1e-3f) == rim);
        assert_true(fabsf(d.x[i] * d.x[i] + d.y[i] * d.y[i] + d.z[i] * d.z[i] - 1.0f) < 1e-6f);
    }
}

TEST(test_tangents_are_orthonormal)
{
    struct plan p = fixture_plan(8, 8, (float[]){0, 0, 0}, 1);
    struct lanes3 n, a, b;
    for (int i = 0; i < LANES; i++) {
        float angle = (float)i * 0.4f;
        n.x[i] = sinf(angle) * 0.6f, n.y[i] = sinf(angle) * 0.8f, n.z[i] = cosf(angle);
    }
    n.x[3] = 0, n.y[3] = 0, n.z[3] = -1; /* the pole: along the view */
    indirect_tangents(&p.camera, &n, &a, &b);
    for (int i = 0; i < LANES; i++) {
        assert_true(fabsf(n.x[i] * a.x[i] + n.y[i] * a.y[i] + n.z[i] * a.z[i]) < 2e-3f);
        assert_true(fabsf(n.x[i] * b.x[i] + n.y[i] * b.y[i] + n.z[i] * b.z[i]) < 2e-3f);
        assert_true(fabsf(a.x[i] * b.x[i] + a.y[i] * b.y[i] + a.z[i] * b.z[i]) < 2e-3f);
        float length = a.x[i] * a.x[i] + a.y[i] * a.y[i] + a.z[i] * a.z[i];
        assert_true(fabsf(length - 1.0f) < 2e-3f);
    }
}
