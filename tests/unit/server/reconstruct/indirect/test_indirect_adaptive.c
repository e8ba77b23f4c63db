/* Widths and rates of adaptive sampling: at values computed by hand, at their bounds, and over
 * patches of formulas. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/samples.h"
#include "server/reconstruct/indirect/indirect.h"
#include "server/reconstruct/indirect/indirect_adaptive.h"
#include "server/reconstruct/indirect/indirect_width.h"
#include "tests/unit/unit.h"

static void near(float value, double expected)
{
    if (!(fabs((double)value - expected) <= 1e-5 * fabs(expected)))
        fail_msg("%.9g is not %.9g", (double)value, expected);
}

/* Equations 15 and 16: 2 z / (2.8 mu), and no less than 2 d / (3 mu). */
TEST(widths_are_the_papers)
{
    const struct indirect_bandlimit band = indirect_bandlimit_lambert();
    near(indirect_adaptive_width(&band, 1.0f, &(struct indirect_span){1.4f, 2.0f, 0.01f}), 1.0);
    near(indirect_adaptive_width(&band, 2.0f, &(struct indirect_span){1.4f, 2.0f, 0.01f}), 0.5);
    near(indirect_adaptive_width(&band, 1.0f, &(struct indirect_span){0.0014f, 2.0f, 0.3f}), 0.2);
    near(indirect_adaptive_width(&band, 4.0f, &(struct indirect_span){0.0f, 2.0f, 0.3f}), 0.05);
    assert_true(indirect_adaptive_width(&band, 1e-3f, &(struct indirect_span){1e38f, 1e38f, 1.0f}) <
                INFINITY);
}

/* Equation 21 by hand: gamma (mu 2.8 d / z + 0.3)^2 2.8^2 (1 + mu z_far / z)^2. */
TEST(rates_are_the_papers)
{
    const struct indirect_bandlimit band = indirect_bandlimit_lambert();
    /* 0.4 (0.28 + 0.3)^2 7.84 (1 + 4)^2 */
    near(indirect_adaptive_rays(&band, 1.0f, &(struct indirect_span){1.0f, 4.0f, 0.1f}), 26.37376);
    /* 0.4 (0.56 + 0.3)^2 7.84 (1 + 8)^2 */
    near(indirect_adaptive_rays(&band, 2.0f, &(struct indirect_span){1.0f, 4.0f, 0.1f}),
         187.871846);
    /* a parallel reflector far away: 0.4 0.09 7.84 4 */
    near(indirect_adaptive_rays(&band, 1.0f, &(struct indirect_span){1e6f, 1e6f, 1e-3f}), 1.12896);
    /* scaling the scene changes nothing */
    for (float unit = 1e-4f; unit < 2e5f; unit *= 10.0f)
        near(indirect_adaptive_rays(&band, 1.0f,
                                    &(struct indirect_span){unit, 4 * unit, 0.1f * unit}),
             26.37376);
    assert_true(indirect_adaptive_rays(&band, 100.0f,
                                       &(struct indirect_span){1e-30f, 1e30f, 1e30f}) < INFINITY);
}

TEST(bandlimits_are_those_of_surfaces)
{
    const struct indirect_bandlimit lambert = indirect_bandlimit_lambert();
    near(lambert.omega, 2.8);
    near(lambert.gamma, 0.4);
    near(indirect_bandlimit_blinn_phong(20.0f).omega, 5.28);
    near(indirect_bandlimit_blinn_phong(0.0f).omega, 3.6);
    static const float exponents[] = {1, 1.5f, 4, 12, 20, 50, 1000, 1e5f};
    for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k++) {
        const double c = pow(sqrt(0.5), 1.0 / (double)exponents[k]), half_pi = acos(0.0);
        near(indirect_bandlimit_blinn_phong(exponents[k]).gamma, acos(c) / half_pi);
    }
    near(indirect_bandlimit_blinn_phong(0.0f).gamma, 0.5); /* as of 1 */
    /* sharper lobes ask for more, in spite of their samples lying closer */
    const struct indirect_span span = {1.0f, 2.0f, 0.01f};
    const struct indirect_bandlimit blinn = indirect_bandlimit_blinn_phong(50.0f);
    assert_true(indirect_adaptive_width(&blinn, 1.0f, &span) <
                indirect_adaptive_width(&lambert, 1.0f, &span));
}

