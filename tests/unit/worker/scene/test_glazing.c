/* Which lamps shine through glass, and how large what they shine through is. */
#include <math.h>

#include "proto/plan.h"
#include "tests/unit/worker/scene/room_fixture.h"
#include "worker/scene/openness.h"

static struct room_fixture r;
static uint32_t lamp, glass;

static void begin(void)
{
    room_fixture_begin(&r);
    lamp = fixture_material(r.parts, 0, 0, 0);
    glass = fixture_glossy(r.parts, (float[]){1, 1, 1}, 0.3f, 0.0f);
    r.parts->materials[lamp].emission[0] = 5.0f;
    r.parts->materials[lamp].flags |= MATERIAL_DOUBLE_SIDED;
    r.parts->materials[glass].transmission = 1.0f;
}

/* A shining square of half side 0.1. */
static void add_lamp(float x, float y, float z)
{
    fixture_panel(r.parts, lamp, (float[]){x, y, z}, (float[]){0.1f, 0, 0}, (float[]){0, 0, 0.1f});
}

/* Six panes around a place. */
static void add_bulb(float x, float y, float z, float half)
{
    for (int k = 0; k < 3; k++)
        for (int side = -1; side < 2; side += 2) {
            float c[3] = {x, y, z}, u[3] = {0}, v[3] = {0};
            c[k] += (float)side * half;
            u[(k + 1) % 3] = v[(k + 2) % 3] = half;
            fixture_panel(r.parts, glass, c, u, v);
        }
}

static const struct emitter_groups *lamps(void)
{
    room_fixture_build(&r);
    return &r.scene->glazing.lamps;
}

TEST(a_lamp_in_a_bulb_is_as_large_as_the_bulb)
{
    begin();
    add_lamp(1, 2, 3);
    add_bulb(1, 2, 3, 0.15f);
    const struct emitter_groups *g = lamps();
    assert_true(r.scene->has_glass);
    float power = 0.0f;
    assert_true(g->count > 0); /* its triangles may be on their own */
    for (uint32_t k = 0; k < g->count; k++) {
        power += g->power[k];
        assert_true(fabsf(g->x[k] - 1) < 0.1f && fabsf(g->y[k] - 2) < 0.1f);
        assert_true(g->radius[k] > 0.15f && g->radius[k] < 0.35f);
    }
    const float luminance = 0.2126f * 5.0f, area = 0.04f;
    assert_true(fabsf(power / (luminance * area) - 1.0f) < 0.01f);
    room_fixture_close(&r);
}

TEST(behind_a_far_pane_it_is_as_large_as_itself)
{
    for (uint32_t clear = 0; clear < 2; clear++) {
        begin();
        r.parts->materials[glass].roughness = clear ? 0.05f : 0.3f;
        add_lamp(1, 2, 3);
        fixture_panel(r.parts, glass, (float[]){1, 0, 3}, (float[]){9, 0, 0}, (float[]){0, 0, 9});
        const struct emitter_groups *g = lamps();
        assert_true((g->count > 0) == clear); /* paths do not find it through a frosted one */
        for (uint32_t k = 0; k < g->count; k++) assert_true(g->radius[k] < 0.15f);
        room_fixture_close(&r);
    }
}

TEST(a_lamp_in_the_open_is_none)
{
    begin();
    add_lamp(1, 2, 3);
    add_bulb(5, 2, 3, 0.15f); /* elsewhere */
    assert_int_equal(lamps()->count, 0);
    room_fixture_close(&r);
}

/* Half of its rays meet its own far wall. */
TEST(a_bulb_that_shines_itself_is_none)
{
    begin();
    r.parts->materials[glass].emission[1] = 3.0f;
    r.parts->materials[glass].flags |= MATERIAL_DOUBLE_SIDED;
    add_bulb(1, 2, 3, 0.15f);
    assert_int_equal(lamps()->count, 0);
    room_fixture_close(&r);
}

TEST(opaque_bulbs_hide_lamps)
{
    begin();
    r.parts->materials[glass].transmission = 0.0f;
    add_lamp(1, 2, 3);
    add_bulb(1, 2, 3, 0.15f);
    assert_int_equal(lamps()->count, 0);
    assert_false(r.scene->has_glass);
    room_fixture_close(&r);
}

