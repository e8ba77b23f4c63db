/* Errors that the residual filter tells change no pixel, and are the same however they are found.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define WIDTH  96
#define HEIGHT 96
#define AREA   (WIDTH * HEIGHT)

static const struct rect all = {0, 0, WIDTH, HEIGHT};

static float nothing(const struct residual_scene *s, int32_t x, int32_t y)
{
    (void)s, (void)x, (void)y;
    return 0.0f;
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
    struct residual_told told = residual_scene_tell(&s, all, some_variance);
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
    residual_told_fini(&told);
    residual_picture_fini(&plain);
}

TEST(blocks_do_not_show)
{
    const struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_all};
    static const struct rect blocks[] = {{0, 0, 40, 30}, {33, 21, 64, 90}, {90, 64, 96, 96}};
    struct residual_told whole = residual_scene_tell(&s, all, some_variance);
    for (size_t k = 0; k < sizeof blocks / sizeof *blocks; k++) {
        const struct rect b = blocks[k];
        struct residual_told part = residual_scene_tell(&s, b, some_variance);
        for (int32_t y = b.y0; y < b.y1; y++)
            for (int c = 0; c < 3; c++)
                assert_memory_equal(part.variance[c] + residual_picture_at(&part.picture, b.x0, y),
                                    whole.variance[c] +
                                        residual_picture_at(&whole.picture, b.x0, y),
                                    (size_t)rect_width(b) * sizeof(float));
        residual_told_fini(&part);
    }
    residual_told_fini(&whole);
}

/* A picture that is larger than what has variances. */
TEST(pictures_reach_farther)
{
    const struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_all};
    static const struct rect block = {32, 40, 60, 70};
    struct residual_told alone = residual_scene_tell(&s, block, some_variance);
    for (int32_t ring = 2; ring <= 10; ring += 8) {
        const struct rect lit = rect_grow(block, ring);
        struct residual_told told = residual_scene_tell_within(&s, lit, block, some_variance);
        struct residual_picture plain = residual_scene_filter(&s, lit);
        const size_t bytes = (size_t)rect_area(lit) * sizeof(float);
        for (int c = 0; c < 3; c++) {
            assert_memory_equal(told.picture.radiance[c], plain.radiance[c], bytes);
            assert_memory_equal(told.variance[c], alone.variance[c],
                                (size_t)rect_area(block) * sizeof(float));
        }
        residual_picture_fini(&plain);
        residual_told_fini(&told);
    }
    residual_told_fini(&alone);
}

TEST(instruction_sets_tell_the_same)
{
    static const char *const sets[] = {"sse4.2", "avx2", "avx512"};
    const struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 9, .show = show_all};
    const char *const wanted = getenv("SHEARWATER_ISA");
    char before[16] = "";
    if (wanted) snprintf(before, sizeof before, "%s", wanted);
    struct residual_told best = residual_scene_tell(&s, all, some_variance);
    for (size_t k = 0; k < sizeof sets / sizeof *sets; k++) {
        setenv("SHEARWATER_ISA", sets[k], 1);
        struct residual_told told = residual_scene_tell(&s, all, some_variance);
        assert_memory_equal(told.variance[0], best.variance[0], 3 * AREA * sizeof(float));
        residual_told_fini(&told);
    }
    if (wanted)
        setenv("SHEARWATER_ISA", before, 1);
    else
        unsetenv("SHEARWATER_ISA");
    residual_told_fini(&best);
}

static void expect_finite(const struct residual_told *told, int32_t area)
{
    for (int32_t i = 0; i < 3 * area; i++)
        assert_true(isfinite(told->variance[0][i]) && told->variance[0][i] >= 0.0f);
}

/* Black is known to be black, whatever is infinite is told as finite, and small pictures end. */
TEST(odd_pictures_have_finite_errors)
{
    static const int32_t sizes[][2] = {{1, 1}, {1, 40}, {70, 1}, {2, 3}};
    struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 4};
    struct residual_told told = residual_scene_tell(&s, all, nothing);
    for (int32_t i = 0; i < AREA; i++) assert_true(told.variance[0][i] == 0.0f);
    residual_told_fini(&told);
    s.show = show_all, s.level = 1e30f;
    told = residual_scene_tell(&s, all, some_variance);
    expect_finite(&told, AREA);
    residual_told_fini(&told);
    s.level = 1.0f;
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        s.width = sizes[k][0], s.height = sizes[k][1];
        told = residual_scene_tell(&s, (struct rect){0, 0, s.width, s.height}, some_variance);
        expect_finite(&told, s.width * s.height);
        residual_told_fini(&told);
    }
}
