/* Paths that are sent to light behind glass bring the same light as others, with less noise. The
 * glass has the index of air, so that what it lets through is known: what light samples bring
 * without it. */
#include "proto/half.h"
#include "tests/unit/worker/trace/path/path_fixture.h"

#include "tests/unit/worker/scene/environment_fixture.h"
#include "worker/scene/photon_targets.h"
#include "worker/scene/photons.h"

enum { SPP = 16, WIDTH = 16, HEIGHT = 8 };

static uint32_t air(struct scene_fixture *f)
{
    const uint32_t glass = fixture_glossy(f, (float[]){1, 1, 1}, 0.0f, 0.0f);
    f->materials[glass].transmission = 1.0f;
    f->materials[glass].ior = 1.0f;
    return glass;
}

/* A floor, of which a part is glossy. */
static struct plan floors(struct scene_fixture *f)
{
    struct plan p = floor_plan(f, 3.0f, SIDE_PX);
    const uint32_t glossy = fixture_glossy(f, (float[]){0.2f, 0.6f, 0.2f}, 0.3f, 0.0f);
    fixture_panel(f, glossy, (float[]){-1, 0.1f, 0}, (float[]){0.8f, 0, 0}, (float[]){0, 0, -0.8f});
    p.planes = PLANES_PATH & ~PATH_BIT(VISIBILITY);
    p.light_planes = 0;
    p.bounces = 1;
    p.paths.spp = SPP;
    return p;
}

/* The same with a lamp that faces down, where the camera does not see it. */
static struct plan lit_floors(struct scene_fixture *f)
{
    struct plan p = floors(f);
    const uint32_t lamp = fixture_material(f, 0, 0, 0);
    f->materials[lamp].emission[0] = 40.0f;
    f->materials[lamp].emission[1] = 20.0f;
    fixture_panel(f, lamp, (float[]){1.8f, 2.0f, 0}, (float[]){0.1f, 0, 0}, (float[]){0, 0, 0.1f});
    p.paths.emitter_power = 1.0f;
    return p;
}

/* A pane below it, or between all of the floor and the sky. */
static void add_pane(struct scene_fixture *f, float x, float y, float half)
{
    fixture_panel(f, air(f), (float[]){x, y, 0}, (float[]){half, 0, 0}, (float[]){0, 0, -half});
}

/* The pane's scattering makes direct light indirect. */
static void expect_light_of(const struct traced *behind, const struct traced *open)
{
    for (uint32_t c = 0; c < 2; c++) {
        const double spread =
            mean(behind, PLANE_PATH_M2, c, SPP) + mean(open, PLANE_PATH_M2, c, SPP);
        const double expected = mean(open, PLANE_PATH_DIRECT, c, SPP);
        assert_true(expected > 1e-3);
        assert_near(mean(behind, PLANE_PATH_INDIRECT, c, SPP), expected,
                    4 * sqrt(spread / (SPP * SIDE_PX * SIDE_PX)));
        assert_near(mean(behind, PLANE_PATH_INDIRECT, c, SPP), expected, 0.05 * expected);
    }
}

static struct traced trace_under(struct scene_fixture *f, const struct plan *p,
                                 const struct environment *map, bool guided)
{
    struct traced t = {0};
    const struct tile_job job = {.plan = p, .environment = map, .rect = {0, 0, SIDE_PX, SIDE_PX}};
    open_traced(f, &t);
    t.scene->has_glass &= guided;
    assert_int_equal(trace_tile(&t, job, 0, &t.samples), 0);
    return t;
}

TEST(a_lamp_behind_a_pane_lights_as_without_it)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_floors(f);
    struct traced open = trace_all(f, &p);
    add_pane(f, 5.6f, 1.95f, 4.2f); /* to beside the camera's view */
    struct traced sent = trace_under(f, &p, NULL, true), chance = trace_under(f, &p, NULL, false);
    expect_light_of(&sent, &open);
    expect_equal_light(&sent, &chance, PLANE_PATH_RADIANCE, SPP);
    assert_true(mean(&sent, PLANE_PATH_M2, 0, SPP) < 0.2 * mean(&chance, PLANE_PATH_M2, 0, SPP));
    traced_fini(&chance);
    traced_fini(&sent);
    traced_fini(&open);
    free(f);
}