/* Of GGX's facets: m = 2 / alpha^2 - 2, along the fit up to 50, then as lobes narrow. */
TEST(facets_have_exponents)
{
    static const float exponents[] = {4, 20, 49.9f};
    for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k++) {
        const float alpha = sqrtf(2.0f / (exponents[k] + 2.0f));
        const struct indirect_bandlimit facets = indirect_bandlimit_facets(alpha);
        const struct indirect_bandlimit blinn = indirect_bandlimit_blinn_phong(exponents[k]);
        assert_true(fabsf(facets.omega - blinn.omega) < 1e-3f * blinn.omega);
        assert_true(fabsf(facets.gamma - blinn.gamma) < 1e-3f * blinn.gamma);
    }
    near(indirect_bandlimit_facets(1.0f).omega, 3.6); /* m = 0 */
    near(indirect_bandlimit_facets(2.0f).omega, 3.6);
    /* m = 1248: 7.8 sqrt(1248 / 50), and lobes that hold ever fewer directions */
    near(indirect_bandlimit_facets(0.04f).omega, 38.968436);
    near(indirect_bandlimit_facets(0.04f).gamma, indirect_bandlimit_blinn_phong(1248.0f).gamma);
    float before = 0.0f;
    for (float alpha = 1.0f; alpha > 0.001f; alpha *= 0.9f) {
        const struct indirect_bandlimit band = indirect_bandlimit_facets(alpha);
        assert_true(band.omega > before && band.omega < INFINITY && band.gamma > 0.0f);
        before = band.omega;
    }
    assert_true(indirect_bandlimit_facets(0.0f).omega < INFINITY);
}

TEST(strata_are_what_is_left_in_squares)
{
    static const struct {
        float rays;
        uint32_t most, strata;
    } cases[] = {
        {0, 100, 0},     {16, 100, 0},        {16.2f, 100, 0},        {16.3f, 100, 1},
        {18.3f, 100, 2}, {22.3f, 100, 3},     {32, 100, 4},           {80, 100, 8},
        {100, 100, 9},   {1e9f, 100, 9},      {1e9f, 16, 0},          {1e9f, 8, 0},
        {1e9f, 17, 1},   {1e9f, 20, 2},       {1e9f, LIMIT_SPP, 255}, {70000, LIMIT_SPP, 255},
        {NAN, 100, 0},   {INFINITY, 116, 10}, {-5, 100, 0},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        assert_int_equal(indirect_adaptive_strata(cases[k].rays, 16, cases[k].most),
                         cases[k].strata);
}

#define SIDE 16

/* A floor seen from straight above, a unit away, all of one object; pixels measure 2 / SIDE. */
static void floor_plan(struct plan *plan, float unit)
{
    memset(plan, 0, sizeof *plan);
    plan->width_px = plan->height_px = SIDE;
    plan->camera = (struct plan_camera){.type = CAMERA_ORTHOGRAPHIC,
                                        .right = {1, 0, 0},
                                        .up = {0, 0, -1},
                                        .forward = {0, -1, 0},
                                        .half_width = unit,
                                        .half_height = unit};
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) | PLANE_BIT(INDIRECT_MEAN) |
                   PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(BOUNCE_DISTANCE_MAX);
    plan->bounces = 1;
    plan->indirect_filter = INDIRECT_FILTER_ADAPTIVE;
    plan->indirect_strata_per_axis = 4;
    plan->adaptive = (struct plan_adaptive){.mu = 1, .rays_max = 100};
    plan->mu = 1;
    plan->length_unit = unit;
}

