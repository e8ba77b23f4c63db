/* Direct light against closed forms: irradiance, visibility, slopes. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#include "proto/half.h"

/* Irradiance of a uniform rectangle of radiance 1 over an upward floor point, by Lambert's polygon
 * formula: half the sum of the edges' angles times the edge normals' upward part. */
static double polygon_irradiance(const double corners[4][3], const double p[3])
{
    double sum = 0.0, r[4][3];
    for (int i = 0; i < 4; i++) {
        double length = 0.0;
        for (int k = 0; k < 3; k++) r[i][k] = corners[i][k] - p[k];
        for (int k = 0; k < 3; k++) length += r[i][k] * r[i][k];
        for (int k = 0; k < 3; k++) r[i][k] /= sqrt(length);
    }
    for (int i = 0; i < 4; i++) {
        const double *a = r[i], *b = r[(i + 1) % 4];
        double cos = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                       a[0] * b[1] - a[1] * b[0]};
        sum += acos(cos) * c[1] / sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    }
    return fabs(0.5 * sum);
}

TEST(test_rectangle_irradiance)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 10.0f, 32);
    fixture_ceiling_light(&p, 0.3f, 2.0f, 0.2f, 0.5f, 16);
    struct traced t = trace_all(f, &p);
    const double corners[4][3] = {{-0.2, 2, -0.3}, {0.8, 2, -0.3}, {0.8, 2, 0.7}, {-0.2, 2, 0.7}};
    const float *e = samples_light_irradiance(t.samples, 0);
    double error = 0.0, mean = 0.0;
    for (int32_t y = 0; y < 32; y++)
        for (int32_t x = 0; x < 32; x++) {
            double point[3];
            floor_point(&p, x, y, point);
            double expected = polygon_irradiance(corners, point);
            double got = (double)e[y * 32 + x];
            assert_true(fabs(got - expected) < 0.05 * expected);
            error += got - expected;
            mean += expected;
        }
    assert_true(fabs(error) < 2e-4 * mean);
    assert_int_equal(count(&t, COUNTER_RAYS_SHADOW), 32 * 32 * 256);
    assert_int_equal(samples_light_visibility(t.samples, 0, 31)[5], 0xff);
    assert_int_equal(samples_light_slope(t.samples, 0, 0)[5], 0);
    traced_fini(&t);
    free(f);
}

/* E of a rectangle with emission exp(-2(u^2 + v^2)), by a fine midpoint rule. */
static double gaussian_irradiance(const struct plan_light *l, const double p[3])
{
    enum { N = 200 };
    double sum = 0.0;
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++) {
            double u = (i + 0.5) / N * 2 - 1, v = (k + 0.5) / N * 2 - 1;
            double x = (double)l->position[0] + u * (double)l->half_u[0] - p[0];
            double y = (double)l->position[1] - p[1];
            double z = (double)l->position[2] + v * (double)l->half_v[2] - p[2];
            double d2 = x * x + y * y + z * z;
            sum += exp(-2.0 * (u * u + v * v)) * y * y / (d2 * d2);
        }
    return sum / (N * N) * 4.0 * (double)l->half_u[0] * (double)l->half_v[2];
}

TEST(test_gaussian_profile)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 10.0f, 8);
    fixture_ceiling_light(&p, 0, 2, 0, 0.6f, 64)->profile = PROFILE_GAUSSIAN;
    p.light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 64; i += 9) {
        double point[3];
        floor_point(&p, i % 8, i / 8, point);
        double expected = gaussian_irradiance(&p.lights[0], point);
        assert_true(fabs((double)samples_light_irradiance(t.samples, 0)[i] - expected) <
                    0.01 * expected);
    }
    traced_fini(&t);
    free(f);
}

