/* What camera rays find: geometry planes, instances, normals, masks, offsets. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#include "proto/half.h"
#include "proto/octahedron.h"

TEST(test_depth_and_normal)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 16);
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 256; i++) {
        double q[3];
        float n[3];
        floor_point(&p, i % 16, i / 16, q);
        double depth = sqrt(q[0] * q[0] + 16.0 + q[2] * q[2]);
        assert_true(fabs((double)samples_f32(t.samples, PLANE_DEPTH, 0)[i] - depth) < 1e-5);
        octahedron_unpack16(samples_u32(t.samples, PLANE_NORMAL, 0)[i], n);
        assert_true(n[1] > 0.9999f);
        assert_int_equal(samples_u16(t.samples, PLANE_ALBEDO, 1)[i], 32768);
    }
    traced_fini(&t);
    free(f);
}

TEST(test_orthographic_camera)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 1.0f, 16);
    p.camera.type = CAMERA_ORTHOGRAPHIC;
    p.camera.half_width = p.camera.half_height = 2.0f;
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 256; i++) {
        bool on = abs(2 * (i % 16) - 15) < 8 && abs(2 * (i / 16) - 15) < 8;
        float depth = samples_f32(t.samples, PLANE_DEPTH, 0)[i];
        assert_true(fabsf(depth - (on ? 4.0f : 0.0f)) < 1e-5f);
    }
    traced_fini(&t);
    free(f);
}

/* Two tetrahedra, once as geometry in place and once through transforms. */
static void add_tetrahedron(struct scene_fixture *f, const float m[12])
{
    static const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0.2f, 1, 0}, {0.3f, 0.3f, 1}};
    for (int i = 0; i < 4; i++) {
        const float *c = corners[i];
        float v[3];
        for (int k = 0; k < 3; k++)
            v[k] = m[4 * k] * c[0] + m[4 * k + 1] * c[1] + m[4 * k + 2] * c[2] + m[4 * k + 3];
        fixture_vertex(f, v[0], v[1], v[2]);
    }
    fixture_triangle(f, 0, 2, 1);
    fixture_triangle(f, 0, 1, 3);
    fixture_triangle(f, 1, 2, 3);
    fixture_triangle(f, 2, 0, 3);
}

static const float places[3][12] = {
    {1, 0, 0, -1.5f, 0, 1, 0, 0, 0, 0, 1, -0.5f},
    {0, -2, 0, 1.5f, 1, 0, 0, 0.2f, 0, 0, 1, -0.5f},
    {-1, 0, 0, 0.3f, 0, 1, 0, -1.4f, 0, 0, 1, -0.5f}, /* mirrored */
};

TEST(test_instances_equal_copies)
{
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    struct scene_fixture *a = fixture_new(), *b = fixture_new();
    struct plan p = fixture_plan(64, 64, (float[]){0, 0, 4}, 0.6f);
    fixture_ceiling_light(&p, 0, 3, 1, 0.5f, 3);
    fixture_material(a, 0.5f, 0.6f, 0.7f);
    fixture_material(b, 0.5f, 0.6f, 0.7f);
    uint32_t mesh = fixture_mesh(a, 0, 0);
    add_tetrahedron(a, identity);
    for (int i = 0; i < 3; i++) {
        fixture_place_at(a, mesh, places[i]);
        uint32_t copy = fixture_mesh(b, 0, 0);
        add_tetrahedron(b, places[i]);
        fixture_place(b, copy);
    }
    struct traced s = trace_all(a, &p), t = trace_all(b, &p);
    int differing = 0, covered = 0;
    for (int32_t i = 0; i < 64 * 64; i++) {
        float n[3], m[3];
        uint32_t id = samples_u32(s.samples, PLANE_ID, 0)[i];
        if (id != samples_u32(t.samples, PLANE_ID, 0)[i]) differing++;
        if (id == 0 || id != samples_u32(t.samples, PLANE_ID, 0)[i]) continue;
        covered++;
        octahedron_unpack16(samples_u32(s.samples, PLANE_NORMAL, 0)[i], n);
        octahedron_unpack16(samples_u32(t.samples, PLANE_NORMAL, 0)[i], m);
        float dot = n[0] * m[0] + n[1] * m[1] + n[2] * m[2];
        float deep = samples_f32(s.samples, PLANE_DEPTH, 0)[i];
        if (dot < 0.9999f || fabsf(deep - samples_f32(t.samples, PLANE_DEPTH, 0)[i]) > 1e-4f)
            differing++;
        float e = samples_light_irradiance(s.samples, 0)[i];
        if (fabsf(e - samples_light_irradiance(t.samples, 0)[i]) > 1e-3f * e + 1e-4f) differing++;
    }
    assert_true(covered > 150);
    assert_true(differing <= 3); /* rays through the very edges */
    traced_fini(&s);
    traced_fini(&t);
    free(a);
    free(b);
}

