/* What the residual filter says of its own error: near what it is, less with more samples, and
 * never a reason for another picture. Limits are what these scenes need and a good deal more. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define WIDTH  96
#define HEIGHT 96
#define AREA   (WIDTH * HEIGHT)

static const struct rect all = {0, 0, WIDTH, HEIGHT};

/* Roots of mean squares: what is off, what is said to be; and the share of pixels that are within
 * two of their estimates. */
struct calibration {
    double off, said, within;
};

static struct calibration calibrate(const struct residual_told *told, int channel,
                                    float (*truth)(int32_t x, int32_t y))
{
    struct calibration out = {0};
    for (int32_t i = 0; i < AREA; i++) {
        const float off = told->picture.radiance[channel][i] - truth(i % WIDTH, i / WIDTH);
        const float variance = told->variance[channel][i];
        assert_true(isfinite(variance) && variance >= 0.0f);
        out.off += (double)(off * off) / AREA;
        out.said += (double)variance / AREA;
        out.within += (double)(off * off <= 4.0f * variance) / AREA;
    }
    out.off = sqrt(out.off), out.said = sqrt(out.said);
    return out;
}

static float one(int32_t x, int32_t y)
{
    (void)x, (void)y;
    return 1.0f;
}

/* White noise as strong as the light; level says in which component. */
static void show_wall(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    float *const lights[] = {out->direct, out->indirect, out->rest};
    const float scale = s->level < 2.0f ? 2.0f : 1.0f; /* before albedo */
    residual_grey(scale * residual_noise(x, y, sample, 1), lights[(int)s->level]);
}

static float wall_variance(const struct residual_scene *s, int32_t x, int32_t y)
{
    (void)x, (void)y;
    return 1.0f / (float)s->spp;
}

static struct residual_scene wall(uint32_t spp, int component)
{
    return (struct residual_scene){
        .width = WIDTH, .height = HEIGHT, .spp = spp, .show = show_wall, .level = (float)component};
}

TEST(what_is_left_of_noise_is_known)
{
    for (int component = 0; component < 3; component++)
        for (uint32_t spp = 4; spp <= 64; spp *= 4) {
            const struct residual_scene s = wall(spp, component);
            struct residual_told told = residual_scene_tell(&s, all, wall_variance);
            const struct calibration c = calibrate(&told, 1, one);
            assert_true(c.off < 0.2 / sqrt(spp)); /* the mean's is 1 / sqrt(spp) */
            assert_true(c.said > 0.9 * c.off && c.said < 3.5 * c.off);
            assert_true(c.within > 0.9 && c.within < 0.999);
            assert_true(c.said < 0.2 / sqrt(spp));
            residual_told_fini(&told);
        }
}

/* A texture of light as fine as pixels, behind noise: the filter must leave it, in the end. */
static float texture(int32_t x, int32_t y)
{
    return 0.25f + 0.5f * residual_random(x, y, 0, 20);
}

static void show_texture(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                         struct residual_sample *out)
{
    (void)s;
    residual_grey(2.0f * texture(x, y) * residual_noise(x, y, sample, 1), out->direct);
}

static float texture_variance(const struct residual_scene *s, int32_t x, int32_t y)
{
    return texture(x, y) * texture(x, y) / (float)s->spp;
}

TEST(what_filters_keep_is_told)
{
    for (uint32_t spp = 256; spp <= 1024; spp *= 2) {
        const struct residual_scene s = {
            .width = WIDTH, .height = HEIGHT, .spp = spp, .show = show_texture};
        struct residual_told told = residual_scene_tell(&s, all, texture_variance);
        const struct calibration c = calibrate(&told, 0, texture);
        assert_true(c.said > 0.8 * c.off && c.said < 1.25 * c.off);
        assert_true(c.within > 0.85 && c.within < 0.99);
        residual_told_fini(&told);
    }
}

/* The edge of a shadow, which passes blur a little. */
static float shade(int32_t x, int32_t y)
{
    return x + y < WIDTH ? 0.1f : 1.0f;
}

static void show_shadow(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                        struct residual_sample *out)
{
    (void)s;
    residual_grey(2.0f * shade(x, y) * (0.5f + residual_random(x, y, sample, 1)), out->direct);
}

static float shadow_variance(const struct residual_scene *s, int32_t x, int32_t y)
{
    return shade(x, y) * shade(x, y) / 12.0f / (float)s->spp;
}

