/* No surface shadows itself, at any scale, distance from the origin or angle. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#include "proto/half.h"

static float random_signed(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (float)(int32_t)(*state >> 32) * 0x1p-31f;
}

static void unit(float v[3])
{
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++) v[i] /= length;
}

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* A frame around a random normal. */
static void random_frame(uint64_t *state, float u[3], float v[3], float n[3])
{
    float other[3];
    for (int i = 0; i < 3; i++) {
        n[i] = random_signed(state);
        other[i] = random_signed(state);
    }
    unit(n);
    cross(n, other, u);
    unit(u);
    cross(n, u, v);
}

struct setting {
    float size, away; /* of the triangle; its distance from the origin in sizes */
    float elevation;  /* of the light over the surface, radians */
    bool instanced;
};

/* Pixels of a triangle that a sun above it does not reach. Nothing else is there. */
static int shadowed_pixels(const struct setting *s, uint64_t *seed)
{
    struct scene_fixture *f = fixture_new();
    float u[3], v[3], n[3], eye[3], c[3];
    random_frame(seed, u, v, n);
    for (int i = 0; i < 3; i++) c[i] = s->size * s->away * random_signed(seed);
    for (int i = 0; i < 3; i++) eye[i] = c[i] + s->size * (0.8f * n[i] + 0.5f * u[i]);
    struct plan p = fixture_plan(24, 24, eye, 0.4f);
    float forward[3], right[3], up[3];
    for (int i = 0; i < 3; i++) forward[i] = c[i] - eye[i];
    unit(forward);
    cross(forward, v, right);
    unit(right);
    cross(right, forward, up);
    fixture_look(&p, forward, up);
    fixture_material(f, 1, 1, 1);
    uint32_t mesh = fixture_mesh(f, 0, 0);
    float at[3];
    for (int i = 0; i < 3; i++) at[i] = s->instanced ? 0.0f : c[i];
    for (int k = 0; k < 3; k++) {
        float a = k == 0 ? 2.0f : -1.0f, b = k == 1 ? 2.0f : k == 2 ? -2.0f : 0.0f;
        fixture_vertex(f, at[0] + s->size * (a * u[0] + b * v[0]),
                       at[1] + s->size * (a * u[1] + b * v[1]),
                       at[2] + s->size * (a * u[2] + b * v[2]));
    }
    fixture_triangle(f, 0, 1, 2);
    if (s->instanced)
        fixture_place_at(f, mesh, (float[]){1, 0, 0, c[0], 0, 1, 0, c[1], 0, 0, 1, c[2]});
    else
        fixture_place(f, mesh);
    struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    for (int i = 0; i < 3; i++)
        sun->direction[i] = -cosf(s->elevation) * v[i] - sinf(s->elevation) * n[i];
    p.length_unit = s->size;
    fixture_bounces(&p, 2);
    struct traced t = trace_all(f, &p);
    int shadowed = 0;
    for (int32_t i = 0; i < 24 * 24; i++) {
        if (samples_u32(t.samples, PLANE_ID, 0)[i] == 0) continue;
        if (samples_light_irradiance(t.samples, 0)[i] <= 0.0f) shadowed++;
        if (samples_u16(t.samples, PLANE_BOUNCE_DISTANCE_MIN, 0)[i] !=
            half_from_float(BOUNCE_DISTANCE_NONE))
            shadowed++; /* hit itself */
    }
    traced_fini(&t);
    free(f);
    return shadowed;
}

TEST(test_no_acne)
{
    static const float sizes[] = {1e-4f, 1e-2f, 1.0f, 1e3f, 1e5f};
    static const float distances[] = {0.0f, 1.0f, 100.0f, 1e4f, 1e5f};
    static const float elevations[] = {1.2f, 0.2f, 0.02f};
    uint64_t seed = 11;
    for (int instanced = 0; instanced < 2; instanced++)
        for (int a = 0; a < 5; a++)
            for (int b = 0; b < 5; b++)
                for (int c = 0; c < 3; c++) {
                    struct setting s = {sizes[a], distances[b], elevations[c], instanced};
                    /* where the grid of floats is coarser than the angle, a sun may set */
                    if (s.away >= 1e4f && s.elevation < 0.1f) continue;
                    for (int round = 0; round < 3; round++) {
                        int shadowed = shadowed_pixels(&s, &seed);
                        if (shadowed)
                            print_message("size %g away %g elevation %g instanced %d: %d\n",
                                          (double)s.size, (double)s.away, (double)s.elevation,
                                          instanced, shadowed);
                        assert_int_equal(shadowed, 0);
                    }
                }
}

/* The offset must not jump over what is near: a slab above the floor still shades it. */
TEST(test_near_blockers_are_seen)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 16);
    fixture_panel(f, 0, (float[]){0, 1e-4f, 0}, (float[]){2.5f, 0, 0}, (float[]){0, 0, -2.5f});
    p.camera.eye[1] = 5e-5f;
    p.camera.half_width = p.camera.half_height = 2.0f / 5e-5f;
    struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    sun->direction[1] = -1;
    struct traced t = trace_all(f, &p);
    for (int32_t i = 0; i < 256; i++)
        assert_true(samples_light_irradiance(t.samples, 0)[i] == 0.0f);
    traced_fini(&t);
    free(f);
}