static void floor_patch(const struct plan *plan, float near_z, float far_z, struct patch **out)
{
    const struct rect all = {0, 0, plan->width_px, plan->height_px};
    assert_int_equal(patch_create(plan, all, out), 0);
    for (size_t i = 0; i < (size_t)rect_area(all); i++) {
        struct patch *p = *out;
        p->depth[i] = plan->length_unit;
        for (int k = 0; k < 3; k++) p->normal[k][i] = k == 1 ? 1.0f : 0.0f;
        p->id[i] = 1;
        p->bounce_distance_min[i] = near_z * plan->length_unit;
        p->bounce_distance_max[i] = far_z * plan->length_unit;
        for (int c = 0; c < 3; c++) p->indirect[c][i] = 1.0f;
        p->bounces[i] = 16.0f;
    }
}

static uint8_t strata_at(const uint8_t *strata_map, int x, int y)
{
    return strata_map[y * SIDE + x];
}

/* 8 px at 512 lines are 0.25 px of 0.125 here: far below these distances. */
TEST(patches_ask_for_rays)
{
    static const float units[] = {1.0f, 1e-4f, 1e5f};
    for (int k = 0; k < 3; k++) {
        struct plan plan;
        struct patch *patch;
        uint8_t strata_map[SIDE * SIDE];
        const struct rect all = {0, 0, SIDE, SIDE}, part = {5, 3, 12, 9};
        floor_plan(&plan, units[k]);
        floor_patch(&plan, 1.0f, 4.0f, &patch);
        /* 0.4 (0.35 + 0.3)^2 7.84 25 = 33.1: 17 more, 4 x 4 */
        assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), 0);
        for (int i = 0; i < SIDE * SIDE; i++) assert_int_equal(strata_map[i], 4);
        /* one near thing counts for the pixels around, as a harmonic mean, and for no others */
        patch->bounce_distance_min[8 * SIDE + 8] = 0.01f * units[k];
        assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), 0);
        assert_true(strata_at(strata_map, 6, 6) == 9 && strata_at(strata_map, 10, 10) == 9);
        assert_true(strata_at(strata_map, 5, 8) == 4 && strata_at(strata_map, 8, 11) == 4);
        /* a pixel in a crack sees nothing but it */
        patch->bounce_distance_max[8 * SIDE + 8] = 0.01f * units[k];
        assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), 0);
        assert_true(strata_at(strata_map, 6, 6) == 9 && strata_at(strata_map, 10, 10) == 9);
        assert_true(strata_at(strata_map, 5, 8) == 4 && strata_at(strata_map, 8, 11) == 4);
        uint8_t cut[7 * 6];
        assert_int_equal(indirect_adaptive_find(&plan, patch, part, cut), 0);
        for (int y = part.y0; y < part.y1; y++)
            assert_memory_equal(cut + (y - part.y0) * 7, strata_map + y * SIDE + part.x0, 7);
        patch_destroy(&patch);
    }
}

/* Each lobe asks by its own roughness and by how far it sees, whatever bounce rays met; pixels
 * without one do not. */
