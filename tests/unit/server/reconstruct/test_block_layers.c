/* What blocks write into layers: what their names say, nothing for the background, finite numbers
 * from any samples. */
#include <math.h>
#include <string.h>

#include "proto/job/job.h"
#include "tests/unit/server/reconstruct/block_scene.h"
#include "tests/unit/unit.h"

TEST(background_is_skipped_and_counted)
{
    struct plan plan;
    struct block_statistics sum;
    struct world world = plain;
    world.far_missing = true;
    make_plan(&plan, 40, 30);
    struct image *image = render(&plan, &world, 64, 0, &sum, NULL);
    assert_int_equal(sum.pixels_background, 40 * 30);
    for (size_t i = 0; i < image->channel_count * 40u * 30u; i++) {
        assert_true(image->data[i] == 0.0f);
    }
    image_destroy(&image);
}

/* A sub-sample that hit what no pixel around saw: lit by the nearest-looking one, and counted. */
TEST(a_stray_sub_sample_is_counted)
{
    struct plan plan;
    struct patch *patch;
    struct image *image;
    struct block_statistics sum;
    make_plan(&plan, 8, 8);
    struct film *film;
    uint32_t block;
    assert_int_equal(film_create(&plan, 8, 1, 1, &film), 0);
    struct samples *s = world_tile(&plan, &plain, 0);
    samples_u16(s, PLANE_SUB_DEPTH, 1)[27] = half_from_float(-0.8f);
    samples_u16(s, PLANE_SUB_ID, 1)[27] = 99;
    assert_int_equal(film_land(film, 0, 0, s), 0);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_int_equal(image_create(ALL_LAYERS, 8, 8, &image), 0);
    assert_int_equal(block_reconstruct(&plan, patch, patch->rect, image, &sum), 0);
    assert_int_equal(sum.sub_samples_unmatched, 1);
    assert_true(picture_at(image, "R", 3, 3) == picture_at(image, "R", 0, 0));
    struct rect outside = {0, 0, 9, 8};
    assert_int_equal(block_reconstruct(&plan, patch, outside, image, &sum), ERR_RANGE);
    patch_destroy(&patch);
    film_destroy(&film);
    image_destroy(&image);
}

TEST(layers_hold_what_they_say)
{
    struct plan plan;
    synthetic_plan(&plan, 24, 24, 8);
    struct image *image = render(&plan, NULL, 64, 0, NULL, NULL);
    for (int32_t y = 0; y < 24; y++) {
        for (int32_t x = 0; x < 24; x++) {
            struct synthetic_pixel p = synthetic_pixel(&plan, x, y);
            bool hit = p.depth > 0.0f;
            float seen = (float)__builtin_popcount(p.visibility) / 9.0f;
            assert_true(picture_at(image, "depth.Z", x, y) == p.depth);
            assert_true(picture_at(image, "id.I", x, y) == (float)p.id);
            assert_true(fabsf(picture_at(image, "normal.Y", x, y) - p.normal[1]) < 1e-4f);
            assert_true(picture_at(image, "samples.N", x, y) == (hit ? 18.0f : 0.0f));
            assert_true(picture_at(image, "visibility.V", x, y) == (hit ? seen : 0.0f));
            float sum = picture_at(image, "direct.G", x, y) +
                        picture_at(image, "indirect.G", x, y) +
                        picture_at(image, "emission.G", x, y);
            assert_true(fabsf(picture_at(image, "G", x, y) - sum) <= 1e-5f * fmaxf(sum, 1.0f));
        }
    }
    image_destroy(&image);
}

static void expect_same_channels(const struct image *one, const struct image *all)
{
    const size_t bytes = 32u * 32u * sizeof(float);
    for (uint32_t c = 0; c < one->channel_count; c++) {
        const char *name = one->channels[c].name;
        if (memcmp(one->channels[c].plane.data, image_plane(all, name)->data, bytes) != 0)
            fail_msg("%s alone is another than among all layers", name);
    }
}

/* What is not asked for is not summed. */
TEST(layers_do_not_depend_on_others)
{
    static const uint32_t layers[] = {LAYER_BEAUTY, LAYER_DIRECT,   LAYER_INDIRECT,
                                      LAYER_ALBEDO, LAYER_EMISSION, LAYER_BEAUTY | LAYER_INDIRECT};
    struct plan plan;
    struct patch *patch;
    struct film *film;
    struct image *all;
    struct block_statistics sum;
    uint32_t block;
    synthetic_plan(&plan, 32, 32, 32);
    assert_int_equal(film_create(&plan, 64, 1, 1, &film), 0);
    assert_int_equal(film_land(film, 0, 0, synthetic_tile(&plan, 0)), 0);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_int_equal(image_create(ALL_LAYERS, 32, 32, &all), 0);
    assert_int_equal(block_reconstruct(&plan, patch, patch->rect, all, &sum), 0);
    for (size_t i = 0; i < sizeof layers / sizeof layers[0]; i++) {
        struct image *one;
        assert_int_equal(image_create(layers[i], 32, 32, &one), 0);
        assert_int_equal(block_reconstruct(&plan, patch, patch->rect, one, &sum), 0);
        expect_same_channels(one, all);
        image_destroy(&one);
    }
    image_destroy(&all);
    patch_destroy(&patch);
    film_destroy(&film);
}

/* Every number at the end of its range: what comes out is finite. */
TEST(extremes_stay_finite)
{
    struct plan plan;
    struct film *film;
    struct patch *patch;
    struct image *image;
    struct block_statistics sum;
    uint32_t block;
    make_plan(&plan, 8, 8);
    plan.lights[0].color[0] = LIMIT_RADIANCE;
    plan.radiance_scale = 0x1p-24f;
    assert_int_equal(film_create(&plan, 8, 1, 1, &film), 0);
    struct samples *s = world_tile(&plan, &plain, 0);
    static const float depths[] = {3.4e38f, 1e-45f, 1.0f, 0.0f, 1e15f};
    for (size_t i = 0; i < 64; i++) {
        samples_f32(s, PLANE_DEPTH, 0)[i] = depths[i % 5];
        samples_light_irradiance(s, 0)[i] = i % 3 ? 3.4e38f : 0.0f;
        samples_u32(s, PLANE_NORMAL, 0)[i] = (uint32_t)i * 2654435761u;
        for (uint32_t c = 0; c < 3; c++) {
            samples_u16(s, PLANE_EMISSION, c)[i] = half_from_float(HALF_MAX);
            samples_u16(s, PLANE_INDIRECT_MEAN, c)[i] = half_from_float(HALF_MAX);
            samples_u16(s, PLANE_SUB_DEPTH, c)[i] = half_from_float(i % 2 ? HALF_MAX : -0.9995f);
            samples_u16(s, PLANE_SUB_NORMAL, c)[i] = (uint16_t)(i * 40503u);
        }
    }
    assert_int_equal(film_land(film, 0, 0, s), 0);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    for (int type = 0; type < 2; type++) {
        plan.camera.type = type ? CAMERA_ORTHOGRAPHIC : CAMERA_PERSPECTIVE;
        plan.camera.half_width = type ? LIMIT_COORDINATE : 1e-8f;
        assert_int_equal(image_create(ALL_LAYERS, 8, 8, &image), 0);
        assert_int_equal(block_reconstruct(&plan, patch, patch->rect, image, &sum), 0);
        for (size_t i = 0; i < image->channel_count * 64u; i++) {
            assert_true(isfinite(image->data[i]));
        }
        image_destroy(&image);
    }
    patch_destroy(&patch);
    film_destroy(&film);
}