TEST(test_punctual_lights)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 16);
    struct plan_light *point = fixture_light(&p, LIGHT_POINT, 1);
    point->position[0] = 0.5f, point->position[1] = 1.5f, point->range = 4.0f;
    struct plan_light *spot = fixture_light(&p, LIGHT_SPOT, 1);
    spot->position[1] = 2.0f;
    spot->cos_inner = 0.95f, spot->cos_outer = 0.80f;
    struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    sun->direction[0] = 0.6f, sun->direction[1] = -0.8f;
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 256; i++) {
        double q[3];
        floor_point(&p, i % 16, i / 16, q);
        double d2 = (q[0] - 0.5) * (q[0] - 0.5) + 1.5 * 1.5 + q[2] * q[2], d = sqrt(d2);
        double window = fmax(0.0, 1.0 - pow(d / 4.0, 4.0));
        double expected = window * 1.5 / d / d2;
        assert_true(fabs((double)samples_light_irradiance(t.samples, 0)[i] - expected) < 1e-5);
        d2 = q[0] * q[0] + 4.0 + q[2] * q[2], d = sqrt(d2);
        double cone = fmin(1.0, fmax(0.0, (2.0 / d - 0.80) / 0.15));
        expected = cone * cone * 2.0 / d / d2;
        assert_true(fabs((double)samples_light_irradiance(t.samples, 1)[i] - expected) < 1e-5);
        assert_true(fabsf(samples_light_irradiance(t.samples, 2)[i] - 0.8f) < 1e-6f);
        assert_null(samples_light_slope(t.samples, 0, 0));
    }
    traced_fini(&t);
    free(f);
}

/* A blocker at half the height over half the floor: slopes are 1, as t is 1/2. */
TEST(test_blocked_half)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 16);
    fixture_ceiling_light(&p, 0, 2, 0, 0.01f, 3);
    /* seen from the side, not from above: the camera looks through below it */
    fixture_panel(f, 0, (float[]){-5, 1.0f, 0}, (float[]){5, 0, 0}, (float[]){0, 0, -5});
    p.camera.eye[1] = 0.9f;
    p.camera.half_width = p.camera.half_height = 2.0f / 0.9f;
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 256; i++) {
        bool blocked = i % 16 < 7, open = i % 16 > 8;
        const uint8_t bits = samples_light_visibility(t.samples, 0, 0)[i];
        float least = half_to_float(samples_light_slope(t.samples, 0, 0)[i]);
        float most = half_to_float(samples_light_slope(t.samples, 0, 1)[i]);
        if (open) assert_int_equal(bits, 0xff);
        if (blocked) assert_int_equal(bits, 0);
        if (blocked) assert_int_equal(samples_light_visibility(t.samples, 0, 1)[i], 0);
        if (blocked) assert_true(fabsf(least - 1.0f) < 2e-3f && fabsf(most - 1.0f) < 2e-3f);
        if (open) assert_true(least == 0.0f && most == 0.0f);
        if (blocked) assert_true(samples_light_irradiance(t.samples, 0)[i] == 0.0f);
    }
    traced_fini(&t);
    free(f);
}

/* Occlusion queries and closest-hit queries agree on who sees the light. */
TEST(test_visibility_without_slopes)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 32);
    fixture_ceiling_light(&p, 0, 2, 0, 0.4f, 3);
    fixture_panel(f, 0, (float[]){0, 0.8f, 0}, (float[]){0.3f, 0.1f, 0}, (float[]){0, 0, -0.4f});
    struct traced a = trace_all(f, &p);
    p.light_planes &= ~(1u << LIGHT_PLANE_SLOPES);
    struct traced b = trace_all(f, &p);
    for (uint32_t byte = 0; byte < 2; byte++)
        assert_memory_equal(samples_light_visibility(a.samples, 0, byte),
                            samples_light_visibility(b.samples, 0, byte), 32 * 32);
    assert_memory_equal(samples_light_irradiance(a.samples, 0),
                        samples_light_irradiance(b.samples, 0), 32 * 32 * sizeof(float));
    traced_fini(&a);
    traced_fini(&b);
    free(f);
}

