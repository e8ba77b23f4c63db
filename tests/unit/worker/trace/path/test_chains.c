/* What filters are told of surfaces that a camera path sees in mirrors and through clear glass. */
#include <math.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

enum { SIDE = 16, SPP = 16 };

/* A panel three units ahead, a red wall as far behind the eye, a green one six units ahead. */
static struct plan view_of(struct scene_fixture *f, uint32_t *panel)
{
    const uint32_t red = fixture_material(f, 0.75f, 0.25f, 0.125f);
    const uint32_t green = fixture_material(f, 0.25f, 0.5f, 0.125f);
    *panel = fixture_material(f, 0.5f, 0.8f, 1);
    fixture_panel(f, *panel, (float[]){0, 0, -3}, (float[]){2, 0, 0}, (float[]){0, 2, 0});
    fixture_panel(f, red, (float[]){0, 0, 3}, (float[]){-20, 0, 0}, (float[]){0, 20, 0});
    fixture_panel(f, green, (float[]){0, 0, -6}, (float[]){20, 0, 0}, (float[]){0, 20, 0});
    struct plan p = fixture_plan(SIDE, SIDE, (float[]){0, 0, 0}, 0.5f);
    p.environment =
        (struct plan_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 2, 4}, .power = 1};
    p.planes = PLANES_PATH_ALL & ~PLANE_BIT(PATH_VISIBILITY);
    p.light_planes = 0;
    p.bounces = 4;
    p.paths.spp = SPP;
    return p;
}

static struct scene_material *panel_of(struct scene_fixture *f, uint32_t panel)
{
    f->materials[panel].metallic = 1;
    f->materials[panel].roughness = 0;
    return &f->materials[panel];
}

static float mean(const struct traced *t, enum plane_id plane, uint32_t component, size_t i)
{
    return samples_f32(t->samples, plane, component)[i] / SPP;
}

/* All that a Lambert surface in a mirror sends is diffuse, of albedo times the mirror's colour. */
static void expect_mirrored(const struct traced *t, size_t i, const float albedo[3])
{
    assert_true(mean(t, PLANE_PATH_DISTANCE, 0, i) > 8.9f);
    assert_true(mean(t, PLANE_PATH_NORMAL, 2, i) < -0.999f);
    assert_true(mean(t, PLANE_PATH_TINT, 0, i) == 0.0f);
    for (uint32_t c = 0; c < 3; c++) {
        const float a = mean(t, PLANE_PATH_ALBEDO, c, i);
        const float d =
            mean(t, PLANE_PATH_DIFFUSE_DIRECT, c, i) + mean(t, PLANE_PATH_DIFFUSE_INDIRECT, c, i);
        const float all = mean(t, PLANE_PATH_RADIANCE, c, i);
        assert_true(fabsf(a - albedo[c]) < 1e-4f);
        if (!(fabsf(a * d - all) <= 1e-4f * all))
            fail_msg("%g of %g", (double)(a * d), (double)all);
    }
}

TEST(mirrors_show_what_filters_are_told_of)
{
    struct scene_fixture *f = fixture_new();
    uint32_t panel;
    const struct plan p = view_of(f, &panel);
    panel_of(f, panel);
    struct traced t = trace_all(f, &p);
    for (size_t i = 0; i < SIDE * SIDE; i++)
        expect_mirrored(&t, i, (float[]){0.5f * 0.75f, 0.8f * 0.25f, 0.125f});
    traced_fini(&t);
    free(f);
}

/* Fields know nothing of what is seen in a mirror. */
TEST(mirrors_beside_fields_of_diffuse_light)
{
    struct scene_fixture *f = fixture_new();
    uint32_t panel;
    struct plan p = view_of(f, &panel);
    panel_of(f, panel);
    p.paths.without_diffuse_direct = DIRECT_LEFT_ALL;
    p.paths.without_diffuse_indirect = true;
    struct traced t = trace_all(f, &p);
    const float albedo[3] = {0.375f, 0.2f, 0.125f};
    for (size_t i = 0; i < SIDE * SIDE; i++) expect_mirrored(&t, i, albedo);
    traced_fini(&t);
    free(f);
}

/* A pane reflects a twentieth, which each half of the samples shows once: what it lets through is
 * what counts. */
TEST(paths_that_stray_tell_nothing)
{
    struct scene_fixture *f = fixture_new();
    uint32_t panel, strayed = 0;
    const struct plan p = view_of(f, &panel);
    struct scene_material *pane = panel_of(f, panel);
    pane->metallic = 0;
    pane->transmission = 1;
    pane->ior = 1.5f;
    pane->specular = 1;
    struct traced t = trace_all(f, &p);
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        const float z = mean(&t, PLANE_PATH_DISTANCE, 0, i);
        const float a = mean(&t, PLANE_PATH_ALBEDO, 1, i);
        const float d =
            mean(&t, PLANE_PATH_DIFFUSE_DIRECT, 1, i) + mean(&t, PLANE_PATH_DIFFUSE_INDIRECT, 1, i);
        assert_true(z > 5.9f && z < 7.4f);
        assert_true(mean(&t, PLANE_PATH_NORMAL, 2, i) > 0.99f);
        /* of sixteen paths two are reflected, and the others weigh as much as all would */
        assert_true(fabsf(a - 0.5f * 0.8f * 0.96f * 16 / 14) < 0.005f);
        strayed += mean(&t, PLANE_PATH_RADIANCE, 1, i) - a * d > 1e-3f;
    }
    assert_in_range(strayed, 8, SIDE * SIDE - 8); /* what is reflected is seldom lit */
    traced_fini(&t);
    free(f);
}

/* However many panes are in the way, no path ends among them and tells of them instead. */
TEST(panes_do_not_end_paths_by_chance)
{
    struct scene_fixture *f = fixture_new();
    uint32_t panel;
    struct plan p = view_of(f, &panel);
    struct scene_material *pane = panel_of(f, panel);
    pane->metallic = 0;
    pane->transmission = 1;
    pane->ior = 1.5f;
    pane->specular = 0;
    for (int k = 0; k < 5; k++)
        fixture_panel(f, panel, (float[]){0, 0, -3.1f - 0.1f * (float)k}, (float[]){2, 0, 0},
                      (float[]){0, 2, 0});
    p.bounces = 8;
    struct traced t = trace_all(f, &p);
    for (size_t i = 0; i < SIDE * SIDE; i++)
        assert_true(mean(&t, PLANE_PATH_DISTANCE, 0, i) > 5.99f);
    traced_fini(&t);
    free(f);
}

/* A rough mirror is a surface of its own. */
TEST(rough_surfaces_are_no_chain)
{
    struct scene_fixture *f = fixture_new();
    uint32_t panel;
    const struct plan p = view_of(f, &panel);
    panel_of(f, panel)->roughness = 0.3f;
    struct traced t = trace_all(f, &p);
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        assert_true(mean(&t, PLANE_PATH_DISTANCE, 0, i) < 3.7f);
        assert_true(mean(&t, PLANE_PATH_ALBEDO, 0, i) == 0.0f);
        assert_true(mean(&t, PLANE_PATH_TINT, 0, i) > 0.4f);
    }
    traced_fini(&t);
    free(f);
}
