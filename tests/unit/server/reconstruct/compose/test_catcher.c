/* Objects and a photograph: what is the same stays the same, and edges have no fringe. */
#include <math.h>

#include "proto/job/job.h"
#include "server/reconstruct/compose/catcher.h"
#include "tests/unit/unit.h"

/* One pixel of each picture. */
struct pixel {
    float objects[4], with[4], without[4], plate[3];
    bool adds;
};

struct composed {
    float composite[3], catcher[3], overlay[4];
};

static struct image *image_of(uint32_t layers, const float *v)
{
    struct image *image;
    assert_int_equal(image_create(layers, 1, 1, &image), 0);
    for (int c = 0; v && c < 4; c++) image->data[c] = v[c];
    return image;
}

static struct composed compose(const struct pixel *p)
{
    struct composed out;
    const float plate[4] = {p->plate[0], p->plate[1], p->plate[2], 1};
    struct image *picture = image_of(LAYER_BEAUTY | LAYERS_COMPOSITE, p->objects);
    struct image *with = image_of(LAYER_BEAUTY, p->with);
    struct image *without = image_of(LAYER_BEAUTY, p->without);
    struct image *behind = image_of(LAYER_BEAUTY, plate);
    const struct catcher_views views = {with, without, behind, p->adds};
    catcher_compose(&views, (struct rect){0, 0, 1, 1}, picture);
    for (int c = 0; c < 3; c++) {
        out.composite[c] = picture->data[4 + c];
        out.catcher[c] = picture->data[7 + c];
    }
    for (int c = 0; c < 4; c++) out.overlay[c] = picture->data[10 + c];
    image_destroy(&picture);
    image_destroy(&with);
    image_destroy(&without);
    image_destroy(&behind);
    return out;
}

TEST(what_no_object_reaches_keeps_its_bits)
{
    struct pixel p = {.with = {0.3f, 1e-30f, 7e9f, 0.7f},
                      .without = {0.3f, 1e-30f, 7e9f, 0.7f},
                      .plate = {0.1f, 3.0f, 0x1.234566p-9f}};
    for (int adds = 0; adds < 2; adds++) {
        p.adds = adds;
        const struct composed out = compose(&p);
        for (int c = 0; c < 3; c++) {
            assert_true(out.composite[c] == p.plate[c]);
            assert_true(out.catcher[c] == (adds ? 0.0f : 1.0f));
        }
        assert_true(out.overlay[3] == 0.0f);
    }
}

TEST(shadows_have_the_colour_of_the_light_that_is_left)
{
    const struct pixel p = {.with = {0.1f, 0.2f, 0.6f, 1},
                            .without = {0.4f, 0.4f, 0.6f, 1},
                            .plate = {0.8f, 0.5f, 0.2f}};
    const struct composed out = compose(&p);
    assert_float_equal(out.composite[0], 0.2f, 1e-6f);
    assert_float_equal(out.composite[1], 0.25f, 1e-6f);
    assert_true(out.composite[2] == 0.2f);
    assert_float_equal(out.catcher[0], 0.25f, 1e-6f);
    /* One alpha for all colours: their mean. */
    assert_float_equal(out.overlay[3], 1.0f - (0.25f + 0.5f + 1.0f) / 3.0f, 1e-6f);
}

TEST(differences_are_added_and_go_no_lower_than_black)
{
    const struct pixel p = {.with = {0.1f, 0.2f, 0.9f, 1},
                            .without = {0.4f, 0.4f, 0.6f, 1},
                            .plate = {0.8f, 0.1f, 0.2f},
                            .adds = true};
    const struct composed out = compose(&p);
    assert_float_equal(out.composite[0], 0.5f, 1e-6f);
    assert_true(out.composite[1] == 0.0f);
    assert_float_equal(out.composite[2], 0.5f, 1e-6f);
    assert_float_equal(out.catcher[1], -0.2f, 1e-6f);
}

TEST(objects_cover_by_their_alpha)
{
    const struct pixel p = {.objects = {0.3f, 0.6f, 0.9f, 0.75f},
                            .with = {0.2f, 0.2f, 0.2f, 1},
                            .without = {0.4f, 0.4f, 0.4f, 1},
                            .plate = {1, 1, 1}};
    const struct composed out = compose(&p);
    assert_float_equal(out.composite[0], 0.3f + 0.25f * 0.5f, 1e-6f);
    assert_float_equal(out.overlay[0] + (1.0f - out.overlay[3]) * p.plate[0], out.composite[0],
                       1e-6f);
}

TEST(what_filters_spill_beside_objects_is_dropped)
{
    const struct pixel p = {.objects = {1e-6f, 1e-3f, 1e-6f, 0},
                            .with = {1, 1, 1, 1},
                            .without = {1, 1, 1, 1},
                            .plate = {0.3f, 0.4f, 0.5f}};
    const struct composed out = compose(&p);
    for (int c = 0; c < 3; c++)
        assert_true(out.composite[c] == p.plate[c] && out.overlay[c] == 0.0f);
}

TEST(a_lamp_beside_a_catcher_is_not_shaded)
{
    /* Half of the pixel is a holdout a hundred times as bright. */
    const struct pixel p = {.with = {0.1f, 0.1f, 0.1f, 0.5f},
                            .without = {0.2f, 0.2f, 0.2f, 0.5f},
                            .plate = {20, 0.4f, 0.4f}};
    const struct composed out = compose(&p);
    assert_true(out.composite[0] > 19.5f);
    assert_float_equal(out.composite[1], 0.4f * 0.75f, 1e-6f);
}

TEST(what_was_black_is_left_alone_and_noise_is_bounded)
{
    const struct pixel p = {
        .with = {0.5f, 1, 0, 1}, .without = {0, 1e-9f, 0, 1}, .plate = {1, 1, 1}};
    const struct composed out = compose(&p);
    assert_true(out.composite[0] == 1.0f);
    assert_true(out.composite[1] <= 64.0f);
    assert_true(out.composite[2] == 1.0f);
}
