/* What shadow filters make of blocks: no cut of the image changes a bit, lights without area keep
 * their irradiance, and counters say what ran. */
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/filtered_case.h"
#include "tests/unit/unit.h"

/* Bits of proto/job/job.h's enum layer. */
#define LAYERS (1u << 0 | 1u << 1 | 1u << 5 | 1u << 7 | 1u << 12)

static const struct filtered_world shelf = {.shelf_height = 1.5f, .shelf_half = 1.0f};
static const struct filtered_world nothing = {.shelf_height = 1.5f};

static struct image *render(const struct plan *plan, const struct filtered_world *world,
                            int32_t block_px, int32_t more_halo_px, struct block_statistics *sum)
{
    struct film *film = picture_film(plan, block_px, more_halo_px);
    struct image *image;
    *sum = (struct block_statistics){0};
    assert_int_equal(image_create(LAYERS, plan->width_px, plan->height_px, &image), 0);
    picture_land_pixels(plan, film, filtered_put, world);
    picture_draw(plan, film, image, sum);
    assert_true(film_complete(film));
    film_destroy(&film);
    return image;
}

static size_t area_of(const struct image *image)
{
    return (size_t)image->width_px * (size_t)image->height_px;
}

static void assert_same(const struct image *a, const struct image *b)
{
    assert_memory_equal(a->data, b->data, area_of(a) * a->channel_count * sizeof(float));
}

TEST(no_cut_changes_a_bit)
{
    static const struct {
        int32_t block_px, more_halo_px, tile_px;
    } cuts[] = {{128, 0, 32}, {64, 0, 16}, {37, 0, 64}, {64, 21, 8}, {256, 0, 256}, {31, 3, 100}};
    struct block_statistics sum;
    for (uint32_t filter = SHADOW_FILTER_AXIS_ALIGNED; filter <= SHADOW_FILTER_SHEARED; filter++) {
        struct plan plan;
        filtered_plan(&plan, 210, 170, 64, filter, 3);
        struct image *whole = render(&plan, &shelf, 256, 0, &sum);
        assert_true(sum.shadow.pixels_filtered > 1000);
        for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
            plan.tile_px = cuts[i].tile_px;
            struct image *cut = render(&plan, &shelf, cuts[i].block_px, cuts[i].more_halo_px, &sum);
            assert_same(whole, cut);
            image_destroy(&cut);
        }
        image_destroy(&whole);
    }
}

/* Without sub-samples nobody reads beyond a block: every pixel counts once a light. */
TEST(counters_add_up)
{
    struct block_statistics sum;
    for (uint32_t lights = 1; lights <= 4; lights++) {
        struct plan plan;
        filtered_plan(&plan, 210, 170, 64, SHADOW_FILTER_SHEARED, lights);
        plan.sub_samples = 0;
        plan.planes &= PLANE_BIT(SUB_DEPTH) - 1;
        struct image *image = render(&plan, &shelf, 64, 0, &sum);
        uint64_t rectangles = (lights + 1) / 2;
        assert_int_equal(sum.shadow.pixels_filtered + sum.shadow.pixels_alone +
                             sum.shadow.pixels_unlit,
                         rectangles * area_of(image));
        assert_true(sum.shadow.pixels_unlit > 100); /* beside the floor */
        const float *width_px = picture_channel(image, "filter_width.W");
        uint64_t wide = 0;
        for (size_t i = 0; i < area_of(image); i++) wide += width_px[i] > 0.0f;
        assert_true(wide > 1000 && wide <= sum.shadow.pixels_filtered);
        if (rectangles == 1) assert_int_equal(wide, sum.shadow.pixels_filtered);
        image_destroy(&image);
    }
}

/* What casts no shadow is not filtered. */
TEST(open_blocks_are_skipped)
{
    struct plan plan;
    struct block_statistics sum;
    filtered_plan(&plan, 210, 170, 64, SHADOW_FILTER_SHEARED, 1);
    struct image *sheared = render(&plan, &nothing, 64, 0, &sum);
    assert_int_equal(sum.shadow.pixels_filtered, 0);
    assert_int_equal(sum.shadow.blocks_skipped, 4 * 3);
    plan.shadow_filter = SHADOW_FILTER_AXIS_ALIGNED;
    struct image *aligned = render(&plan, &nothing, 64, 0, &sum);
    assert_int_equal(sum.shadow.pixels_filtered, 0);
    assert_int_equal(sum.shadow.blocks_skipped, 4 * 3);
    assert_same(sheared, aligned);
    const float *width_px = picture_channel(sheared, "filter_width.W");
    const float *depth = picture_channel(sheared, "depth.Z"),
                *direct = picture_channel(sheared, "direct.R");
    for (size_t i = 0; i < area_of(sheared); i++) {
        assert_true(width_px[i] == 0.0f);
        if (depth[i] > 0.0f) assert_true(direct[i] > 0.0f && isfinite(direct[i]));
    }
    image_destroy(&sheared);
    image_destroy(&aligned);
}

