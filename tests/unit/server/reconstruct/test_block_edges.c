/* Blocks at edges: silhouettes are the mixture of what covers them, and light does not leak over,
 * whatever it is that tells the surfaces apart. */
#include <math.h>

#include "tests/unit/server/reconstruct/block_scene.h"
#include "tests/unit/unit.h"

/* How many of a pixel's samples lie left of the edge. */
static int near_samples(const struct plan *plan, const struct world *w, int32_t x, int32_t y)
{
    int count = (float)x + 0.5f < w->edge_x + w->slant * ((float)y + 0.5f);
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        float p[2];
        pattern_pixel(&plan->pattern, x, y, k, plan->sub_samples, p);
        count += (float)x + p[0] < w->edge_x + w->slant * ((float)y + p[1]);
    }
    return count;
}

/* A slanted edge between what is lit and what is not: any leak would show. */
static struct world edge(float near_light)
{
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.near_light = near_light;
    world.far_light = 0.0f;
    return world;
}

/* Each sample has its own side's light and albedo: an edge pixel is exactly the mixture. */
static void assert_mixture(const struct world *world)
{
    struct plan plan;
    struct block_statistics sum;
    make_plan(&plan, 64, 64);
    struct image *image = render(&plan, world, 64, 0, &sum, NULL);
    float near_value = world->near_albedo * world->near_light / PI;
    float far_value = world->far_missing ? 0.0f : world->far_albedo * world->far_light / PI;
    int mixed = 0;
    for (int32_t y = 0; y < 64; y++) {
        for (int32_t x = 0; x < 64; x++) {
            float share = (float)near_samples(&plan, world, x, y) / 4.0f;
            float expected = share * near_value + (1.0f - share) * far_value;
            mixed += share > 0.0f && share < 1.0f;
            assert_true(fabsf(picture_at(image, "R", x, y) - expected) < 2e-4f);
            float cover = world->far_missing ? share : 1.0f;
            assert_true(picture_at(image, "A", x, y) == cover);
        }
    }
    assert_true(mixed > 20);
    assert_int_equal(sum.sub_samples_unmatched, 0);
    image_destroy(&image);
}

TEST(a_silhouette_is_the_mixture_of_both_surfaces)
{
    struct world world = edge(3.0f);
    world.near_albedo = 0.25f;
    world.far_albedo = 1.0f;
    assert_mixture(&world);
    world.near_light = 0.0f;
    world.far_light = 100.0f;
    assert_mixture(&world);
}

/* One object, e.g. a scene in a single mesh: only depth tells the surfaces apart. */
TEST(depth_alone_keeps_light_apart)
{
    struct world world = edge(10.0f);
    world.near_id = world.far_id = 7;
    assert_mixture(&world);
    world.tilt = 1.0f;
    assert_mixture(&world);
}

TEST(normals_alone_keep_light_apart)
{
    struct world world = edge(10.0f);
    world.near_depth = world.far_depth = 5.0f;
    world.near_id = world.far_id = 7;
    world.normal_turn = 1.0f;
    assert_mixture(&world);
}

TEST(ids_are_preferred_on_one_plane)
{
    struct plan plan;
    struct world world = edge(10.0f);
    world.near_depth = world.far_depth = 5.0f;
    make_plan(&plan, 64, 64);
    struct image *image = render(&plan, &world, 64, 0, NULL, NULL);
    float value = world.near_albedo * world.near_light / PI;
    for (int32_t y = 0; y < 64; y++) {
        for (int32_t x = 0; x < 64; x++) {
            float share = (float)near_samples(&plan, &world, x, y) / 4.0f;
            assert_true(fabsf(picture_at(image, "R", x, y) - share * value) < 0.06f * value);
        }
    }
    image_destroy(&image);
}

/* 65536 instances on: the low bits that sub-samples carry are 0. */
TEST(large_ids_match_their_own)
{
    struct world world = edge(10.0f);
    world.near_id = 65536;
    world.far_id = 3 * 65536 + 5;
    assert_mixture(&world);
}

TEST(an_edge_against_nothing_has_partial_alpha)
{
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.far_missing = true;
    assert_mixture(&world);
}

TEST(an_orthographic_silhouette_is_clean)
{
    struct plan plan;
    struct world world = edge(10.0f);
    world.near_id = world.far_id = 3;
    make_plan(&plan, 64, 64);
    plan.camera.type = CAMERA_ORTHOGRAPHIC;
    struct image *image = render(&plan, &world, 64, 0, NULL, NULL);
    float value = world.near_albedo * world.near_light / PI;
    for (int32_t y = 0; y < 64; y++) {
        for (int32_t x = 0; x < 64; x++) {
            float share = (float)near_samples(&plan, &world, x, y) / 4.0f;
            assert_true(fabsf(picture_at(image, "R", x, y) - share * value) < 1e-3f);
        }
    }
    image_destroy(&image);
}
