/* Surfaces that are partly there: through Embree in every width, and the numbers behind it. */
#include <embree3/rtcore.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/scene/alpha.h"

#define RAYS 65536

/* Panels over each other at heights 0, -1, -2 ..., seen from above. */
static struct render_scene *stack(struct scene_fixture *f, const float *opacities, int count,
                                  uint32_t mode, bool placed)
{
    struct render_scene *scene;
    struct fault fault = {0};
    const float x[3] = {1, 0, 0}, z[3] = {0, 0, -1};
    for (int i = 0; i < count; i++) {
        const float c[3] = {0, (float)-i, 0}, origin[3] = {0};
        const float at[12] = {1, 0, 0, 0, 0, 1, 0, (float)-i, 0, 0, 1, 0};
        uint32_t m = fixture_material(f, 1, 1, 1);
        f->materials[m].alpha_mode = mode;
        f->materials[m].alpha_cutoff = 0.5f;
        f->materials[m].base_color[3] = opacities[i];
        uint32_t mesh = fixture_mesh(f, m, 0);
        fixture_quad(f, placed ? origin : c, x, z);
        if (placed)
            fixture_place_at(f, mesh, at);
        else
            fixture_place(f, mesh);
    }
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    return scene;
}

static struct RTCRayHit ray_down(uint32_t key)
{
    /* off the diagonal that the panel's triangles share */
    struct RTCRayHit r = {.ray = {.org_x = 0.3f,
                                  .org_y = 1,
                                  .org_z = 0.1f,
                                  .dir_y = -1,
                                  .tfar = INFINITY,
                                  .mask = UINT32_MAX,
                                  .id = key}};
    r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

/* The panel that a ray of that key meets; `count` when it meets none. */
static int meets(const struct render_scene *scene, uint32_t key, int count)
{
    struct RTCIntersectContext context;
    struct RTCRayHit r = ray_down(key);
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene->top, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return count;
    return (int)(r.ray.tfar - 0.5f);
}

static void expect_share(int seen, int of, double share)
{
    double sigma = sqrt(of * share * (1.0 - share)) + 1e-9;
    assert_true(fabs(seen - of * share) < 5.0 * sigma);
}

/* Each panel passes on 1 - a of what reaches it, whether meshes stand alone or are instances. */
TEST(panels_weaken_by_opacity)
{
    const float opacities[4] = {0.3f, 0.5f, 0.9f, 0.02f};
    for (int placed = 0; placed < 2; placed++) {
        struct scene_fixture *f = calloc(1, sizeof *f);
        struct render_scene *scene = stack(f, opacities, 4, ALPHA_BLEND, placed);
        int seen[5] = {0};
        double left = 1.0;
        for (uint32_t key = 1; key <= RAYS; key++) seen[meets(scene, key, 4)]++;
        for (int i = 0; i < 4; i++) {
            expect_share(seen[i], RAYS, left * (double)opacities[i]);
            left *= 1.0 - (double)opacities[i];
        }
        expect_share(seen[4], RAYS, left);
        render_scene_destroy(&scene);
        free(f);
    }
}

/* Opacity 1 always stays, 0 never does. */
TEST(ends_are_certain)
{
    const float opacities[3] = {0.0f, 0.0f, 1.0f};
    struct scene_fixture *f = calloc(1, sizeof *f);
    struct render_scene *scene = stack(f, opacities, 3, ALPHA_BLEND, false);
    assert_false(scene->meshes[2].material->blend); /* no filter at all */
    assert_true(scene->meshes[2].material->alpha_cutoff == 0.0f);
    for (uint32_t key = 0; key < RAYS; key++) assert_int_equal(meets(scene, key, 3), 2);
    render_scene_destroy(&scene);
    free(f);
}

TEST(rays_without_key_see_masks)
{
    const float opacities[3] = {0.3f, 0.49f, 0.51f};
    struct scene_fixture *f = calloc(1, sizeof *f);
    struct render_scene *scene = stack(f, opacities, 3, ALPHA_BLEND, false);
    assert_int_equal(meets(scene, 0, 3), 2);
    render_scene_destroy(&scene);
    f->material_count = f->mesh_count = f->instance_count = 0;
    f->vertex_count = f->triangle_count = 0;
    scene = stack(f, opacities, 3, ALPHA_MASK, false);
    for (uint32_t key = 0; key < 1000; key++) assert_int_equal(meets(scene, key, 3), 2);
    render_scene_destroy(&scene);
    free(f);
}

/* Packets of sixteen ask the filter with arrays: the same keys must see the same surfaces, and
 * shadow rays what closest hits do. */
TEST(widths_and_queries_agree)
{
    const float opacities[2] = {0.4f, 0.3f};
    for (int placed = 0; placed < 2; placed++) {
        struct scene_fixture *f = calloc(1, sizeof *f);
        struct render_scene *scene = stack(f, opacities, 2, ALPHA_BLEND, placed);
        for (uint32_t first = 1; first < 4096; first += 16) {
            struct RTCIntersectContext context;
            struct RTCRayHit16 wide;
            _Alignas(64) int valid[16];
            memset(&wide, 0, sizeof wide);
            for (uint32_t i = 0; i < 16; i++) {
                struct RTCRayHit one = ray_down(first + i);
                valid[i] = -1;
                wide.ray.org_x[i] = one.ray.org_x;
                wide.ray.org_y[i] = one.ray.org_y;
                wide.ray.org_z[i] = one.ray.org_z;
                wide.ray.dir_y[i] = -1.0f;
                wide.ray.tfar[i] = INFINITY;
                wide.ray.mask[i] = UINT32_MAX;
                wide.ray.id[i] = first + i;
                wide.hit.geomID[i] = wide.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
            }
            struct RTCRay16 shadow = wide.ray;
            rtcInitIntersectContext(&context);
            rtcIntersect16(valid, scene->top, &context, &wide);
            rtcOccluded16(valid, scene->top, &context, &shadow);
            for (uint32_t i = 0; i < 16; i++) {
                int one = meets(scene, first + i, 2);
                bool hit = wide.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
                assert_int_equal(hit ? (int)(wide.ray.tfar[i] - 0.5f) : 2, one);
                assert_int_equal(shadow.tfar[i] < 0.0f, one < 2);
            }
        }
        render_scene_destroy(&scene);
        free(f);
    }
}

/* Neighbouring keys, triangles and instances draw numbers that know nothing of each other. */
TEST(draws_are_independent)
{
    const float opacities[1] = {0.5f};
    struct scene_fixture *f = calloc(1, sizeof *f);
    struct render_scene *scene = stack(f, opacities, 1, ALPHA_BLEND, false);
    const struct alpha_hit steps[] = {{.ray = 1},      {.instance = 1}, {.geometry = 1},
                                      {.triangle = 1}, {.ray = 65536},  {.instance = 256}};
    for (size_t s = 0; s < sizeof steps / sizeof steps[0]; s++) {
        int both = 0, first = 0;
        for (uint32_t i = 0; i < RAYS; i++) {
            struct alpha_hit a = {.ray = 1 + 97 * i, .triangle = 0, .u = 0.2f, .v = 0.2f};
            struct alpha_hit b = a;
            b.ray += steps[s].ray;
            b.instance += steps[s].instance;
            b.geometry += steps[s].geometry;
            b.triangle += steps[s].triangle;
            bool covered = alpha_covers(&scene->meshes[0], &a);
            first += covered;
            both += covered && alpha_covers(&scene->meshes[0], &b);
        }
        expect_share(first, RAYS, 0.5);
        expect_share(both, RAYS, 0.25);
    }
    render_scene_destroy(&scene);
    free(f);
}
