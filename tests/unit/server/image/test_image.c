/* Images: channels of layers, limits, lookup. */
#include <string.h>

#include "proto/job/job.h"
#include "server/image/image.h"
#include "tests/unit/unit.h"

TEST(layers_are_those_of_the_job_document)
{
    for (uint32_t bit = 1; bit <= LAYERS_AVAILABLE; bit <<= 1) {
        struct image *image;
        const struct plane *rgb[3];
        if (!(LAYERS_AVAILABLE & bit)) {
            assert_int_equal(image_create(bit, 5, 3, &image), ERR_UNSUPPORTED);
            continue;
        }
        assert_int_equal(image_create(bit, 5, 3, &image), 0);
        assert_true(image_layer_planes(image, layer_name((enum layer)bit), rgb));
        const char *name = layer_name((enum layer)bit);
        if (bit != LAYER_BEAUTY) assert_memory_equal(image->channels[0].name, name, strlen(name));
        image_destroy(&image);
        assert_null(image);
    }
}

TEST(beauty_is_four_channels)
{
    struct image *image;
    assert_int_equal(image_create(LAYER_BEAUTY, 2, 2, &image), 0);
    assert_int_equal(image->channel_count, 4);
    assert_non_null(image_plane(image, "A"));
    assert_null(image_plane(image, "a"));
    image_destroy(&image);
}

TEST(a_composite_is_looked_at_first)
{
    struct image *image;
    assert_int_equal(image_create(LAYER_BEAUTY | LAYER_DEPTH, 1, 1, &image), 0);
    assert_string_equal(image_main_layer(image), "beauty");
    image_destroy(&image);
    assert_int_equal(image_create(LAYER_BEAUTY | LAYER_COMPOSITE, 1, 1, &image), 0);
    assert_string_equal(image_main_layer(image), "composite");
    image_destroy(&image);
}

TEST(planes_are_zero_and_do_not_overlap)
{
    struct image *image;
    assert_int_equal(image_create(LAYERS_AVAILABLE, 7, 5, &image), 0);
    assert_int_equal(image->channel_count, 83);
    for (uint32_t c = 0; c < image->channel_count; c++) {
        const struct plane *p = &image->channels[c].plane;
        assert_int_equal(p->width_px, 7);
        assert_int_equal(p->height_px, 5);
        for (int32_t y = 0; y < 5; y++) {
            for (int32_t x = 0; x < 7; x++) {
                assert_true(*plane_at(p, x, y) == 0.0f);
                *plane_at(p, x, y) = (float)c + 1.0f;
            }
        }
    }
    assert_true(image->data[0] == 1.0f);
    assert_true(image->data[35 * 36 - 1] == 36.0f);
    image_destroy(&image);
}

TEST(layers_that_are_not_there_show_nothing)
{
    struct image *image;
    const struct plane *rgb[3];
    assert_int_equal(image_create(LAYER_DEPTH | LAYER_NORMAL, 2, 2, &image), 0);
    assert_false(image_layer_planes(image, "beauty", rgb));
    assert_false(image_layer_planes(image, "nonsense", rgb));
    assert_false(image_layer_planes(image, "filter_width", rgb));
    assert_true(image_layer_planes(image, "depth", rgb));
    assert_ptr_equal(rgb[0], rgb[2]);
    assert_true(image_layer_planes(image, "normal", rgb));
    assert_ptr_equal(rgb[1], image_plane(image, "normal.Y"));
    image_destroy(&image);
}

TEST(layers_of_other_programs_are_found)
{
    static const char *const names[] = {"crypto.R", "crypto.G", "crypto.B"};
    struct image *image;
    const struct plane *rgb[3];
    assert_int_equal(image_create_named(names, 3, 2, 2, &image), 0);
    assert_true(image_layer_planes(image, "crypto", rgb));
    assert_false(image_layer_planes(image, "a name that is longer than any channel's", rgb));
    image_destroy(&image);
}

TEST(sizes_are_limited)
{
    static const char *const longer[] = {"a name that has no room in a channel"};
    struct image *image;
    assert_int_equal(image_create(1, 0, 5, &image), ERR_LIMIT);
    assert_int_equal(image_create(1, 5, -1, &image), ERR_LIMIT);
    assert_int_equal(image_create(1, LIMIT_IMAGE_SIDE_PX + 1, 1, &image), ERR_LIMIT);
    assert_int_equal(image_create(1, LIMIT_IMAGE_SIDE_PX, LIMIT_IMAGE_SIDE_PX, &image), ERR_LIMIT);
    assert_int_equal(image_create(0, 1, 1, &image), ERR_LIMIT);
    assert_int_equal(image_create(1u << 25, 1, 1, &image), ERR_UNSUPPORTED);
    assert_int_equal(image_create_named(longer, 1, 1, 1, &image), ERR_LIMIT);
    assert_int_equal(image_create_named(longer, IMAGE_CHANNELS + 1, 1, 1, &image), ERR_LIMIT);
    assert_null(image);
}
