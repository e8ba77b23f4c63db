/* What cameras see of surfaces with one side, on packets of every width. */
#include <math.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"
#include "worker/trace/hit/hit_kernels.h"

static const float half_x[3] = {1, 0, 0}, half_y[3] = {0, 1, 0}, half_minus_x[3] = {-1, 0, 0};

/* Panels at z = 1 (front faces -z: a camera at +z sees its back), and z = 0 (front faces +z). */
static struct scene_fixture *two_panels(uint32_t flags)
{
    struct scene_fixture *f = fixture_new();
    const uint32_t culled = fixture_material(f, 1, 0, 0), plain = fixture_material(f, 0, 1, 0);
    f->materials[culled].flags |= flags;
    fixture_panel(f, culled, (float[]){0, 0, 1}, half_minus_x, half_y);
    fixture_panel(f, plain, (float[]){0, 0, 0}, half_x, half_y);
    return f;
}

/* The instances that sixteen rays from z = 3 meet; one lane looks past all. */
static void look(struct scene_fixture *f, enum query_kind kind, uint32_t width, uint32_t met[LANES])
{
    struct render_scene *scene;
    struct fault fault = {0};
    struct queries q;
    struct lanes_mask valid;
    _Alignas(LANES_ALIGN) struct RTCRayHit16 rays;
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    if (width < scene->packet_width) scene->packet_width = width;
    queries_init(&q);
    q.scene = scene;
    q.kernels = KERNELS_FOR(hit_kernels, all_isas[0]);
    queries_init_rays(&rays);
    for (int i = 0; i < LANES; i++) {
        valid.on[i] = -1;
        rays.ray.org_x[i] = i == 5 ? 9.0f : ((float)i - 7.5f) / 10.0f;
        rays.ray.org_y[i] = 0.1f, rays.ray.org_z[i] = 3.0f;
        rays.ray.dir_z[i] = -1.0f;
        rays.ray.tfar[i] = INFINITY;
    }
    queries_closest(&q, kind, &valid, &rays);
    for (int i = 0; i < LANES; i++) {
        const uint32_t placed = rays.hit.instID[0][i];
        met[i] = placed != RTC_INVALID_GEOMETRY_ID ? placed : rays.hit.geomID[i];
        const float at = met[i] == 0 ? 2.0f : 3.0f;
        if (met[i] != RTC_INVALID_GEOMETRY_ID) assert_true(fabsf(rays.ray.tfar[i] - at) < 1e-5f);
    }
    render_scene_destroy(&scene);
}

static void expect(struct scene_fixture *f, enum query_kind kind, uint32_t instance)
{
    static const uint32_t widths[] = {16, 8, 4};
    for (int w = 0; w < 3; w++) {
        uint32_t met[LANES];
        look(f, kind, widths[w], met);
        for (int i = 0; i < LANES; i++)
            assert_int_equal(met[i], i == 5 ? RTC_INVALID_GEOMETRY_ID : instance);
    }
}

TEST(cameras_look_through_backs)
{
    struct scene_fixture *f = two_panels(MATERIAL_CULLED);
    expect(f, QUERY_CAMERA, 1);
    expect(f, QUERY_BOUNCE, 0); /* all other rays meet both sides */
    free(f);
    f = two_panels(0);
    expect(f, QUERY_CAMERA, 0);
    free(f);
}

TEST(fronts_are_seen)
{
    struct scene_fixture *f = two_panels(MATERIAL_CULLED);
    f->materials[1].flags |= MATERIAL_CULLED;
    expect(f, QUERY_CAMERA, 1);
    free(f);
}

/* Turned about z and stretched, the panel still shows its back; turned about y, its front. */
TEST(placements_turn_sides)
{
    const float about_z[12] = {0, -2, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0};
    const float about_y[12] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 2};
    struct scene_fixture *f = two_panels(MATERIAL_CULLED);
    f->instances[0].flags = 0;
    memcpy(f->instances[0].to_world, about_z, sizeof about_z);
    expect(f, QUERY_CAMERA, 1);
    expect(f, QUERY_BOUNCE, 0);
    memcpy(f->instances[0].to_world, about_y, sizeof about_y);
    expect(f, QUERY_CAMERA, 0);
    free(f);
}

/* Meshes have two sides by having all faces twice. */
TEST(a_front_at_the_same_place_is_seen)
{
    struct scene_fixture *both = fixture_new();
    const uint32_t culled = fixture_material(both, 1, 0, 0);
    both->materials[culled].flags |= MATERIAL_CULLED;
    const uint32_t mesh = fixture_mesh(both, culled, 0);
    fixture_quad(both, (float[]){0, 0, 1}, half_minus_x, half_y);
    fixture_quad(both, (float[]){0, 0, 1}, half_x, half_y);
    fixture_place(both, mesh);
    expect(both, QUERY_CAMERA, 0);
    free(both);
}

/* Glass has a back that is seen through its front. */
TEST(what_lets_light_through_is_seen_from_behind)
{
    struct scene_fixture *f = two_panels(MATERIAL_CULLED);
    f->materials[0].transmission = 1.0f;
    expect(f, QUERY_CAMERA, 0);
    f->materials[0].transmission = 0.0f;
    f->materials[0].alpha_mode = ALPHA_BLEND; /* rays without keys meet it as a mask */
    f->materials[0].base_color[3] = 0.75f;
    expect(f, QUERY_CAMERA, 0);
    free(f);
}