/* The emitter's own geometry stands where the light is, front and back, and hides neither. */
TEST(test_lights_do_not_block_themselves)
{
    static const float scales[] = {1e-3f, 1.0f, 1e4f};
    for (int s = 0; s < 3; s++) {
        float k = scales[s];
        struct scene_fixture *f = fixture_new();
        uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
        fixture_panel(f, grey, (float[]){0, 0, 0}, (float[]){3 * k, 0, 0}, (float[]){0, 0, -3 * k});
        struct plan p = fixture_plan(32, 32, (float[]){0, 0.9f * k, 0}, 2.0f);
        fixture_look(&p, (float[]){0, -1, 0}, (float[]){0, 0, -1});
        fixture_panel(f, grey, (float[]){0, k, 0}, (float[]){0.5f * k, 0, 0},
                      (float[]){0, 0, 0.5f * k});
        fixture_panel(f, grey, (float[]){0, k, 0}, (float[]){0.5f * k, 0, 0},
                      (float[]){0, 0, -0.5f * k});
        f->meshes[1].flags = f->meshes[2].flags = MESH_IS_LIGHT;
        fixture_ceiling_light(&p, 0, k, 0, 0.5f * k, 4);
        struct plan_light *up = fixture_ceiling_light(&p, 0, k, 0, 0.5f * k, 4);
        up->direction[1] = 1;
        struct traced t = trace_all(f, &p);
        for (int32_t i = 0; i < 32 * 32; i++) {
            assert_int_equal(samples_light_visibility(t.samples, 0, 0)[i], 0xff);
            assert_int_equal(samples_light_visibility(t.samples, 0, 1)[i], 0xff);
        }
        assert_int_equal(count(&t, COUNTER_SKIPPED_FACING_AWAY), 32 * 32 * 16);
        traced_fini(&t);
        free(f);
    }
}

TEST(test_more_strata_than_a_byte)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 8);
    fixture_ceiling_light(&p, 0, 2, 0, 0.4f, 5);
    struct traced t = trace_all(f, &p);
    assert_int_equal(samples_light_visibility(t.samples, 0, 2)[3], 0xff);
    assert_int_equal(samples_light_visibility(t.samples, 0, 3)[3], 1);
    traced_fini(&t);
    free(f);
}

/* A floor whose normals lean towards a light that stands below it: the shading normal sees the
 * light, the floor itself is in the way. The strata count as blocked, or filters would light them;
 * they say nothing of a blocker's slope. */
TEST(test_facets_block_what_normals_see)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = fixture_plan(8, 8, (float[]){0, 4, 0}, 0.2f);
    fixture_look(&p, (float[]){0, -1, 0}, (float[]){0, 0, -1});
    fixture_material(f, 0.5f, 0.5f, 0.5f);
    uint32_t mesh = fixture_mesh(f, 0, MESH_HAS_NORMALS);
    fixture_quad(f, (float[]){0, 0, 0}, (float[]){2, 0, 0}, (float[]){0, 0, -2});
    fixture_place(f, mesh);
    for (int i = 0; i < 4; i++) {
        f->normals[3 * i] = 0.8f;
        f->normals[3 * i + 1] = 0.6f;
    }
    struct plan_light *light = fixture_light(&p, LIGHT_RECTANGLE, 3);
    memcpy(light->position, (float[]){5, -1, 0}, sizeof light->position);
    memcpy(light->direction, (float[]){-1, 0, 0}, sizeof light->direction);
    light->half_u[2] = 0.5f;
    light->half_v[1] = 0.5f;
    struct traced t = trace_all(f, &p);
    for (int i = 0; i < 64; i++) {
        assert_int_equal(samples_light_visibility(t.samples, 0, 0)[i], 0);
        assert_int_equal(samples_light_visibility(t.samples, 0, 1)[i], 0);
        assert_true(samples_light_irradiance(t.samples, 0)[i] == 0.0f);
        assert_int_equal(samples_light_slope(t.samples, 0, 1)[i], 0);
    }
    assert_int_equal(count(&t, COUNTER_RAYS_SHADOW), 0);
    assert_int_equal(count(&t, COUNTER_SKIPPED_BELOW_HORIZON), 64 * 9);
    traced_fini(&t);
    free(f);
}
