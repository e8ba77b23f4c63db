/* Normals that coats have of their own: the mesh's, or their own map's, turned to the viewer. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/path/path_kernels.h"

/* A panel in the plane z = 0 whose tangents run along x. */
static struct scene_fixture *coated_panel(void)
{
    struct scene_fixture *f = fixture_new();
    const uint32_t m = fixture_material(f, 0.5f, 0.5f, 0.5f);
    f->materials[m].clearcoat = 1.0f;
    const uint32_t mesh = fixture_mesh(f, m, MESH_HAS_NORMALS | MESH_HAS_TANGENTS);
    fixture_quad(f, (float[]){0, 0, 0}, (float[]){1, 0, 0}, (float[]){0, 1, 0});
    for (uint32_t v = 0; v < f->vertex_count; v++) {
        f->normals[3 * v] = f->normals[3 * v + 1] = 0.0f, f->normals[3 * v + 2] = 1.0f;
        f->tangents[4 * v] = f->tangents[4 * v + 3] = 1.0f;
        f->tangents[4 * v + 1] = f->tangents[4 * v + 2] = 0.0f;
    }
    fixture_place(f, mesh);
    return f;
}

/* A map of one normal, (0.6, 0, 0.8). */
static struct scene_texture_ref leaning(struct scene_fixture *f)
{
    const uint8_t rgba[4] = {204, 128, 230, 255};
    return (struct scene_texture_ref){.texture = fixture_texture(f, 1, 1, rgba, 0),
                                      .transform = {1, 0, 0, 0, 1, 0}};
}

/* The normals of surface and coat, in the world, that a ray from side * z sees. */
static void see(struct scene_fixture *f, float side, float surface[3], float coat[3], bool *bent)
{
    static struct path_vertex v;
    struct render_scene *scene;
    struct fault fault = {0};
    struct queries q;
    _Alignas(LANES_ALIGN) struct RTCRayHit16 rays;
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    queries_init(&q);
    q.scene = scene;
    q.kernels = KERNELS_FOR(hit_kernels, all_isas[0]);
    const struct path_context c = {.queries = &q,
                                   .kernels = KERNELS_FOR(path_kernels, all_isas[0])};
    queries_init_rays(&rays);
    memset(&v, 0, sizeof v);
    for (int i = 0; i < LANES; i++) {
        v.active.on[i] = -1;
        rays.ray.org_x[i] = 0.25f, rays.ray.org_y[i] = 0.125f, rays.ray.org_z[i] = 3 * side;
        rays.ray.dir_z[i] = -side;
        rays.ray.tfar[i] = INFINITY;
    }
    queries_closest(&q, QUERY_CAMERA, &v.active, &rays);
    hit_resolve(&q, &v.active, &rays, &v.surface);
    path_resolve(&c, &rays, &v);
    surface[0] = v.surface.normal.x[0], surface[1] = v.surface.normal.y[0];
    surface[2] = v.surface.normal.z[0];
    *bent = v.bsdf[0].coat_bent;
    path_from_frame(&v, 0, v.bsdf[0].coat_normal, coat);
    render_scene_destroy(&scene);
}

static void expect(const float got[3], float x, float y, float z)
{
    assert_true(fabsf(got[0] - x) < 0.01f && fabsf(got[1] - y) < 0.01f);
    assert_true(fabsf(got[2] - z) < 0.01f);
}

TEST(coats_have_maps_of_their_own)
{
    struct scene_fixture *f = coated_panel();
    float surface[3], coat[3];
    bool bent;
    see(f, 1, surface, coat, &bent);
    assert_false(bent);
    f->materials[0].clearcoat_normal_texture = leaning(f);
    see(f, 1, surface, coat, &bent);
    assert_true(bent);
    expect(surface, 0, 0, 1);
    expect(coat, 0.6f, 0, 0.8f);
    see(f, -1, surface, coat, &bent); /* from behind all is turned round */
    expect(surface, 0, 0, -1);
    expect(coat, -0.6f, 0, -0.8f);
    f->materials[0].clearcoat_normal_scale = 0.5f;
    see(f, 1, surface, coat, &bent);
    expect(coat, 0.351f, 0, 0.936f);
    free(f);
}

TEST(a_surfaces_map_does_not_bend_its_coat)
{
    struct scene_fixture *f = coated_panel();
    float surface[3], coat[3];
    bool bent;
    f->materials[0].normal_texture = leaning(f);
    see(f, 1, surface, coat, &bent);
    assert_true(bent);
    expect(surface, 0.6f, 0, 0.8f);
    expect(coat, 0, 0, 1);
    free(f);
}

TEST(coats_follow_placements)
{
    struct scene_fixture *f = coated_panel();
    const float turned[12] = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}; /* x becomes y */
    float surface[3], coat[3];
    bool bent;
    f->materials[0].clearcoat_normal_texture = leaning(f);
    f->instances[0].flags = 0;
    memcpy(f->instances[0].to_world, turned, sizeof turned);
    see(f, 1, surface, coat, &bent);
    expect(coat, 0, 0.6f, 0.8f);
    free(f);
}
