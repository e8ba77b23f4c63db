/* What the residual filter says of its own error: near what it is, less with more samples, and
 * never a reason for another picture. Seeds are fixed; limits are what these scenes need and a good
 * deal more. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define WIDTH  96
#define HEIGHT 96
#define AREA   (WIDTH * HEIGHT)

static const struct rect all = {0, 0, WIDTH, HEIGHT};

/* A picture, and variances of its channels. */
struct told {
    struct residual_picture picture;
    float *variance[3];
};

/* Of `block`, with plain variances as plain(x, y) has them. */
static struct told tell(const struct residual_scene *s, struct rect block,
                        float (*plain)(const struct residual_scene *s, int32_t x, int32_t y))
{
    struct plan plan = residual_scene_plan(s);
    struct residual_statistics statistics = {0};
    struct told told;
    plan.planes |= PLANE_BIT(PATH_SPREAD);
    const struct rect near = rect_grow(block, residual_halo_px(&plan));
    const struct rect whole = {0, 0, s->width, s->height};
    struct patch *patch = residual_scene_patch(s, rect_intersect(near, whole));
    const size_t area = (size_t)rect_area(block);
    told.variance[0] = malloc(3 * area * sizeof(float));
    assert_non_null(told.variance[0]);
    told.variance[1] = told.variance[0] + area, told.variance[2] = told.variance[1] + area;
    for (size_t i = 0; i < area; i++)
        for (int c = 0; c < 3; c++)
            told.variance[c][i] = plain(s, block.x0 + (int32_t)i % rect_width(block),
                                        block.y0 + (int32_t)i / rect_width(block));
    assert_int_equal(residual_filter(patch, block, told.variance, &told.picture, &statistics), 0);
    patch_destroy(&patch);
    return told;
}

static void told_fini(struct told *told)
{
    residual_picture_fini(&told->picture);
    free(told->variance[0]);
}

/* Roots of mean squares: what is off, what is said to be; and the share of pixels that are within
 * two of their estimates. */
struct calibration {
    double off, said, within;
};

static struct calibration calibrate(const struct told *told, int channel,
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
            struct told told = tell(&s, all, wall_variance);
            const struct calibration c = calibrate(&told, 1, one);
            assert_true(c.off < 0.2 / sqrt(spp)); /* the mean's is 1 / sqrt(spp) */
            assert_true(c.said > 0.9 * c.off && c.said < 2.6 * c.off);
            assert_true(c.within > 0.9 && c.within < 0.99);
            assert_true(c.said < 0.2 / sqrt(spp));
            told_fini(&told);
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
        struct told told = tell(&s, all, texture_variance);
        const struct calibration c = calibrate(&told, 0, texture);
        assert_true(c.said > 0.8 * c.off && c.said < 1.25 * c.off);
        assert_true(c.within > 0.85 && c.within < 0.99);
        told_fini(&told);
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
        struct told told = tell(&s, all, shadow_variance);
        const struct calibration c = calibrate(&told, 1, shade);
        assert_true(c.said > 0.9 * c.off && c.said < 2.8 * c.off);
        assert_true(c.within > 0.9);
        assert_true(c.said < 0.7 * before);
        before = c.said;
        told_fini(&told);
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
    struct told told = tell(&s, all, wave_variance);
    const struct calibration c = calibrate(&told, 1, wave);
    assert_true(c.off > 0.07); /* of 0.18, or this would say nothing */
    assert_true(c.said > 0.45 * c.off && c.said < 1.3 * c.off);
    assert_true(c.within > 0.4);
    told_fini(&told);
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
        struct told told = tell(&s, all, rare_variance);
        const struct calibration c = calibrate(&told, 2, one);
        assert_true(c.said > 0.9 * c.off && c.said < 2.5 * c.off);
        assert_true(c.within > 0.85 && c.within < 0.99);
        told_fini(&told);
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
    struct told told = tell(&s, all, wall_variance);
    for (int32_t i = 0; i < AREA; i++) assert_true(told.variance[1][i] >= 0.25f);
    told_fini(&told);
}

static float nothing(const struct residual_scene *s, int32_t x, int32_t y)
{
    (void)s, (void)x, (void)y;
    return 0.0f;
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
    struct told told = tell(&s, all, lamp_variance);
    const struct calibration c = calibrate(&told, 0, lamp);
    assert_true(c.said > 0.8 * c.off && c.said < 1.3 * c.off);
    for (int32_t y = 0; y < HEIGHT; y++) {
        assert_true(told.variance[0][y * WIDTH + WIDTH / 2] > 0.8f * 100.0f / 16.0f);
        assert_true(told.variance[0][y * WIDTH + WIDTH / 4] < 0.2f / 16.0f);
    }
    told_fini(&told);
}

