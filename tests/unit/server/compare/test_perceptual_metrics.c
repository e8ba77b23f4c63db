/* SSIM and FLIP: closed forms, what is alike, and more noise is never less unlike. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/compare/flip.h"
#include "server/compare/ssim.h"
#include "tests/unit/unit.h"

#define WIDTH  61
#define HEIGHT 43

static const char *const names[] = {"R", "G", "B"};
static struct image *one, *two;
static float map[WIDTH * HEIGHT];

static int set_up(void **state)
{
    (void)state;
    return image_create_named(names, 3, WIDTH, HEIGHT, &one) ||
           image_create_named(names, 3, WIDTH, HEIGHT, &two);
}

static int tear_down(void **state)
{
    (void)state;
    image_destroy(&one);
    image_destroy(&two);
    return 0;
}

EACH_TEST(set_up, tear_down);

static void put(struct image *image, int32_t x, int32_t y, float r, float g, float b)
{
    *plane_at(image_plane(image, "R"), x, y) = r;
    *plane_at(image_plane(image, "G"), x, y) = g;
    *plane_at(image_plane(image, "B"), x, y) = b;
}

static void paint(struct image *image, float r, float g, float b)
{
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) put(image, x, y, r, g, b);
}

static double decode(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* A grey of that luma. */
static void paint_luma(struct image *image, double (*luma)(int32_t x, int32_t y))
{
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) {
            const float v = (float)decode(luma(x, y));
            put(image, x, y, v, v, v);
        }
}

static double ssim(void)
{
    struct display_pair shown;
    struct fault fault;
    const struct display_transform plain = DISPLAY_PLAIN;
    double mean;
    assert_int_equal(display_pair_create(one, two, "beauty", &plain, &shown, &fault), 0);
    assert_int_equal(ssim_map(&shown, map, &mean), 0);
    display_pair_fini(&shown);
    return mean;
}

static struct flip flip(double ppd)
{
    struct display_pair shown;
    struct fault fault;
    struct flip found;
    const struct display_transform plain = DISPLAY_PLAIN;
    assert_int_equal(display_pair_create(one, two, "beauty", &plain, &shown, &fault), 0);
    assert_int_equal(flip_map(&shown, ppd, map, &found), 0);
    display_pair_fini(&shown);
    return found;
}

static float random_at(int32_t x, int32_t y, uint32_t what)
{
    uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u ^ what * 0x165667b1u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (float)((h ^ h >> 15) >> 8) * 0x1p-24f;
}

static double scenery(int32_t x, int32_t y)
{
    return 0.5 + 0.3 * sin(x * 0.3) * cos(y * 0.2);
}

TEST(what_is_the_same_is_alike)
{
    paint_luma(one, scenery);
    paint_luma(two, scenery);
    assert_true(ssim() == 1.0);
    for (int32_t i = 0; i < WIDTH * HEIGHT; i++) assert_true(map[i] == 1.0f);
    const struct flip found = flip(FLIP_PPD);
    assert_true(found.mean == 0 && found.max == 0 && found.quartile[2] == 0);
    for (int32_t i = 0; i < WIDTH * HEIGHT; i++) assert_true(map[i] == 0.0f);
}

static double dim(int32_t x, int32_t y)
{
    (void)x, (void)y;
    return 0.3;
}

static double bright(int32_t x, int32_t y)
{
    (void)x, (void)y;
    return 0.6;
}

/* Rounding makes variances of flat pictures small numbers of either sign. */
static double flat(int32_t x, int32_t y)
{
    (void)x, (void)y;
    return 0.2140411;
}

TEST(what_is_flat_is_alike_too)
{
    paint_luma(one, flat);
    paint_luma(two, flat);
    assert_true(ssim() > 1 - 1e-6 && ssim() <= 1);
}

/* Flat pictures: means alone. Inverted ones: the same means, opposite structure. */
static double checks(int32_t x, int32_t y)
{
    return 0.5 + ((x + y) % 2 == 0 ? 0.2 : -0.2);
}

static double inverted_checks(int32_t x, int32_t y)
{
    return 1.0 - checks(x, y);
}

