/* Light of lens samples that the residual filter cleans. */
#include <math.h>
#include <string.h>

#include "proto/lens_slope.h"
#include "server/reconstruct/lens/lens_light.h"
#include "tests/unit/server/reconstruct/residual/residual_scene.h"

enum { SIDE = 48, LENS = 3, SPP = LENS * LENS };

static const struct rect whole = {0, 0, SIDE, SIDE};

/* The patch of a scene before and after. */
struct cleaned {
    struct plan plan;
    struct patch *before, *after;
};

static struct cleaned clean(const struct residual_scene *s)
{
    struct cleaned c = {.plan = residual_scene_plan(s),
                        .before = residual_scene_patch(s, whole),
                        .after = residual_scene_patch(s, whole)};
    struct residual_statistics statistics = {0};
    assert_int_equal(lens_light_filter(&c.plan, c.after, whole, &statistics), 0);
    assert_true(statistics.pixels > 0);
    return c;
}

static void fini(struct cleaned *c)
{
    patch_destroy(&c->before);
    patch_destroy(&c->after);
}

static float light(const struct patch *p, uint32_t sample, size_t i)
{
    return p->lens_radiance[sample * 3 * (size_t)rect_area(p->rect) + i];
}

static double mean_of(const struct patch *p, size_t i)
{
    double sum = 0;
    for (uint32_t k = 0; k < SPP; k++) sum += (double)light(p, k, i);
    return sum / SPP;
}

/* Root of the mean squared error of pixels, whose light is 1. */
static double error_of(const struct patch *p)
{
    double sum = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++) sum += pow(mean_of(p, i) - 1, 2);
    return sqrt(sum / (SIDE * SIDE));
}

static void show_noise(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    out->slope = s->level;
    residual_grey(2.0f * residual_noise(x, y, sample, 1), out->direct);
}

/* Noise in focus falls tenfold, and samples of one surface share what is left. */
TEST(noise_is_taken_away)
{
    const struct residual_scene s = {
        .width = SIDE, .height = SIDE, .spp = SPP, .show = show_noise, .lens_strata = LENS};
    struct cleaned c = clean(&s);
    assert_true(error_of(c.before) > 0.25 && error_of(c.after) < 0.1 * error_of(c.before));
    for (size_t i = 0; i < SIDE * SIDE; i++)
        for (uint32_t k = 1; k < SPP; k++)
            assert_true(light(c.after, k, i) == light(c.after, 0, i));
    fini(&c);
}

static void show_even(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    (void)s, (void)x, (void)y;
    out->slope = sample % 2 == 0 ? 3.0f : 0.0f;
    residual_grey(2.0f, out->direct);
}

TEST(what_is_even_stays)
{
    const struct residual_scene s = {
        .width = SIDE, .height = SIDE, .spp = SPP, .show = show_even, .lens_strata = LENS};
    struct cleaned c = clean(&s);
    for (size_t i = 0; i < SIDE * SIDE; i++)
        for (uint32_t k = 0; k < SPP; k++) assert_true(light(c.after, k, i) == 1.0f);
    fini(&c);
}

/* Far out of focus many pixels share each sample, which keeps its light to the bit. */
TEST(what_is_far_out_of_focus_stays)
{
    const struct residual_scene s = {.width = SIDE,
                                     .height = SIDE,
                                     .spp = SPP,
                                     .show = show_noise,
                                     .level = -8,
                                     .lens_strata = LENS};
    struct cleaned c = clean(&s);
    const size_t bytes = (size_t)SPP * 3 * SIDE * SIDE * sizeof(float);
    assert_memory_equal(c.before->lens_radiance, c.after->lens_radiance, bytes);
    fini(&c);
}

/* Of two surfaces and the sky, each a third of the samples. */
static void show_three(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    out->hits = sample % 3 > 0;
    out->slope = sample % 3 == 1 ? 4.0f : (sample % 3 == 2 ? 0.0f : s->level);
    if (out->hits)
        residual_grey(2.0f * (float)(sample % 3) * residual_noise(x, y, sample, 1), out->direct);
    else
        residual_grey(0.25f, out->emission);
}

/* The sky keeps its light, no light is negative, and a pixel has what the filter makes of it. */
TEST(samples_of_several_surfaces_share_what_the_filter_finds)
{
    struct residual_scene s = {
        .width = SIDE, .height = SIDE, .spp = SPP, .show = show_three, .lens_strata = LENS};
    const struct plan plan = residual_scene_plan(&s);
    s.level = lens_slope_sky(lens_sloper_of(&plan));
    struct cleaned c = clean(&s);
    struct residual_picture picture = residual_scene_filter_all(&s);
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        const double found = (double)picture.radiance[0][i];
        for (uint32_t k = 0; k < SPP; k++) {
            assert_true(light(c.after, k, i) >= 0.0f);
            if (k % 3 == 0) assert_true(light(c.after, k, i) == 0.25f);
        }
        assert_true(fabs(mean_of(c.after, i) - found) < 1e-5 * found);
    }
    residual_picture_fini(&picture);
    fini(&c);
}

/* A block's samples do not depend on where it ends. */
TEST(blocks_do_not_matter)
{
    const struct residual_scene s = {
        .width = SIDE, .height = SIDE, .spp = SPP, .show = show_noise, .lens_strata = LENS};
    struct cleaned c = clean(&s);
    const struct rect block = {8, 8, 24, 24};
    struct residual_statistics statistics = {0};
    struct patch *patch = residual_scene_patch(&s, whole);
    assert_int_equal(lens_light_filter(&c.plan, patch, block, &statistics), 0);
    for (int32_t y = block.y0; y < block.y1; y++)
        for (int32_t x = block.x0; x < block.x1; x++)
            for (uint32_t k = 0; k < SPP; k++) {
                const size_t i = patch_pixel(patch, x, y);
                assert_true(light(patch, k, i) == light(c.after, k, i));
            }
    patch_destroy(&patch);
    fini(&c);
}