TEST(errors_fall_with_samples)
{
    double before = INFINITY;
    for (uint32_t spp = 4; spp <= 256; spp *= 4) {
        const struct residual_scene s = {
            .width = WIDTH, .height = HEIGHT, .spp = spp, .show = show_shadow};
        struct residual_told told = residual_scene_tell(&s, all, shadow_variance);
        const struct calibration c = calibrate(&told, 1, shade);
        assert_true(c.said > 0.9 * c.off && c.said < 2.8 * c.off);
        assert_true(c.within > 0.9);
        assert_true(c.said < 0.7 * before);
        before = c.said;
        residual_told_fini(&told);
    }
}

/* Waves of light that noise hides: passes blur them. */
static float wave(int32_t x, int32_t y)
{
    (void)y;
    return 1.0f + 0.25f * sinf((float)x * 0.5f);
}

static void show_waves(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    (void)s;
    residual_grey(2.0f * wave(x, y) * residual_noise(x, y, sample, 1), out->direct);
}

static float wave_variance(const struct residual_scene *s, int32_t x, int32_t y)
{
    return wave(x, y) * wave(x, y) / (float)s->spp;
}

TEST(bias_is_told)
{
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 16, .show = show_waves};
    struct residual_told told = residual_scene_tell(&s, all, wave_variance);
    const struct calibration c = calibrate(&told, 1, wave);
    assert_true(c.off > 0.06); /* of 0.18, or this would say nothing */
    assert_true(c.said > 0.45 * c.off && c.said < 1.3 * c.off);
    assert_true(c.within > 0.4);
    residual_told_fini(&told);
}

/* Rare bright samples: of four most pixels have none. */
static void show_rare(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    (void)s;
    residual_grey(residual_random(x, y, sample, 1) < 0.05f ? 40.0f : 0.0f, out->direct);
}

static float rare_variance(const struct residual_scene *s, int32_t x, int32_t y)
{
    (void)x, (void)y;
    return 19.0f / (float)s->spp;
}

TEST(rare_light_is_told)
{
    for (uint32_t spp = 4; spp <= 64; spp *= 4) {
        const struct residual_scene s = {
            .width = WIDTH, .height = HEIGHT, .spp = spp, .show = show_rare};
        struct residual_told told = residual_scene_tell(&s, all, rare_variance);
        const struct calibration c = calibrate(&told, 2, one);
        assert_true(c.said > 0.9 * c.off && c.said < 2.5 * c.off);
        assert_true(c.within > 0.85 && c.within < 0.99);
        residual_told_fini(&told);
    }
}

/* Halves that agree at every pixel, by chance or since light is not seen yet, while samples do
 * not. */
static void show_agreement(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                           struct residual_sample *out)
{
    const uint32_t half = s->spp / 2;
    residual_grey(2.0f * residual_noise(x, y, sample % half, 1), out->direct);
}

TEST(halves_that_agree_fool_nobody)
{
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_agreement};
    struct residual_told told = residual_scene_tell(&s, all, wall_variance);
    for (int32_t i = 0; i < AREA; i++) assert_true(told.variance[1][i] >= 0.25f);
    residual_told_fini(&told);
}

/* Emission keeps its error: a lamp's edge, whose samples meet it by halves. */
static void show_lamp(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    show_wall(s, x, y, sample, out);
    if (x == WIDTH / 2 && residual_random(x, y, sample, 7) < 0.5f)
        residual_grey(20.0f, out->emission);
}

static float lamp_variance(const struct residual_scene *s, int32_t x, int32_t y)
{
    (void)y;
    return ((x == WIDTH / 2 ? 100.0f : 0.0f) + 1.0f) / (float)s->spp;
}

static float lamp(int32_t x, int32_t y)
{
    (void)y;
    return x == WIDTH / 2 ? 11.0f : 1.0f;
}

TEST(emission_keeps_its_error)
{
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 16, .show = show_lamp};
    struct residual_told told = residual_scene_tell(&s, all, lamp_variance);
    const struct calibration c = calibrate(&told, 0, lamp);
    assert_true(c.said > 0.8 * c.off && c.said < 1.3 * c.off);
    for (int32_t y = 0; y < HEIGHT; y++) {
        assert_true(told.variance[0][y * WIDTH + WIDTH / 2] > 0.8f * 100.0f / 16.0f);
        assert_true(told.variance[0][y * WIDTH + WIDTH / 4] < 0.2f / 16.0f);
    }
    residual_told_fini(&told);
}