TEST(lobes_ask_for_rays)
{
    struct plan plan;
    struct patch *patch;
    uint8_t strata_map[SIDE * SIDE];
    const struct rect all = {0, 0, SIDE, SIDE};
    floor_plan(&plan, 1.0f);
    plan.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_SPAN);
    plan.adaptive.rays_max = 4096;
    floor_patch(&plan, 0.01f, 100.0f, &patch);
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int x = i % SIDE;
        patch->glossy_alpha[i] = x < 5 ? 0.2f : x < 10 ? 0.04f : 0.0f;
        patch->glossy_near[i] = x < 10 ? 10.0f : 0.0f;
        patch->glossy_far[i] = x < 10 ? 60.0f : 0.0f;
    }
    assert_int_equal(indirect_adaptive_find_lobes(&plan, patch, all, strata_map), 0);
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int x = i % SIDE;
        const struct indirect_span span = {10.0f, 60.0f, 0.125f};
        const struct indirect_bandlimit band = indirect_bandlimit_facets(x < 5 ? 0.2f : 0.04f);
        const uint32_t asked =
            indirect_adaptive_strata(indirect_adaptive_rays(&band, 1.0f, &span), 16, 4096);
        assert_int_equal(strata_map[i], x < 10 ? asked : 0);
    }
    assert_true(strata_at(strata_map, 2, 2) > 0 &&
                strata_at(strata_map, 7, 7) > strata_at(strata_map, 2, 2));
    /* bounce rays ask by what they met */
    assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), 0);
    assert_true(strata_at(strata_map, 2, 2) == 63 && strata_at(strata_map, 12, 2) == 63);
    /* a lobe that sees nothing has enough */
    for (int i = 0; i < SIDE * SIDE; i++) {
        patch->glossy_near[i] = patch->glossy_near[i] > 0.0f ? BOUNCE_DISTANCE_NONE : 0.0f;
        patch->glossy_far[i] = 0.0f;
    }
    assert_int_equal(indirect_adaptive_find_lobes(&plan, patch, all, strata_map), 0);
    for (int i = 0; i < SIDE * SIDE; i++) assert_int_equal(strata_map[i], 0);
    patch->glossy_far = NULL;
    assert_int_equal(indirect_adaptive_find_lobes(&plan, patch, all, strata_map), ERR_RANGE);
    patch_destroy(&patch);
}

/* Equation 21 asks for 0.4 0.09 7.84 (1 + mu)^2 rays and little more of what sees a parallel
 * reflector far away. */
TEST(rays_grow_with_mu_everywhere)
{
    static const struct {
        float mu;
        uint32_t strata;
    } cases[] = {{0.5f, 0}, {1, 0}, {1.5f, 6}, {2, 11}, {3, 20}};
    struct plan plan;
    struct patch *patch;
    uint8_t strata_map[SIDE * SIDE];
    const struct rect all = {0, 0, SIDE, SIDE};
    floor_plan(&plan, 1.0f);
    floor_patch(&plan, 1e4f, 1e4f, &patch);
    plan.adaptive.rays_max = 4096;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        plan.adaptive.mu = cases[k].mu; /* 16 mu^3: 54, 128, 432 */
        assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), 0);
        for (int i = 0; i < SIDE * SIDE; i++) assert_int_equal(strata_map[i], cases[k].strata);
    }
    patch_destroy(&patch);
}

TEST(what_meets_nothing_asks_for_nothing)
{
    struct plan plan;
    struct patch *patch;
    uint8_t strata_map[SIDE * SIDE];
    const struct rect all = {0, 0, SIDE, SIDE};
    floor_plan(&plan, 1.0f);
    floor_patch(&plan, BOUNCE_DISTANCE_NONE, 0.0f, &patch);
    memset(strata_map, 7, sizeof strata_map);
    assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), 0);
    for (int i = 0; i < SIDE * SIDE; i++) assert_int_equal(strata_map[i], 0);
    /* all hits at distance 0, as the tracer tells of them: as many as there may be, and no more */
    for (int i = 0; i < SIDE * SIDE; i++)
        patch->bounce_distance_min[i] = patch->bounce_distance_max[i] = 6e-8f;
    assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), 0);
    for (int i = 0; i < SIDE * SIDE; i++) assert_int_equal(strata_map[i], 9);
    for (int i = 0; i < SIDE * SIDE; i++)
        patch->bounce_distance_min[i] = patch->bounce_distance_max[i] = 0.0f;
    assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), 0);
    for (int i = 0; i < SIDE * SIDE; i++)
        assert_int_equal(strata_map[i], 0); /* black, or background */
    assert_int_equal(indirect_adaptive_find(&plan, patch, (struct rect){0, 0, 0, 1}, strata_map),
                     ERR_RANGE);
    assert_int_equal(indirect_adaptive_find(&plan, patch, (struct rect){9, 9, 17, 17}, strata_map),
                     ERR_RANGE);
    patch_destroy(&patch);
    plan.planes &= ~PLANE_BIT(BOUNCE_DISTANCE_MAX);
    floor_plan(&plan, 1.0f);
    floor_patch(&plan, 1.0f, 4.0f, &patch);
    patch->bounce_distance_max = NULL;
    assert_int_equal(indirect_adaptive_find(&plan, patch, all, strata_map), ERR_RANGE);
    patch_destroy(&patch);
}