/* A faint sky with a sun high up. */
static void open_sun(struct environment_fixture *e)
{
    static float texels[3 * WIDTH * HEIGHT];
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) texels[i] = 0.1f;
    for (int k = 0; k < 3; k++) texels[3 * (1 * WIDTH + 5) + k] = 60.0f;
    environment_fixture_open(e, WIDTH, HEIGHT, texels);
}

TEST(a_sun_behind_a_pane_lights_as_without_it)
{
    struct environment_fixture sun;
    struct scene_fixture *f = fixture_new();
    struct plan p = floors(f);
    open_sun(&sun);
    p.environment = (struct plan_environment){
        .kind = ENVIRONMENT_MAP, .rotation_rad = 0.4f, .radiance = {1, 1, 1}};
    struct traced open = trace_under(f, &p, sun.map, true);
    add_pane(f, 0.0f, 4.5f, 500.0f);
    struct traced sent = trace_under(f, &p, sun.map, true);
    struct traced chance = trace_under(f, &p, sun.map, false);
    expect_light_of(&sent, &open);
    expect_equal_light(&sent, &chance, PLANE_PATH_RADIANCE, SPP);
    assert_true(mean(&sent, PLANE_PATH_M2, 0, SPP) < 0.5 * mean(&chance, PLANE_PATH_M2, 0, SPP));
    traced_fini(&chance);
    traced_fini(&sent);
    traced_fini(&open);
    environment_fixture_close(&sun);
    free(f);
}

/* without: what lenses and mirrors gather is left to chance. */
static struct traced trace_gathered(struct scene_fixture *f, const struct plan *p,
                                    const struct environment *map, bool without)
{
    struct traced t = {0};
    const struct tile_job job = {.plan = p, .environment = map, .rect = {0, 0, SIDE_PX, SIDE_PX}};
    open_traced(f, &t);
    assert_non_null(t.scene->targets);
    if (without) {
        photons_destroy(&t.scene->caustics);
        free(t.scene->targets);
        t.scene->targets = NULL;
    }
    assert_int_equal(trace_tile(&t, job, 0, &t.samples), 0);
    return t;
}

/* Returns the variance of paths that are sent over that of chance. */
static double expect_gathered(struct scene_fixture *f, const struct plan *p,
                              const struct environment *map, double least)
{
    struct traced sent = trace_gathered(f, p, map, false);
    struct traced chance = trace_gathered(f, p, map, true);
    expect_equal_light(&sent, &chance, PLANE_PATH_RADIANCE, p->paths.spp);
    expect_equal_light(&sent, &chance, PLANE_PATH_INDIRECT, p->paths.spp);
    assert_true(mean(&sent, PLANE_PATH_INDIRECT, 0, p->paths.spp) > least);
    const double variance =
        mean(&sent, PLANE_PATH_M2, 0, p->paths.spp) / mean(&chance, PLANE_PATH_M2, 0, p->paths.spp);
    traced_fini(&chance);
    traced_fini(&sent);
    return variance;
}

/* A mirror beside the floor throws a lamp's light back on it. */
static void add_mirror(struct scene_fixture *f)
{
    const uint32_t mirror = fixture_glossy(f, (float[]){0.9f, 0.9f, 0.9f}, 0.0f, 1.0f);
    fixture_panel(f, mirror, (float[]){3.2f, 1, 0}, (float[]){0, 1, 0}, (float[]){0, 0, 1.5f});
}

TEST(what_mirrors_gather_is_the_same_with_less_noise)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_floors(f);
    add_mirror(f);
    assert_true(expect_gathered(f, &p, NULL, 0.001) < 0.1);
    free(f);
}

