/* What the residual filter leaves alone, whatever it does to noise. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

/* All lights at once, in eighths, so that sums are exact. */
static void show_constant(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                          struct residual_sample *out)
{
    (void)x, (void)y, (void)sample;
    for (int c = 0; c < 3; c++) {
        out->direct[c] = s->level * (float)(c + 1);
        out->indirect[c] = s->level * (float)(4 - c);
        out->rest[c] = 0.5f * s->level;
        out->emission[c] = 0.25f * s->level;
    }
}

/* Noise in all lights, on surfaces with edges of every kind. */
static void show_noise(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    const bool near = (x / 20 + y / 30) % 2 == 0;
    const float scale = s->level > 0.0f ? s->level : 1.0f;
    out->hits = x % 37 != 5 || residual_random(x, y, sample, 9) < 0.5f;
    if (!out->hits) {
        memset(out->albedo, 0, sizeof out->albedo);
        residual_grey(scale * 0.5f, out->emission);
        return;
    }
    out->distance = (near ? 3.0f : 5.0f) + 0.02f * (float)x;
    out->normal[0] = near ? 0.0f : 0.6f, out->normal[2] = near ? 1.0f : 0.8f;
    out->alpha = near ? 0.2f : 0.25f;
    for (int c = 0; c < 3; c++) {
        out->albedo[c] = 0.1f + 0.2f * (float)((x / 7 + c) % 4);
        out->tint[c] = 0.25f * (float)((y / 5 + c) % 3);
        out->direct[c] = scale * (near ? 1.0f : 2.0f) * residual_noise(x, y, sample, 1);
        out->indirect[c] = scale * 0.3f * residual_noise(x, y, sample, 2);
        out->rest[c] = scale * 0.2f * residual_noise(x, y, sample, 3 + (uint32_t)c);
    }
}

static void assert_finite(const struct residual_picture *p)
{
    for (int64_t i = 0; i < rect_area(p->block); i++)
        for (int c = 0; c < 3; c++) {
            assert_true(isfinite(p->radiance[c][i]) && p->radiance[c][i] >= 0.0f);
            assert_true(isfinite(p->diffuse_direct[c][i]) && isfinite(p->diffuse_indirect[c][i]));
        }
}

/* Row by row: `part` is what `all` has in the same place. */
static void assert_same(const struct residual_picture *part, const struct residual_picture *all)
{
    const struct rect b = part->block;
    const size_t bytes = (size_t)rect_width(b) * sizeof(float);
    for (int32_t y = b.y0; y < b.y1; y++) {
        const size_t i = residual_picture_at(part, b.x0, y), k = residual_picture_at(all, b.x0, y);
        for (int c = 0; c < 3; c++) {
            assert_memory_equal(part->radiance[c] + i, all->radiance[c] + k, bytes);
            assert_memory_equal(part->diffuse_direct[c] + i, all->diffuse_direct[c] + k, bytes);
            assert_memory_equal(part->diffuse_indirect[c] + i, all->diffuse_indirect[c] + k, bytes);
        }
    }
}

/* But for rounding: the remainder is taken out of all light and added again. */
static bool is_near(float a, float b)
{
    return fabsf(a - b) <= 1e-6f * b;
}

/* To the last bit: sums of weighted differences are 0. */
TEST(constant_light_stays)
{
    static const int32_t sizes[][2] = {{100, 50}, {1, 1}, {1, 40}, {70, 1}, {2, 3}, {64, 16}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        struct residual_scene s = {
            .width = sizes[k][0], .height = sizes[k][1], .spp = 16, .show = show_constant};
        s.level = 0.125f;
        struct residual_picture p = residual_scene_filter_all(&s);
        for (int64_t i = 0; i < rect_area(p.block); i++)
            for (int c = 0; c < 3; c++) {
                assert_true(p.diffuse_direct[c][i] == s.level * (float)(c + 1));
                assert_true(p.diffuse_indirect[c][i] == s.level * (float)(4 - c));
                assert_true(is_near(p.radiance[c][i], s.level * (0.5f * 5.0f + 0.75f)));
                assert_true(p.radiance[c][i] == p.radiance[c][0]);
            }
        residual_picture_fini(&p);
    }
}