TEST(one_pixel_is_a_frame)
{
    struct plan plan;
    struct patch *patch;
    struct indirect_statistics statistics = {0};
    uint8_t side = 99;
    floor_plan(&plan, 1.0f);
    plan.width_px = plan.height_px = 1;
    floor_patch(&plan, 1.0f, 4.0f, &patch);
    const struct rect all = {0, 0, 1, 1};
    assert_int_equal(indirect_adaptive_find(&plan, patch, all, &side), 0);
    assert_int_equal(side, 9); /* the pixel is as large as the floor */
    float value[3], width;
    float *const out[3] = {&value[0], &value[1], &value[2]};
    const float *const in[3] = {patch->indirect[0], patch->indirect[1], patch->indirect[2]};
    assert_int_equal(indirect_filter(&plan, patch, all, 3, in, out, &width, &statistics), 0);
    assert_true(value[0] == 1.0f && width > 0.0f);
    patch_destroy(&patch);
}

/* The filter takes its widths from the first set's distances: the paper's, cut at the cap. */
TEST(filters_are_as_wide)
{
    static const float mus[] = {0.5f, 1.0f, 3.0f, 20.0f};
    for (int k = 0; k < 4; k++) {
        struct plan plan;
        struct patch *patch;
        struct indirect_statistics statistics = {0};
        floor_plan(&plan, 1.0f);
        plan.width_px = plan.height_px = 512;
        plan.adaptive.mu = mus[k];
        const struct indirect_rule rule = indirect_rule_of(&plan);
        const struct indirect_bandlimit band = indirect_bandlimit_lambert();
        const float mu = fmaxf(mus[k], 1.0f); /* below 1 widths stay */
        near(rule.most_px, 7.5 / cbrt((double)mu));
        assert_true(indirect_halo_px(&plan) <= INDIRECT_REACH_MAX_PX);
        /* 9 px away, then 1 px, which counts as 8, then far beyond the cap */
        static const float distances_px[] = {9.0f, 1.0f, 1e6f};
        for (int d = 0; d < 3; d++) {
            plan.width_px = plan.height_px = 512;
            const float pixel = 2.0f / 512.0f, z = fmaxf(distances_px[d], 8.0f) * pixel;
            const struct rect all = {0, 0, SIDE, SIDE};
            floor_patch(&plan, distances_px[d] * pixel, 1e7f, &patch);
            float *memory = calloc((size_t)rect_area(patch->rect) * 4, sizeof *memory);
            const size_t area = (size_t)rect_area(patch->rect);
            float *const out[3] = {memory, memory + area, memory + 2 * area};
            const float *const in[3] = {patch->indirect[0], patch->indirect[1], patch->indirect[2]};
            assert_int_equal(
                indirect_filter(&plan, patch, all, 3, in, out, memory + 3 * area, &statistics), 0);
            const struct indirect_span span = {z, 1e7f, pixel};
            const double free_px = (double)indirect_adaptive_width(&band, mu, &span) * 256.0;
            near(memory[3 * area], fmin(free_px, (double)rule.most_px));
            assert_true(memory[0] == 1.0f);
            free(memory);
            patch_destroy(&patch);
        }
    }
}