/* All at once: surfaces of several kinds, sky, light of all components. */
static void show_all(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                     struct residual_sample *out)
{
    const float scale = s->level > 0.0f ? s->level : 1.0f;
    out->hits = x % 31 != 7 && (x % 37 != 5 || residual_random(x, y, sample, 9) < 0.5f);
    if (!out->hits) {
        memset(out->albedo, 0, sizeof out->albedo);
        residual_grey(0.5f * scale, out->emission);
        return;
    }
    out->distance = (x / 20 + y / 30) % 2 ? 3.0f : 5.0f;
    for (int c = 0; c < 3; c++) {
        out->albedo[c] = 0.1f + 0.2f * (float)((x / 7 + c) % 4);
        out->tint[c] = 0.25f * (float)((y / 5 + c) % 3);
        out->direct[c] = scale * residual_noise(x, y, sample, 1);
        out->indirect[c] = scale * 0.3f * residual_noise(x, y, sample, 2);
        out->rest[c] = scale * 0.2f * residual_noise(x, y, sample, 3 + (uint32_t)c);
    }
}

static float some_variance(const struct residual_scene *s, int32_t x, int32_t y)
{
    return (0.5f + residual_random(x, y, 0, 50)) / (float)s->spp;
}

/* To look at errors changes no light; pixels that keep their means keep their errors. */
TEST(looking_changes_nothing)
{
    const struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 9, .show = show_all};
    struct residual_picture plain = residual_scene_filter_all(&s);
    struct told told = tell(&s, all, some_variance);
    uint32_t kept = 0;
    for (int c = 0; c < 3; c++) {
        const size_t bytes = AREA * sizeof(float);
        assert_memory_equal(plain.radiance[c], told.picture.radiance[c], bytes);
        assert_memory_equal(plain.diffuse_direct[c], told.picture.diffuse_direct[c], bytes);
        assert_memory_equal(plain.diffuse_indirect[c], told.picture.diffuse_indirect[c], bytes);
    }
    for (int32_t i = 0; i < AREA; i++) {
        const bool same = told.variance[2][i] == some_variance(&s, i % WIDTH, i / WIDTH);
        if (i % WIDTH % 31 == 7) assert_true(same);
        kept += same;
    }
    assert_true(kept < AREA / 10);
    told_fini(&told);
    residual_picture_fini(&plain);
}

TEST(blocks_do_not_show)
{
    const struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_all};
    static const struct rect blocks[] = {{0, 0, 40, 30}, {33, 21, 64, 90}, {90, 64, 96, 96}};
    struct told whole = tell(&s, all, some_variance);
    for (size_t k = 0; k < sizeof blocks / sizeof *blocks; k++) {
        const struct rect b = blocks[k];
        struct told part = tell(&s, b, some_variance);
        for (int32_t y = b.y0; y < b.y1; y++)
            for (int c = 0; c < 3; c++)
                assert_memory_equal(part.variance[c] + residual_picture_at(&part.picture, b.x0, y),
                                    whole.variance[c] +
                                        residual_picture_at(&whole.picture, b.x0, y),
                                    (size_t)rect_width(b) * sizeof(float));
        told_fini(&part);
    }
    told_fini(&whole);
}

TEST(instruction_sets_tell_the_same)
{
    static const char *const sets[] = {"sse4.2", "avx2", "avx512"};
    const struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 9, .show = show_all};
    const char *const wanted = getenv("SHEARWATER_ISA");
    char before[16] = "";
    if (wanted) snprintf(before, sizeof before, "%s", wanted);
    struct told best = tell(&s, all, some_variance);
    for (size_t k = 0; k < sizeof sets / sizeof *sets; k++) {
        setenv("SHEARWATER_ISA", sets[k], 1);
        struct told told = tell(&s, all, some_variance);
        assert_memory_equal(told.variance[0], best.variance[0], 3 * AREA * sizeof(float));
        told_fini(&told);
    }
    if (wanted)
        setenv("SHEARWATER_ISA", before, 1);
    else
        unsetenv("SHEARWATER_ISA");
    told_fini(&best);
}

/* Black is known to be black, whatever is infinite is told as finite, and small pictures end. */
TEST(odd_pictures_have_finite_errors)
{
    static const int32_t sizes[][2] = {{1, 1}, {1, 40}, {70, 1}, {2, 3}};
    struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 4};
    struct told told = tell(&s, all, nothing);
    for (int32_t i = 0; i < AREA; i++) assert_true(told.variance[0][i] == 0.0f);
    told_fini(&told);
    s.show = show_all, s.level = 1e30f;
    told = tell(&s, all, some_variance);
    for (int32_t i = 0; i < 3 * AREA; i++)
        assert_true(isfinite(told.variance[0][i]) && told.variance[0][i] >= 0.0f);
    told_fini(&told);
    s.level = 1.0f;
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        s.width = sizes[k][0], s.height = sizes[k][1];
        told = tell(&s, (struct rect){0, 0, s.width, s.height}, some_variance);
        for (int32_t i = 0; i < 3 * s.width * s.height; i++)
            assert_true(isfinite(told.variance[0][i]) && told.variance[0][i] >= 0.0f);
        told_fini(&told);
    }
}