/* Also where sums are not exact, and halves differ in their last bits. */
TEST(constant_light_stays_constant)
{
    static const uint32_t counts[] = {1, 2, 4, 9, 25, 49};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        struct residual_scene s = {
            .width = 70, .height = 20, .spp = counts[k], .show = show_constant, .level = 0.1f};
        struct residual_picture p = residual_scene_filter_all(&s);
        for (int c = 0; c < 3; c++) {
            assert_true(is_near(p.radiance[c][0], 0.325f));
            for (int64_t i = 1; i < rect_area(p.block); i++) {
                assert_true(p.radiance[c][i] == p.radiance[c][0]);
                assert_true(p.diffuse_direct[c][i] == p.diffuse_direct[c][0]);
                assert_true(p.diffuse_indirect[c][i] == p.diffuse_indirect[c][0]);
            }
        }
        residual_picture_fini(&p);
    }
}

TEST(black_stays_black)
{
    const struct residual_scene s = {.width = 130, .height = 40, .spp = 4};
    const struct rect all = {0, 0, s.width, s.height};
    struct patch *patch = residual_scene_patch(&s, all);
    struct residual_picture p;
    struct residual_statistics statistics = {0};
    assert_int_equal(residual_filter(patch, all, NULL, &p, &statistics), 0);
    assert_int_equal(statistics.pixels, 130 * 40);
    assert_true(statistics.tiles_skipped > 0);
    for (int64_t i = 0; i < rect_area(all); i++)
        for (int c = 0; c < 3; c++)
            assert_true(p.radiance[c][i] == 0.0f && p.diffuse_direct[c][i] == 0.0f &&
                        p.diffuse_indirect[c][i] == 0.0f);
    residual_picture_fini(&p);
    patch_destroy(&patch);
}

/* Pictures that are smaller than what the filter reads, and not constant. */
TEST(small_pictures_keep_to_their_range)
{
    static const int32_t sizes[][2] = {{1, 1}, {1, 40}, {70, 1}, {2, 3}, {3, 2}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        const struct residual_scene s = {
            .width = sizes[k][0], .height = sizes[k][1], .spp = 4, .show = show_noise};
        struct residual_picture p = residual_scene_filter_all(&s);
        struct patch *patch = residual_scene_patch(&s, p.block);
        float least = INFINITY, most = 0.0f;
        assert_finite(&p);
        for (int64_t i = 0; i < rect_area(p.block); i++) {
            const float mean = patch->path_diffuse_direct[0][i] / 4.0f;
            least = fminf(least, mean), most = fmaxf(most, mean);
        }
        for (int64_t i = 0; i < rect_area(p.block); i++)
            assert_true(p.diffuse_direct[0][i] >= 0.99f * least &&
                        p.diffuse_direct[0][i] <= 1.01f * most);
        residual_picture_fini(&p);
        patch_destroy(&patch);
    }
}

/* Nothing hangs on how bright a scene is: by powers of two not even a bit. */
TEST(light_may_be_scaled)
{
    struct residual_scene s = {.width = 90, .height = 50, .spp = 4, .show = show_noise};
    struct residual_picture once = residual_scene_filter_all(&s);
    static const float levels[] = {0x1p-24f, 0x1p24f};
    for (size_t k = 0; k < sizeof levels / sizeof *levels; k++) {
        s.level = levels[k];
        struct residual_picture p = residual_scene_filter_all(&s);
        for (int64_t i = 0; i < rect_area(p.block); i++)
            for (int c = 0; c < 3; c++) {
                assert_true(p.radiance[c][i] == s.level * once.radiance[c][i]);
                assert_true(p.diffuse_direct[c][i] == s.level * once.diffuse_direct[c][i]);
            }
        residual_picture_fini(&p);
    }
    residual_picture_fini(&once);
}

#define FLASH_X 110
#define FLASH_Y 75

static void show_flash(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    const struct residual_scene dim = {.level = 1.0f};
    show_noise(&dim, x, y, sample, out);
    if (x == FLASH_X && y == FLASH_Y && sample == 0)
        residual_grey(s->level, out->direct), residual_grey(s->level, out->rest);
}

