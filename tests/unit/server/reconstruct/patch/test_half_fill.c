/* Pixels without rays take what nodes beside them have, of their own surface. */
#include "server/reconstruct/patch/half_fill.h"

#include <string.h>

#include "proto/half_field.h"
#include "tests/unit/server/reconstruct/synthetic.h"
#include "tests/unit/unit.h"

#define SIDE 16
#define LIGHT                                                                                      \
    (PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) | PLANE_BIT(INDIRECT_MEAN) |             \
     PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(AMBIENT_VISIBILITY) | \
     PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_HALF))

struct wall {
    struct plan plan;
    struct patch *patch;
};

/* A wall that the camera faces. Only nodes have rays; light is a * x + b * y + 1. */
static void open_wall(struct wall *w, float a, float b)
{
    synthetic_plan(&w->plan, SIDE, SIDE, SIDE);
    w->plan.planes = LIGHT;
    w->plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    w->plan.indirect_strata_per_axis = 4;
    w->plan.field_halved = 1;
    assert_int_equal(patch_create(&w->plan, (struct rect){0, 0, SIDE, SIDE}, &w->patch), 0);
    struct patch *p = w->patch;
    memset(p->memory, 0, patch_bytes(&w->plan, SIDE * SIDE));
    const float *back = w->plan.camera.forward;
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) {
            const size_t i = patch_pixel(p, x, y);
            const float light = a * (float)x + b * (float)y + 1.0f;
            float origin[3], d[3];
            plan_camera_ray(&w->plan, (float)x + 0.5f, (float)y + 0.5f, origin, d);
            p->depth[i] = 10.0f / (d[0] * back[0] + d[1] * back[1] + d[2] * back[2]);
            for (int k = 0; k < 3; k++) p->normal[k][i] = -back[k];
            p->id[i] = 1;
            p->glossy_alpha[i] = 0.9f;
            if (!half_field_is_node(x, y)) continue;
            p->bounce_distance_min[i] = 5.0f;
            p->ambient_visibility[i] = 0.5f;
            p->glossy_weight[i] = p->glossy_half_weight[i] = 1.0f;
            p->glossy_nearness[i] = 0.1f;
            for (int c = 0; c < 3; c++) {
                p->indirect[c][i] = p->glossy[c][i] = p->glossy_half[c][i] = light;
                p->indirect_even[c][i] = light + 1.0f;
                p->indirect_odd[c][i] = light - 1.0f;
            }
        }
}

static void close_wall(struct wall *w)
{
    patch_destroy(&w->patch);
}

TEST(light_stays_linear)
{
    struct wall w;
    open_wall(&w, 0.25f, -0.03125f);
    half_fill(&w.plan, w.patch);
    for (int32_t y = 1; y < SIDE - 1; y++)
        for (int32_t x = 1; x < SIDE - 1; x++) {
            const size_t i = patch_pixel(w.patch, x, y);
            const float light = 0.25f * (float)x - 0.03125f * (float)y + 1.0f;
            const bool node = half_field_is_node(x, y);
            assert_true(patch_is_measured(w.patch, i));
            assert_true(fabsf(w.patch->indirect[1][i] - light) < 1e-5f);
            assert_true(fabsf(w.patch->glossy[2][i] - light) < 0.02f); /* lobes turn */
            assert_true(fabsf(w.patch->ambient_visibility[i] - 0.5f) < 1e-6f);
            assert_int_equal(w.patch->lent[i], node ? 0 : PATCH_LENT_BOUNCES | PATCH_LENT_LOBE);
        }
    close_wall(&w);
}

/* Each pixel takes of both halves those that the nodes tell of errors by. */
TEST(halves_are_those_of_nodes)
{
    struct wall w;
    open_wall(&w, 0, 0);
    half_fill(&w.plan, w.patch);
    for (int32_t y = 1; y < SIDE - 1; y++)
        for (int32_t x = 1; x < SIDE - 1; x++) {
            const size_t i = patch_pixel(w.patch, x, y);
            const float even = w.patch->indirect_even[0][i];
            assert_true(even == w.patch->indirect_odd[0][i]);
            if (half_field_is_node(x, y))
                assert_true(even == (half_field_part(x, y) ? 0.0f : 2.0f));
            else /* two of one half and two of the other, or one of each */
                assert_true(fabsf(even - 1.0f) < 1e-5f);
        }
    close_wall(&w);
}

TEST(other_surfaces_lend_nothing)
{
    struct wall w;
    open_wall(&w, 0, 0);
    struct patch *p = w.patch;
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 8; x < SIDE; x++) { /* an object beside the wall, and brighter */
            const size_t i = patch_pixel(p, x, y);
            p->id[i] = 2;
            for (int c = 0; c < 3; c++) p->indirect[c][i] *= 100.0f, p->glossy[c][i] *= 100.0f;
        }
    half_fill(&w.plan, p);
    for (int32_t y = 1; y < SIDE - 1; y++)
        for (int32_t x = 1; x < SIDE - 1; x++) {
            const float light = x < 8 ? 1.0f : 100.0f;
            const size_t i = patch_pixel(p, x, y);
            assert_true(p->indirect[0][i] == light);
            assert_true(p->glossy[0][i] == light);
        }
    close_wall(&w);
}

/* Rays of a pixel's own stay; whom no node shows stays without light. */
TEST(what_is_known_stays)
{
    struct wall w;
    open_wall(&w, 0, 0);
    struct patch *p = w.patch;
    const size_t own = patch_pixel(p, 4, 5), alone = patch_pixel(p, 8, 8);
    p->bounce_distance_min[own] = 2.0f;
    p->indirect[0][own] = 7.0f;
    p->glossy_weight[own] = 0.5f;
    p->glossy[0][own] = 9.0f;
    p->id[alone] = 3;
    half_fill(&w.plan, p);
    assert_true(p->indirect[0][own] == 7.0f && p->glossy[0][own] == 9.0f && p->lent[own] == 0);
    assert_true(p->bounce_distance_min[own] == 2.0f);
    assert_true(!patch_is_measured(p, alone) && p->indirect[0][alone] == 0.0f);
    close_wall(&w);
}

/* A black pixel takes its neighbours' light, which it reflects nothing of, but not how open they
 * are. */
TEST(black_pixels_are_as_open_as_they_are)
{
    struct wall w;
    open_wall(&w, 0, 0);
    struct patch *p = w.patch;
    float distance[SIDE * SIDE] = {0};
    const size_t black = patch_pixel(p, 4, 5), other = patch_pixel(p, 8, 5);
    p->ambient_distance_min = distance;
    distance[black] = 3.0f;
    p->ambient_visibility[black] = 0.25f;
    half_fill(&w.plan, p);
    assert_true(p->ambient_visibility[black] == 0.25f && distance[black] == 3.0f);
    assert_true(p->ambient_visibility[other] == 0.5f && distance[other] == 5.0f);
    assert_true(p->indirect[0][black] == 1.0f && p->bounce_distance_min[black] == 5.0f);
    close_wall(&w);
}

TEST(full_resolution_is_left_alone)
{
    struct wall w;
    open_wall(&w, 1, 1);
    w.plan.field_halved = 0;
    half_fill(&w.plan, w.patch);
    assert_true(w.patch->indirect[0][patch_pixel(w.patch, 2, 2)] == 0.0f);
    close_wall(&w);
}
