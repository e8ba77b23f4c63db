/* Features that are noise, since samples meet surfaces by chance; and surfaces in pieces. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define WIDTH  160
#define HEIGHT 96
#define AREA   (WIDTH * HEIGHT)

/* A veil, which every other sample meets by chance, before a wall; even light on both. */
static void show_veil(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    const bool veil = residual_random(x, y, sample, 1) < s->level;
    residual_grey(veil ? 0.75f : 0.25f, out->albedo);
    out->distance = veil ? 5.0f : 6.0f;
    residual_grey(1.0f, out->direct);
}

static struct residual_scene veil(uint32_t spp)
{
    return (struct residual_scene){
        .width = WIDTH, .height = HEIGHT, .spp = spp, .show = show_veil, .level = 0.5f};
}

/* Mean square of what is off. */
static double error_of(const struct residual_scene *s)
{
    struct residual_picture p = residual_scene_filter_all(s);
    double sum = 0;
    for (int32_t i = 0; i < AREA; i++) sum += pow((double)p.radiance[1][i] - 0.5, 2) / AREA;
    residual_picture_fini(&p);
    return sum;
}

TEST(noise_of_albedo_falls)
{
    double before = INFINITY;
    for (uint32_t spp = 4; spp <= 64; spp *= 4) {
        const struct residual_scene s = veil(spp);
        const double plain = 0.0625 / spp, error = error_of(&s);
        assert_true(error < plain / 5);
        assert_true(error < before);
        before = error;
    }
}

/* Depth that jumps at an edge, at thin bars and at corners is no noise: texture stays. */
static void show_edges(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    (void)s;
    residual_grey(0.1f + 0.8f * residual_random(x, y, 0, 2), out->albedo);
    residual_grey(residual_noise(x, y, sample, 1), out->direct);
    out->distance = 5.0f + 0.02f * (float)x;
    if (x > 100 || y == 30 || y == 31 || (x - y) % 40 == 0) out->distance = 4.0f;
}

TEST(texture_beside_edges_stays)
{
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_edges};
    struct residual_picture p = residual_scene_filter_all(&s);
    for (int32_t i = 0; i < AREA; i++) {
        const float albedo = 0.1f + 0.8f * residual_random(i % WIDTH, i / WIDTH, 0, 2);
        const float scattered = albedo * p.diffuse_direct[1][i];
        assert_true(fabsf(p.radiance[1][i] - scattered) <= 1e-5f);
    }
    residual_picture_fini(&p);
}

static void assert_knows_no_block(const struct residual_scene *s, struct rect block)
{
    struct residual_picture all = residual_scene_filter_all(s);
    struct residual_picture part = residual_scene_filter(s, block);
    for (int32_t y = block.y0; y < block.y1; y++)
        for (int32_t x = block.x0; x < block.x1; x++)
            for (int c = 0; c < 3; c++) {
                const float a = all.radiance[c][residual_picture_at(&all, x, y)];
                const float b = part.radiance[c][residual_picture_at(&part, x, y)];
                assert_memory_equal(&a, &b, sizeof a);
            }
    residual_picture_fini(&all);
    residual_picture_fini(&part);
}

TEST(veiled_pixels_do_not_know_their_block)
{
    const struct residual_scene s = veil(4);
    assert_knows_no_block(&s, (struct rect){61, 39, 90, 57});
}

/* Small surfaces, with light in nothing between them. */
static void show_islands(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                         struct residual_sample *out)
{
    (void)s;
    residual_grey(residual_noise(x, y, sample, 1), out->direct);
    out->hits = (x / 19 + y / 13) % 4 == 0;
}

TEST(islands_do_not_know_their_block)
{
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_islands};
    for (int32_t x = 0; x + 37 < WIDTH; x += 37)
        assert_knows_no_block(&s, (struct rect){x, 20, x + 37, 59});
}