/* One sample of 1e30 in one half, and what overflows. */
TEST(a_flash_stays_in_reach)
{
    static const float levels[] = {1e30f, 3e38f};
    struct residual_scene s = {.width = 220, .height = 150, .spp = 4, .show = show_noise};
    const struct plan plan = residual_scene_plan(&s);
    struct residual_picture plain = residual_scene_filter_all(&s);
    const int32_t reach = residual_halo_px(&plan);
    s.show = show_flash;
    for (size_t k = 0; k < sizeof levels / sizeof *levels; k++) {
        uint32_t same = 0;
        s.level = levels[k];
        struct residual_picture p = residual_scene_filter_all(&s);
        assert_finite(&p);
        assert_true(p.radiance[0][residual_picture_at(&p, FLASH_X, FLASH_Y)] > 1.0f);
        for (int32_t y = 0; y < s.height; y++)
            for (int32_t x = 0; x < s.width; x++) {
                const size_t i = residual_picture_at(&p, x, y);
                if (abs(x - FLASH_X) <= reach && abs(y - FLASH_Y) <= reach) continue;
                for (int c = 0; c < 3; c++)
                    assert_memory_equal(p.radiance[c] + i, plain.radiance[c] + i, sizeof(float));
                same++;
            }
        assert_true(same > 3000);
        residual_picture_fini(&p);
    }
    residual_picture_fini(&plain);
}

/* No sample of a pixel differs from another, pixels do, in 256 steps. */
static void show_texture(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                         struct residual_sample *out)
{
    (void)s, (void)sample;
    for (uint32_t c = 0; c < 3; c++) {
        out->direct[c] = floorf(256.0f * residual_random(x, y, 0, c)) / 256.0f;
        out->indirect[c] = floorf(256.0f * residual_random(x, y, 0, 3 + c)) / 256.0f;
        out->rest[c] = floorf(256.0f * residual_random(x, y, 0, 6 + c)) / 256.0f;
    }
}

TEST(halves_that_agree_leave_the_picture)
{
    const struct residual_scene s = {.width = 90, .height = 50, .spp = 16, .show = show_texture};
    struct residual_picture p = residual_scene_filter_all(&s);
    struct patch *patch = residual_scene_patch(&s, p.block);
    for (int32_t y = 0; y < s.height; y++)
        for (int32_t x = 0; x < s.width; x++)
            for (int c = 0; c < 3; c++) {
                const size_t i = residual_picture_at(&p, x, y);
                assert_true(is_near(p.radiance[c][i], residual_scene_mean(patch, c, x, y)));
                assert_true(p.diffuse_direct[c][i] == patch->path_diffuse_direct[c][i] / 16.0f);
                assert_true(p.diffuse_indirect[c][i] == patch->path_diffuse_indirect[c][i] / 16.0f);
            }
    patch_destroy(&patch);
    residual_picture_fini(&p);
}

/* Bright where they are lit, dark where they are not: the remainder has what the product of means
 * lacks, here half as much again, or takes off what it has too much. */
static void show_edges(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    const bool lit = sample % 2 != 0, bright = x < s->width / 2 ? lit : !lit;
    show_texture(s, x, y, sample, out);
    residual_grey(bright ? 0.75f : 0.25f, out->albedo);
    for (int c = 0; c < 3; c++) out->indirect[c] = out->rest[c] = 0.0f;
    if (!lit) residual_grey(0.0f, out->direct);
}

TEST(the_remainder_may_be_negative)
{
    const struct residual_scene s = {.width = 40, .height = 30, .spp = 16, .show = show_edges};
    struct residual_picture p = residual_scene_filter_all(&s);
    struct patch *patch = residual_scene_patch(&s, p.block);
    for (int32_t y = 0; y < s.height; y++)
        for (int32_t x = 0; x < s.width; x++)
            for (int c = 0; c < 3; c++) {
                const float value = p.radiance[c][residual_picture_at(&p, x, y)];
                const float light = residual_random(x, y, 0, (uint32_t)c);
                assert_true(is_near(value, residual_scene_mean(patch, c, x, y)));
                assert_true(fabsf(value - (x < 20 ? 0.375f : 0.125f) * light) < 0.002f);
            }
    patch_destroy(&patch);
    residual_picture_fini(&p);
}

static void show_spikes(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                        struct residual_sample *out)
{
    const float spike = x % 97 == 40 && y % 53 == 20 && sample == 1 ? 5000.0f : 1.0f;
    show_noise(s, x, y, sample, out);
    for (int c = 0; c < 3; c++) out->direct[c] *= (x / 30 % 3 == 1 ? 10.0f : 1.0f) * spike;
}

/* Patches of blocks have the halo or end with the picture. */
static void check_blocks(const struct residual_scene *s)
{
    struct residual_picture all = residual_scene_filter_all(s);
    for (int32_t side = 16; side <= 100; side += 42)
        for (int32_t y = 0; y < s->height; y += side)
            for (int32_t x = 0; x < s->width; x += side) {
                const struct rect r =
                    rect_intersect((struct rect){x, y, x + side, y + side}, all.block);
                if (side == 16 && (x + y) / 16 % 5 != 0) continue; /* a fifth of them will do */
                struct residual_picture part = residual_scene_filter(s, r);
                assert_same(&part, &all);
                residual_picture_fini(&part);
            }
    residual_picture_fini(&all);
}

