/* Questions to Embree, packet by packet, against single rays. */
#include <stdlib.h>
#include <unistd.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/trace/hit/queries.h"

enum { OLD_BYTES = 256 * 1024, PACKETS = 500, PATIENCE_S = 30 };

/* Leaves its pattern where the next function called will have its variables. */
static __attribute__((noinline)) void soil_stack(uint8_t pattern)
{
    volatile uint8_t old[OLD_BYTES];
    for (size_t i = 0; i < OLD_BYTES; i++) old[i] = pattern;
    (void)old[0];
}

static float next_float(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-23f - 1.0f;
}

/* Rays from around the origin towards +z, any lanes of them on. */
static void random_packet(uint32_t *state, struct lanes_mask *valid, struct RTCRayHit16 *rays)
{
    queries_init_rays(rays);
    for (int i = 0; i < LANES; i++) {
        valid->on[i] = -(next_float(state) > 0.0f);
        rays->ray.org_x[i] = next_float(state);
        rays->ray.org_y[i] = next_float(state);
        rays->ray.dir_x[i] = i & 1 ? -0.0f : 0.3f * next_float(state);
        rays->ray.dir_y[i] = 0.3f * next_float(state);
        rays->ray.dir_z[i] = 1.0f;
        rays->ray.tfar[i] = INFINITY;
    }
}

static bool single_occluded(const struct render_scene *scene, const struct RTCRay16 *r, int i)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRay ray = {.org_x = r->org_x[i],
                         .org_y = r->org_y[i],
                         .org_z = r->org_z[i],
                         .dir_x = r->dir_x[i],
                         .dir_y = r->dir_y[i],
                         .dir_z = r->dir_z[i],
                         .tfar = INFINITY,
                         .mask = ~0u};
    rtcOccluded1(scene->top, &context, &ray);
    return ray.tfar < 0.0f;
}

static void expect_as_single(const struct render_scene *scene)
{
    struct queries q;
    queries_init(&q);
    q.scene = scene;
    uint32_t state = 1, blocked = 0, free_ways = 0;
    alarm(PATIENCE_S); /* a query that never returns shall fail, not hang */
    for (int n = 0; n < PACKETS; n++) {
        struct lanes_mask valid;
        _Alignas(LANES_ALIGN) struct RTCRayHit16 rays;
        random_packet(&state, &valid, &rays);
        soil_stack(0xa5);
        queries_occluded(&q, n & 1 ? QUERY_SHADOW : QUERY_BOUNCE_SHADOW, &valid, &rays);
        for (int i = 0; i < LANES; i++) {
            bool expected = valid.on[i] && single_occluded(scene, &rays.ray, i);
            assert_int_equal(rays.ray.tfar[i] < 0.0f, expected);
            blocked += expected;
            free_ways += valid.on[i] && !expected;
        }
    }
    alarm(0);
    assert_true(blocked > PACKETS && free_ways > PACKETS);
}

static struct scene_fixture *fixture_start(void)
{
    struct scene_fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    return f;
}

static struct render_scene *scene_of(struct scene_fixture *f)
{
    struct render_scene *scene = NULL;
    struct fault fault = {0};
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    return scene;
}

/* A quad at z = 2 across the middle, not placed yet; its mesh. */
static uint32_t add_quad(struct scene_fixture *f)
{
    uint32_t mesh = fixture_mesh(f, fixture_material(f, 1, 1, 1), 0);
    fixture_quad(f, (float[]){-0.5f, -0.5f, 2}, (float[]){1, 0, 0}, (float[]){0, 1, 0});
    return mesh;
}

TEST(test_occlusion_by_triangles)
{
    struct scene_fixture *f = fixture_start();
    fixture_place(f, add_quad(f));
    struct render_scene *scene = scene_of(f);
    assert_false(scene->has_instances);
    expect_as_single(scene);
    render_scene_destroy(&scene);
    free(f);
}

TEST(test_occlusion_by_instances)
{
    struct scene_fixture *f = fixture_start();
    uint32_t mesh = add_quad(f);
    for (int i = 0; i < 6; i++)
        fixture_place_at(f, mesh,
                         (float[]){0.4f, 0, 0, (float)(i % 3) - 1, 0, 0.4f, 0,
                                   (float)(i / 3) - 0.5f, 0, 0, 1, 0.25f * (float)i});
    fixture_place(f, add_quad(f));
    struct render_scene *scene = scene_of(f);
    assert_true(scene->has_instances);
    expect_as_single(scene);
    render_scene_destroy(&scene);
    free(f);
}
