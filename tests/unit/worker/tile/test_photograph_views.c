/* What virtual mirrors show of a photograph, against where each point of the floor is in it. */
#include <math.h>
#include <string.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/scene/environment_fixture.h"
#include "tests/unit/worker/tile_fixture.h"

enum { SIDE = 96, SPP = 16 };

static const float centre[3] = {0.8f, 1.0f, 0}, normal[3] = {-0.8660254f, 0.5f, 0};

/* A floor that catches, under a sun, seen from above; a mirror over it that leans to the left, and
 * a small roof over a part of what it shows. */
static struct plan mirror_plan(struct scene_fixture *f)
{
    struct plan p = floor_plan(f, 2.0f, SIDE);
    f->instances[0].flags |= INSTANCE_CATCHER;
    const uint32_t mirror = fixture_glossy(f, (float[]){1, 1, 1}, 0, 1);
    fixture_panel(f, mirror, centre, (float[]){0.25f, 0.4330127f, 0}, (float[]){0, 0, -0.5f});
    const uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
    fixture_panel(f, grey, (float[]){-1.3f, 0.8f, 0.6f}, (float[]){0.3f, 0, 0},
                  (float[]){0, 0, -0.4f});
    struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    memcpy(sun->direction, (float[]){0, -1, 0}, sizeof sun->direction);
    p.planes = PLANE_BIT(PATH_RADIANCE) | PLANE_BIT(PATH_COVERAGE);
    p.light_planes = p.sub_samples = 0;
    p.paths.spp = SPP;
    p.bounces = 2;
    p.composite = 1;
    p.photograph.fit = PHOTOGRAPH_STRETCHED;
    return p;
}

/* A photograph of half the picture's size, whose colour tells the place. */
static void open_plate(struct environment_fixture *plate)
{
    static float texels[3 * SIDE / 2 * SIDE / 2];
    for (int i = 0; i < SIDE / 2 * SIDE / 2; i++) {
        texels[3 * i] = ((float)(i % (SIDE / 2)) + 0.5f) / (SIDE / 2);
        texels[3 * i + 1] = ((float)(i / (SIDE / 2)) + 0.5f) / (SIDE / 2);
        texels[3 * i + 2] = 2.0f;
    }
    environment_fixture_open(plate, SIDE / 2, SIDE / 2, texels);
}

/* Returns where the floor is that pixel (x, y) shows in the mirror. */
static void mirrored_point(const struct plan *p, int32_t x, int32_t y, double out[3])
{
    float from[3], way[3];
    double along = 0, facing = 0;
    plan_camera_ray(p, (float)x + 0.5f, (float)y + 0.5f, from, way);
    for (int k = 0; k < 3; k++) along += (double)((centre[k] - from[k]) * normal[k]);
    for (int k = 0; k < 3; k++) facing += (double)(way[k] * normal[k]);
    double at[3], to[3];
    for (int k = 0; k < 3; k++) at[k] = (double)from[k] + along / facing * (double)way[k];
    for (int k = 0; k < 3; k++) to[k] = (double)way[k] - 2 * facing * (double)normal[k];
    for (int k = 0; k < 3; k++) out[k] = at[k] - at[1] / to[1] * to[k];
}

/* Calls for each pixel that the mirror fills, with its mean. */
static uint32_t compare(const struct plan *p, const struct samples *s,
                        bool (*is_of)(const double point[3]),
                        void (*expect)(const double point[3], const float mean[3]))
{
    const float *coverage = samples_f32(s, PLANE_PATH_COVERAGE, 0);
    uint32_t compared = 0;
    for (int32_t i = 0; i < SIDE * SIDE; i++) {
        double point[3], seen[3];
        float mean[3];
        floor_point(p, i % SIDE, i / SIDE, seen);
        if (coverage[i] < (float)SPP || seen[0] < 0) continue; /* the roof is to the left */
        mirrored_point(p, i % SIDE, i / SIDE, point);
        for (uint32_t k = 0; k < 3; k++)
            mean[k] = samples_f32(s, PLANE_PATH_RADIANCE, k)[i] / (float)SPP;
        if (!is_of(point)) continue;
        expect(point, mean);
        compared++;
    }
    return compared;
}

/* Far enough from the roof's shadow and the picture's border, since a pixel shows much. */
static bool is_open(const double p[3])
{
    return p[2] < -0.1 && p[2] > -1.4 && p[0] > -1.4;
}

static bool is_below_roof(const double p[3])
{
    return fabs(p[0] + 1.3) < 0.15 && p[2] > 0.3 && p[2] < 0.9;
}

/* The picture shows 4 units in each direction. */
static void expect_place(const double p[3], const float mean[3])
{
    const double place[2] = {p[0] / 4 + 0.5, p[2] / 4 + 0.5};
    for (int k = 0; k < 2; k++)
        if (!(fabs((double)mean[k] - place[k]) < 0.02))
            fail_msg("(%g, %g) shows %g for %g", p[0], p[2], (double)mean[k], place[k]);
    assert_true(fabsf(mean[2] - 2.0f) < 1e-4f); /* not a bit is lost */
}

static void expect_shadow(const double p[3], const float mean[3])
{
    if (!(mean[2] < 0.5f)) fail_msg("(%g, %g) is lit by %g", p[0], p[2], (double)mean[2]);
}

static struct samples *trace_objects(struct traced *t, const struct plan *p,
                                     const struct environment_blob *plate)
{
    struct samples *samples = NULL;
    const struct tile_job job = {
        .plan = p, .photograph = plate, .rect = {0, 0, p->width_px, p->height_px}};
    assert_int_equal(trace_tile(t, job, PLAN_VIEW_OBJECTS, &samples), 0);
    return samples;
}

TEST(mirrors_show_the_photograph_at_its_place)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = mirror_plan(f);
    struct environment_fixture plate;
    struct traced t = {0};
    open_plate(&plate);
    open_traced(f, &t);
    struct samples *s = trace_objects(&t, &p, &plate.blob);
    assert_true(compare(&p, s, is_open, expect_place) > 5);
    assert_true(compare(&p, s, is_below_roof, expect_shadow) > 0);
    samples_destroy(&s);
    environment_fixture_close(&plate);
    traced_fini(&t);
}

/* Where the scene's light is twice as bright, or the catcher darker, the photograph is the same. */
TEST(the_scene_s_brightness_does_not_count)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = mirror_plan(f);
    struct environment_fixture plate;
    struct traced t = {0};
    for (int k = 0; k < 3; k++) f->materials[f->meshes[0].material].base_color[k] = 0.125f;
    for (int k = 0; k < 3; k++) p.lights[0].color[k] *= 2;
    open_plate(&plate);
    open_traced(f, &t);
    struct samples *s = trace_objects(&t, &p, &plate.blob);
    assert_true(compare(&p, s, is_open, expect_place) > 5);
    samples_destroy(&s);
    environment_fixture_close(&plate);
    traced_fini(&t);
}

TEST(a_photograph_that_is_not_there_is_missed)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = mirror_plan(f);
    struct traced t = {0};
    struct samples *samples = NULL;
    const struct tile_job job = {.plan = &p, .rect = {0, 0, SIDE, SIDE}};
    open_traced(f, &t);
    assert_int_equal(trace_tile(&t, job, PLAN_VIEW_OBJECTS, &samples), ERR_MISSING);
    traced_fini(&t);
}