TEST(pixels_do_not_know_their_block)
{
    struct residual_scene s = {.width = 210, .height = 113, .spp = 4, .show = show_noise};
    check_blocks(&s);
    s.show = show_spikes;
    check_blocks(&s);
}

TEST(instruction_sets_agree)
{
    static const char *const sets[] = {"sse4.2", "avx2", "avx512"};
    const struct residual_scene s = {.width = 150, .height = 61, .spp = 9, .show = show_noise};
    const char *const wanted = getenv("SHEARWATER_ISA");
    char before[16] = "";
    if (wanted) snprintf(before, sizeof before, "%s", wanted);
    struct residual_picture best = residual_scene_filter_all(&s);
    for (size_t k = 0; k < sizeof sets / sizeof *sets; k++) {
        setenv("SHEARWATER_ISA", sets[k], 1);
        struct residual_picture p = residual_scene_filter_all(&s);
        assert_same(&p, &best);
        residual_picture_fini(&p);
    }
    if (wanted)
        setenv("SHEARWATER_ISA", before, 1);
    else
        unsetenv("SHEARWATER_ISA");
    residual_picture_fini(&best);
}

/* Sky in stripes; a pixel that meets it with some of its samples is filtered. */
static void show_sky(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                     struct residual_sample *out)
{
    show_noise(s, x, y, sample, out);
    if (x / 8 % 2 == 0) return;
    memset(out, 0, sizeof *out);
    residual_grey(residual_noise(x, y, sample, 1), out->emission);
}

TEST(background_keeps_its_mean)
{
    const struct residual_scene s = {.width = 80, .height = 40, .spp = 4, .show = show_sky};
    struct residual_picture p = residual_scene_filter_all(&s);
    struct patch *patch = residual_scene_patch(&s, p.block);
    uint32_t changed = 0;
    for (int32_t y = 0; y < s.height; y++)
        for (int32_t x = 0; x < s.width; x++) {
            const size_t i = residual_picture_at(&p, x, y);
            const bool same = p.radiance[1][i] == residual_scene_mean(patch, 1, x, y);
            if (patch->path_coverage[i] == 0.0f)
                assert_true(same && p.diffuse_direct[1][i] == 0.0f);
            else
                changed += !same;
        }
    assert_true(changed > 1000);
    patch_destroy(&patch);
    residual_picture_fini(&p);
}

/* A fourth of the pixels each: rounds have come to them more or less often. */
static uint32_t some(int32_t x, int32_t y)
{
    static const uint32_t counts[] = {1, 4, 64, 9};
    return counts[(x / 12 + 2 * (y / 12)) % 4];
}

TEST(single_samples_are_filtered_among_others)
{
    const struct residual_scene s = {
        .width = 96, .height = 60, .spp = 64, .spp_of = some, .show = show_noise};
    struct residual_picture p = residual_scene_filter_all(&s);
    struct patch *patch = residual_scene_patch(&s, p.block);
    uint32_t changed = 0, single = 0;
    assert_finite(&p);
    for (int32_t y = 0; y < s.height; y++)
        for (int32_t x = 0; x < s.width; x++) {
            const size_t i = residual_picture_at(&p, x, y);
            const bool same = p.radiance[2][i] == residual_scene_mean(patch, 2, x, y);
            single += !same && some(x, y) == 1;
            changed += !same;
        }
    assert_true(changed > 2000 && single > 500);
    patch_destroy(&patch);
    residual_picture_fini(&p);
}

/* Where a light field brings indirect light, there is none along paths. */
TEST(plans_may_lack_indirect_light)
{
    struct residual_scene s = {
        .width = 40, .height = 30, .spp = 16, .show = show_constant, .level = 0.125f};
    s.no_indirect = true;
    struct residual_picture p = residual_scene_filter_all(&s);
    for (int64_t i = 0; i < rect_area(p.block); i++)
        for (int c = 0; c < 3; c++) {
            assert_true(p.diffuse_indirect[c][i] == 0.0f);
            assert_true(p.diffuse_direct[c][i] == s.level * (float)(c + 1));
            assert_true(is_near(p.radiance[c][i], s.level * (0.5f * 5.0f + 0.75f)));
        }
    residual_picture_fini(&p);
}