/* No rectangle, no filter: none runs, none is counted, and the picture is that without one. */
TEST(sharp_lights_are_left_alone)
{
    struct plan plan;
    struct block_statistics sum;
    filtered_plan(&plan, 100, 80, 32, SHADOW_FILTER_SHEARED, 2);
    plan.lights[0] = plan.lights[1];
    struct image *filtered = render(&plan, &shelf, 64, 0, &sum);
    assert_int_equal(sum.shadow.pixels_filtered + sum.shadow.pixels_alone +
                         sum.shadow.pixels_unlit + sum.shadow.blocks_skipped,
                     0);
    plan.shadow_filter = SHADOW_FILTER_NONE;
    struct image *plain = render(&plan, &shelf, 64, 0, &sum);
    assert_int_equal(sum.shadow_cpu_us, 0);
    assert_same(plain, filtered);
    image_destroy(&filtered);
    image_destroy(&plain);
}

/* Light k alone, of the plan with all. */
static struct image *render_alone(const struct plan *all, uint32_t k)
{
    struct plan plan = *all;
    struct block_statistics sum;
    for (uint32_t i = 0; i < plan.light_count; i++)
        if (i != k) memset(plan.lights[i].color, 0, sizeof plan.lights[i].color);
    return render(&plan, &shelf, 64, 0, &sum);
}

TEST(lights_add_up)
{
    struct plan plan;
    struct block_statistics sum;
    struct image *alone[3];
    const float *part[3];
    filtered_plan(&plan, 100, 80, 32, SHADOW_FILTER_SHEARED, 3);
    struct image *all = render(&plan, &shelf, 64, 0, &sum);
    for (uint32_t k = 0; k < 3; k++) {
        alone[k] = render_alone(&plan, k);
        part[k] = picture_channel(alone[k], "direct.R");
    }
    const float *sum_of = picture_channel(all, "direct.R");
    for (size_t i = 0; i < area_of(all); i++) {
        float expected = part[0][i] + part[1][i] + part[2][i];
        assert_true(fabsf(sum_of[i] - expected) <= 1e-5f * (1.0f + expected));
    }
    for (uint32_t k = 0; k < 3; k++) image_destroy(&alone[k]);
    image_destroy(&all);
}

/* The filter takes noise away and leaves the light as it is. */
TEST(filtered_light_is_the_same_light)
{
    struct plan plan;
    struct block_statistics sum;
    double plain_sum = 0;
    filtered_plan(&plan, 210, 170, 64, SHADOW_FILTER_NONE, 1);
    struct image *plain = render(&plan, &shelf, 64, 0, &sum);
    for (size_t i = 0; i < area_of(plain); i++)
        plain_sum += (double)picture_channel(plain, "direct.R")[i];
    for (uint32_t filter = SHADOW_FILTER_AXIS_ALIGNED; filter <= SHADOW_FILTER_SHEARED; filter++) {
        double filtered_sum = 0;
        plan.shadow_filter = filter;
        struct image *filtered = render(&plan, &shelf, 64, 0, &sum);
        for (size_t i = 0; i < area_of(filtered); i++)
            filtered_sum += (double)picture_channel(filtered, "direct.R")[i];
        assert_true(fabs(filtered_sum / plain_sum - 1) < 0.01);
        image_destroy(&filtered);
    }
    image_destroy(&plain);
}

TEST(small_pictures_are_finite)
{
    static const int32_t sizes[][2] = {{1, 1}, {1, 90}, {90, 1}, {2, 3}};
    struct block_statistics sum;
    for (uint32_t filter = SHADOW_FILTER_AXIS_ALIGNED; filter <= SHADOW_FILTER_SHEARED; filter++) {
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            struct plan plan;
            filtered_plan(&plan, sizes[i][0], sizes[i][1], 32, filter, 3);
            struct image *image = render(&plan, &shelf, block_side_px(&plan), 0, &sum);
            for (size_t k = 0; k < area_of(image) * image->channel_count; k++)
                assert_true(isfinite(image->data[k]));
            image_destroy(&image);
        }
    }
}