TEST(ssim_has_its_closed_forms)
{
    const double c1 = 1e-4, c2 = 9e-4;
    paint_luma(one, dim);
    paint_luma(two, bright);
    const double flat = (2 * 0.3 * 0.6 + c1) / (0.3 * 0.3 + 0.6 * 0.6 + c1);
    assert_true(fabs(ssim() - flat) < 1e-4);
    for (int32_t i = 0; i < WIDTH * HEIGHT; i++) assert_true(fabs((double)map[i] - flat) < 1e-3);
    paint_luma(one, checks);
    paint_luma(two, inverted_checks);
    const double opposite = (c2 - 2 * 0.04) / (c2 + 2 * 0.04);
    assert_true(fabs(ssim() - opposite) < 1e-3);
}

/* Greens and blues of a screen are as far apart as can be; black and white by the formula: HyAB is
 * 100, the largest to the power 0.7 is 41.276. */
TEST(flip_has_its_closed_forms)
{
    const double large = 0.4 * 41.276;
    const double contrast = 0.95 + 0.05 * (pow(100, 0.7) - large) / (41.276 - large);
    paint(one, 0, 1, 0);
    paint(two, 0, 0, 1);
    assert_true(fabs(flip(FLIP_PPD).mean - 1) < 1e-4);
    paint(one, 0, 0, 0);
    paint(two, 1, 1, 1);
    const struct flip found = flip(FLIP_PPD);
    assert_true(fabs(found.mean - contrast) < 1e-3);
    assert_true(fabs(found.quartile[0] - contrast) < 1e-3 && fabs(found.max - contrast) < 1e-3);
}

TEST(more_noise_is_more_unlike)
{
    double last_ssim = 1, last_flip = 0;
    paint_luma(one, scenery);
    for (int step = 1; step <= 6; step++) {
        for (int32_t y = 0; y < HEIGHT; y++)
            for (int32_t x = 0; x < WIDTH; x++) {
                const float v = *plane_at(image_plane(one, "R"), x, y);
                const float noise = 0.01f * (float)(1 << step);
                put(two, x, y, v * (1 + noise * (random_at(x, y, 1) - 0.5f)),
                    v * (1 + noise * (random_at(x, y, 2) - 0.5f)),
                    v * (1 + noise * (random_at(x, y, 3) - 0.5f)));
            }
        const double similarity = ssim();
        const struct flip found = flip(FLIP_PPD);
        assert_true(similarity < last_ssim && found.mean > last_flip);
        assert_true(found.quartile[0] <= found.quartile[1] &&
                    found.quartile[1] <= found.quartile[2] && found.quartile[2] <= found.max);
        last_ssim = similarity;
        last_flip = found.mean;
    }
}

/* From far away a fine pattern is its mean; from near it is seen. */
TEST(distance_hides_what_is_fine)
{
    paint_luma(one, checks);
    paint_luma(two, inverted_checks);
    assert_true(flip(200).mean < 0.5 * flip(10).mean);
}

/* An edge that is there in one of the two weighs more than its colours alone. */
TEST(edges_count)
{
    paint(one, 0.2f, 0.2f, 0.2f);
    paint(two, 0.2f, 0.2f, 0.2f);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = WIDTH / 2; x < WIDTH; x++) put(two, x, y, 0.25f, 0.25f, 0.25f);
    flip(FLIP_PPD);
    const float *row = map + HEIGHT / 2 * WIDTH;
    assert_true(row[WIDTH / 2] > 1.1f * row[WIDTH - 2] && row[1] < 1e-3f);
}

/* Numbers that are none are left out of both. */
TEST(holes_are_left_out)
{
    struct display_pair shown;
    struct fault fault;
    const struct display_transform plain = DISPLAY_PLAIN;
    paint_luma(one, scenery);
    paint_luma(two, scenery);
    put(one, 20, 20, NAN, 1, 1);
    put(two, 30, 20, 1, INFINITY, 1);
    assert_true(ssim() == 1.0);
    assert_true(flip(FLIP_PPD).max == 0);
    assert_int_equal(display_pair_create(one, two, "beauty", &plain, &shown, &fault), 0);
    assert_int_equal(shown.count, WIDTH * HEIGHT - 2);
    display_pair_fini(&shown);
    assert_int_equal(display_pair_create(one, two, "normal", &plain, &shown, &fault),
                     ERR_NOT_FOUND);
}