/* Each triangle is on its own, so there are more than places. */
TEST(of_many_lamps_the_brightest_are_kept)
{
    float most = 0.0f;
    begin();
    for (uint32_t k = 0; k < 12; k++) {
        const float x = 3.0f * (float)k, half = k == 7 ? 0.2f : k == 10 ? 0.02f : 0.1f;
        fixture_panel(r.parts, lamp, (float[]){x, 0, 0}, (float[]){half, 0, 0},
                      (float[]){0, 0, half});
    }
    fixture_panel(r.parts, glass, (float[]){16, 1, 0}, (float[]){40, 0, 0}, (float[]){0, 0, 40});
    fixture_panel(r.parts, glass, (float[]){16, -1, 0}, (float[]){40, 0, 0}, (float[]){0, 0, 40});
    r.parts->materials[glass].roughness = 0.0f;
    const struct emitter_groups *g = lamps();
    assert_int_equal(g->count, EMITTER_GROUPS);
    for (uint32_t k = 0; k < g->count; k++) {
        assert_true(g->power[k] > 0.0f && g->radius[k] > 0.0f);
        assert_true(fabsf(g->x[k] - 30.0f) > 1.0f); /* not the faintest */
        if (fabsf(g->x[k] - 21.0f) < 1.0f) most = fmaxf(most, g->power[k]);
    }
    for (uint32_t k = 0; k < g->count; k++) assert_true(g->power[k] <= most);
    room_fixture_close(&r);
}

/* Rectangles are lights of the scene, not emitters. */
TEST(a_rectangle_over_a_pane_is_a_lamp)
{
    static const struct scene_light light = {.type = LIGHT_RECTANGLE,
                                             .position = {0, 2, 0},
                                             .direction = {0, -1, 0},
                                             .half_u = {0.5f, 0, 0},
                                             .half_v = {0, 0, 0.2f},
                                             .color = {1, 1, 1}};
    for (uint32_t glazed = 0; glazed < 2; glazed++) {
        struct glazing found;
        begin();
        r.parts->materials[glass].roughness = 0.0f;
        fixture_panel(r.parts, glass, (float[]){0, glazed ? 1.9f : 2.1f, 0}, (float[]){1, 0, 0},
                      (float[]){0, 0, 1});
        room_fixture_build(&r);
        r.parts->scene.lights = &light;
        r.parts->scene.count[SCENE_LIGHTS] = 1;
        glazing_learn(r.scene, &found);
        assert_int_equal(found.lamps.count, glazed);
        if (glazed) assert_true(found.lamps.radius[0] > 0.5f && found.lamps.power[0] > 0.3f);
        room_fixture_close(&r);
    }
}

TEST(a_pane_in_a_window_lets_the_sky_in)
{
    for (uint32_t glazed = 0; glazed < 2; glazed++) {
        begin();
        r.parts->materials[glass].roughness = 0.0f;
        room_fixture_add_room(&r);
        if (glazed)
            fixture_panel(r.parts, glass, (float[]){2, 1.75f, 0}, (float[]){0, 0.75f, 0},
                          (float[]){0, 0, 1});
        room_fixture_build(&r);
        struct openness *o = openness_create(r.scene);
        assert_non_null(o);
        openness_learn(o);
        const uint32_t cell = openness_grid_cell(openness_grid(o), (const float[3]){0, 1.6f, 0});
        const uint16_t number = openness_numbers(o)[cell], pane = openness_pane_numbers(o)[cell];
        assert_true(number > 0 && (pane > 0) == glazed);
        float open = 0.0f, through = 0.0f;
        for (uint32_t k = 0; k < OPENNESS_BINS; k++) {
            open = fmaxf(open, openness_of(o, number - 1u)[k]);
            if (glazed) through = fmaxf(through, openness_through(o, pane - 1u)[k]);
        }
        assert_true(glazed ? open == 0.0f && through > 0.8f : open > 0.8f);
        assert_true(openness_glazed(o)[cell] == (glazed ? 1.0f : 0.0f));
        openness_destroy(&o);
        room_fixture_close(&r);
    }
}