/* Two prisms of glass over floor and paint, a sun, and a lamp beside a mirror: both maps. */
TEST(what_lenses_gather_is_the_same)
{
    struct environment_fixture sun;
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_floors(f);
    const uint32_t glass = fixture_glossy(f, (float[]){0.9f, 1, 0.9f}, 0.0f, 0.0f);
    open_sun(&sun);
    f->materials[glass].transmission = 1.0f;
    f->materials[glass].thickness = 1.0f;
    add_mirror(f);
    for (int k = 0; k < 2; k++) {
        const float x = (float)k * 1.6f - 0.8f, lean = k ? 0.2f : -0.2f;
        fixture_panel(f, glass, (float[]){x, 1.0f, 0}, (float[]){0.7f, lean, 0},
                      (float[]){0, 0, -0.8f});
        fixture_panel(f, glass, (float[]){x, 0.6f, 0}, (float[]){0.7f, 0, 0},
                      (float[]){0, 0, 0.8f});
    }
    p.environment = (struct plan_environment){
        .kind = ENVIRONMENT_MAP, .rotation_rad = 0.4f, .radiance = {1, 1, 1}};
    p.bounces = 4;
    p.paths.spp = 64;
    assert_true(expect_gathered(f, &p, sun.map, 0.01) < 1.0);
    environment_fixture_close(&sun);
    free(f);
}

/* Nothing changes but the way: surfaces that light samples reach bring the same light. */
TEST(other_light_stays)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_floors(f);
    const uint32_t lamp = fixture_material(f, 0, 0, 0);
    f->materials[lamp].emission[1] = 30.0f;
    fixture_panel(f, lamp, (float[]){-1, 1, 0.5f}, (float[]){0.2f, 0, 0}, (float[]){0, 0, 0.2f});
    fixture_panel(f, air(f), (float[]){1.8f, 1.9f, 0}, (float[]){0.3f, 0, 0},
                  (float[]){0, 0, -0.3f}); /* below the first one alone */
    p.bounces = 3;
    struct traced sent = trace_under(f, &p, NULL, true), chance = trace_under(f, &p, NULL, false);
    expect_equal_light(&sent, &chance, PLANE_PATH_DIRECT, SPP);
    expect_equal_light(&sent, &chance, PLANE_PATH_RADIANCE, SPP);
    traced_fini(&chance);
    traced_fini(&sent);
    free(f);
}

/* Seen in clear glass the floor's light counts as diffuse, however the path was sent on. */
TEST(diffuse_light_behind_glass_is_as_bright)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_floors(f);
    add_pane(f, 5.6f, 1.95f, 4.2f);
    fixture_panel(f, air(f), (float[]){0, 3.5f, 0}, (float[]){1, 0, 0}, (float[]){0, 0, -1});
    p.bounces = 3;
    p.planes |= PLANES_RESIDUAL_READ | PATH_BIT(DIFFUSE_DIRECT) | PATH_BIT(DIFFUSE_INDIRECT);
    struct traced sent = trace_under(f, &p, NULL, true), chance = trace_under(f, &p, NULL, false);
    for (uint32_t c = 0; c < 2; c++) {
        const double expected = mean(&chance, PLANE_PATH_DIFFUSE_INDIRECT, c, SPP);
        assert_true(expected > 1e-3);
        assert_near(mean(&sent, PLANE_PATH_DIFFUSE_INDIRECT, c, SPP), expected, 0.25 * expected);
    }
    traced_fini(&chance);
    traced_fini(&sent);
    free(f);
}

/* Rays of the field of indirect light go through panes, too, where they may end by chance. */
TEST(fields_see_lamps_behind_panes)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_floors(f);
    add_pane(f, 5.6f, 1.95f, 4.2f);
    p.planes = 0;
    p.paths.spp = 0;
    fixture_bounces(&p, 8);
    p.bounces = 3;
    double light[2];
    for (uint32_t sent = 0; sent < 2; sent++) {
        struct traced t = trace_under(f, &p, NULL, sent);
        light[sent] = 0;
        for (int i = 0; i < SIDE_PX * SIDE_PX; i++)
            light[sent] += (double)half_to_float(samples_u16(t.samples, PLANE_INDIRECT_MEAN, 0)[i]);
        traced_fini(&t);
    }
    assert_true(light[0] > 0.0);
    assert_near(light[1], light[0], 0.2 * light[0]);
    free(f);
}