/* Emission shows on the side that the winding faces, also through a mirroring transform. */
TEST(test_emission_is_one_sided)
{
    for (int mirrored = 0; mirrored < 2; mirrored++)
        for (int back = 0; back < 2; back++)
            for (int both = 0; both < 2; both++) {
                struct scene_fixture *f = fixture_new();
                struct plan p = fixture_plan(8, 8, (float[]){0, 0, back ? -3 : 3}, 0.2f);
                if (back) fixture_look(&p, (float[]){0, 0, 1}, (float[]){0, 1, 0});
                p.planes |= PLANE_BIT(EMISSION);
                fixture_material(f, 0.5f, 0.5f, 0.5f);
                f->materials[0].emission[1] = 2.5f;
                f->materials[0].flags = both ? MATERIAL_DOUBLE_SIDED : 0;
                uint32_t mesh = fixture_mesh(f, 0, 0);
                fixture_quad(f, (float[]){0, 0, 0}, (float[]){1, 0, 0}, (float[]){0, 1, 0});
                fixture_place_at(f, mesh,
                                 (float[]){mirrored ? -1 : 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
                struct traced t = trace_all(f, &p);
                float g = half_to_float(samples_u16(t.samples, PLANE_EMISSION, 1)[20]);
                assert_true(g == (back && !both ? 0.0f : 2.5f));
                traced_fini(&t);
                free(f);
            }
}

TEST(test_smooth_normals_face_the_viewer)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = fixture_plan(32, 32, (float[]){0, 0, 3}, 0.3f);
    fixture_material(f, 0.5f, 0.5f, 0.5f);
    uint32_t mesh = fixture_mesh(f, 0, MESH_HAS_NORMALS);
    fixture_quad(f, (float[]){0, 0, 0}, (float[]){1, 0, 0}, (float[]){0, 1, 0});
    fixture_place(f, mesh);
    for (int i = 0; i < 4; i++) { /* from -x to +x, beyond what the viewer could see */
        bool right = i == 1 || i == 2;
        f->normals[3 * i] = right ? 1.0f : -1.0f;
        f->normals[3 * i + 2] = 0.0f;
    }
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 32 * 32; i++) {
        float n[3], o[3], d[3];
        octahedron_unpack16(samples_u32(t.samples, PLANE_NORMAL, 0)[i], n);
        plan_camera_ray(&p, (float)(i % 32) + 0.5f, (float)(i / 32) + 0.5f, o, d);
        assert_true(n[0] * d[0] + n[1] * d[1] + n[2] * d[2] < 0.0f);
        assert_true(n[0] * (float)(2 * (i % 32) - 31) > 0.0f);
    }
    traced_fini(&t);
    free(f);
}

/* A normal map whose texels all lean 45 degrees along the tangent. */
TEST(test_normal_map)
{
    static const uint8_t lean[4] = {218, 128, 218, 255};
    struct scene_fixture *f = fixture_new();
    struct plan p = fixture_plan(8, 8, (float[]){0, 0, 3}, 0.3f);
    fixture_material(f, 0.5f, 0.5f, 0.5f);
    f->materials[0].normal_texture.texture = fixture_texture(f, 1, 1, lean, 0);
    uint32_t mesh = fixture_mesh(f, 0, MESH_HAS_NORMALS | MESH_HAS_TANGENTS);
    fixture_quad(f, (float[]){0, 0, 0}, (float[]){1, 0, 0}, (float[]){0, 1, 0});
    fixture_place(f, mesh);
    for (int i = 0; i < 4; i++) {
        f->normals[3 * i + 2] = 1.0f;
        f->tangents[4 * i + 1] = 1.0f; /* along y */
        f->tangents[4 * i + 3] = 1.0f;
    }
    struct traced t = trace_all(f, &p);
    float n[3];
    octahedron_unpack16(samples_u32(t.samples, PLANE_NORMAL, 0)[27], n);
    assert_true(fabsf(n[1] - 0.7071f) < 0.01f && fabsf(n[2] - 0.7071f) < 0.01f);
    assert_true(fabsf(n[0]) < 0.01f);
    traced_fini(&t);
    free(f);
}

/* A panel whose left texel is a hole: camera and shadow rays go through it. */
TEST(test_alpha_mask)
{
    static const uint8_t hole[8] = {255, 255, 255, 0, 255, 255, 255, 255};
    for (int mode = ALPHA_OPAQUE; mode <= ALPHA_BLEND; mode++) {
        struct scene_fixture *f = fixture_new();
        struct plan p = floor_plan(f, 4.0f, 32);
        uint32_t masked = fixture_material(f, 1, 1, 1), texture = fixture_texture(f, 2, 1, hole, 0);
        f->textures[texture].filter = FILTER_NEAREST;
        f->materials[masked].base_color_texture.texture = texture;
        f->materials[masked].alpha_mode = (uint32_t)mode;
        f->materials[masked].alpha_cutoff = 0.5f;
        fixture_panel(f, masked, (float[]){0, 1, 0}, (float[]){3, 0, 0}, (float[]){0, 0, -3});
        struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
        sun->direction[1] = -1;
        struct traced t = trace_all(f, &p);
        for (int32_t i = 0; i < 32 * 32; i++) {
            bool through = i % 32 < 16 && mode != ALPHA_OPAQUE;
            assert_int_equal(samples_u32(t.samples, PLANE_ID, 0)[i], through ? 1 : 2);
            assert_true(samples_light_irradiance(t.samples, 0)[i] > 0.99f);
        }
        traced_fini(&t);
        p.camera.eye[1] = 0.5f; /* below the panel: what lies in its shadow? */
        t = trace_all(f, &p);
        for (int32_t i = 0; i < 32 * 32; i++) {
            bool lit = i % 32 < 16 && mode != ALPHA_OPAQUE;
            assert_true((samples_light_irradiance(t.samples, 0)[i] > 0.99f) == lit);
        }
        traced_fini(&t);
        free(f);
    }
}

TEST(test_degenerate_triangles_are_harmless)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 16);
    uint32_t mesh = fixture_mesh(f, 0, 0);
    fixture_vertex(f, 0, 1, 0);
    fixture_vertex(f, 0.5f, 1, 0);
    fixture_vertex(f, 1, 1, 0);
    fixture_triangle(f, 0, 0, 0);
    fixture_triangle(f, 0, 1, 2);
    fixture_triangle(f, 1, 1, 2);
    fixture_place(f, mesh);
    uint32_t empty = fixture_mesh(f, 0, 0);
    fixture_place(f, empty);
    fixture_ceiling_light(&p, 0, 2, 0, 0.5f, 3);
    fixture_bounces(&p, 2);
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 256; i++) assert_true(samples_f32(t.samples, PLANE_DEPTH, 0)[i] > 3.9f);
    assert_int_equal(count(&t, COUNTER_REJECTED_NOT_FINITE), 0);
    traced_fini(&t);
    free(f);
}

/* Embree reports hits at an infinite distance where its products overflow. */
TEST(test_overflowing_triangles_are_missed)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 16);
    const float far = 1e14f;
    fixture_panel(f, 0, (float[]){0, -far, 0}, (float[]){far, 0, 0}, (float[]){0, 0, -far});
    p.camera.eye[1] = far;
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 256; i++) {
        assert_true(isfinite(samples_f32(t.samples, PLANE_DEPTH, 0)[i]));
        assert_int_equal(samples_u32(t.samples, PLANE_ID, 0)[i] != 0,
                         samples_f32(t.samples, PLANE_DEPTH, 0)[i] > 0.0f);
    }
    traced_fini(&t);
    free(f);
}

TEST(test_sub_samples)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 1.03f, 32); /* its edge cuts pixels */
    p.sub_samples = 3;
    p.planes |=
        PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) | PLANE_BIT(SUB_ID);
    struct traced t = trace_all(f, &p);
    int mixed = 0, total = 0;
    for (int32_t i = 0; i < 32 * 32; i++)
        for (uint32_t k = 0; k < 3; k++) {
            bool hit = samples_u16(t.samples, PLANE_SUB_ID, k)[i] != 0;
            float depth = half_to_float(samples_u16(t.samples, PLANE_SUB_DEPTH, k)[i]);
            bool centre = samples_u32(t.samples, PLANE_ID, 0)[i] != 0;
            float n[3];
            octahedron_unpack8(samples_u16(t.samples, PLANE_SUB_NORMAL, k)[i], n);
            if (!hit) assert_true(depth == SUB_DEPTH_MISS);
            if (hit && centre) assert_true(fabsf(depth) < 0.05f);
            if (hit) assert_true(n[1] > 0.99f);
            if (hit && !centre) assert_true(depth > 2.9f && depth < 3.6f); /* over length_unit */
            assert_int_equal(samples_u16(t.samples, PLANE_SUB_ALBEDO, 3 * k)[i], hit ? 32768 : 0);
            mixed += hit != centre;
            total += hit;
        }
    assert_true(mixed > 10);
    /* the rays cover the floor's area: 1.03^2/4 of the image */
    assert_true(abs(total - (int)(3 * 32 * 32 * 1.03 * 1.03 / 4)) < 40);
    assert_int_equal(count(&t, COUNTER_RAYS_ANTIALIAS), 3 * 32 * 32);
    traced_fini(&t);
    free(f);
}
