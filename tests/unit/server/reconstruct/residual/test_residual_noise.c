/* What the residual filter makes of noise: how much of it is left, what leaks over edges, where
 * more samples lead. Seeds are fixed; limits are what these scenes need and a good deal more. */
#include <math.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define WIDTH  96
#define HEIGHT 96
#define AREA   (WIDTH * HEIGHT)

static const struct rect all = {0, 0, WIDTH, HEIGHT};

/* A channel of the picture, plain and filtered. */
struct pictures {
    float plain[AREA], filtered[AREA];
};

static void make_pictures(const struct residual_scene *s, int channel, struct pictures *out)
{
    struct residual_statistics statistics = {0};
    struct residual_picture p;
    struct patch *patch = residual_scene_patch(s, all);
    assert_int_equal(residual_filter(patch, all, NULL, &p, &statistics), 0);
    for (int32_t i = 0; i < AREA; i++) {
        out->plain[i] = residual_scene_mean(patch, channel, i % WIDTH, i / WIDTH);
        out->filtered[i] = p.radiance[channel][i];
    }
    residual_picture_fini(&p);
    patch_destroy(&patch);
}

static double mean(const float *v, int32_t x0, int32_t x1)
{
    double sum = 0;
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = x0; x < x1; x++) sum += (double)v[y * WIDTH + x];
    return sum / (HEIGHT * (x1 - x0));
}

/* Mean square of what is off. */
static double variance(const float *v, float truth)
{
    double sum = 0;
    for (int32_t i = 0; i < AREA; i++) sum += pow((double)(v[i] - truth), 2);
    return sum / AREA;
}

/* The same of means over 8 x 8 pixels. */
static double box_variance(const float *v, float truth)
{
    double sum = 0;
    for (int32_t y = 0; y < HEIGHT; y += 8)
        for (int32_t x = 0; x < WIDTH; x += 8) {
            double box = 0;
            for (int32_t i = 0; i < 64; i++) box += (double)v[(y + i / 8) * WIDTH + x + i % 8];
            sum += pow(box / 64 - (double)truth, 2);
        }
    return sum / (AREA / 64);
}

/* White noise as strong as the light; level says in which component. */
static void show_wall(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    float *const lights[] = {out->direct, out->indirect, out->rest};
    const float scale = s->level < 2.0f ? 2.0f : 1.0f; /* before albedo */
    residual_grey(scale * residual_noise(x, y, sample, 1), lights[(int)s->level]);
}

TEST(noise_of_a_wall_falls)
{
    static struct pictures p;
    for (int component = 0; component < 3; component++) {
        const struct residual_scene s = {.width = WIDTH,
                                         .height = HEIGHT,
                                         .spp = 4,
                                         .show = show_wall,
                                         .level = (float)component};
        make_pictures(&s, 1, &p);
        assert_true(fabs(variance(p.plain, 1.0f) / 0.25 - 1.0) < 0.1);
        assert_true(variance(p.filtered, 1.0f) < variance(p.plain, 1.0f) / 25);
        /* Neighbours are averaged, not made alike by what they share: no new blotches. */
        assert_true(box_variance(p.filtered, 1.0f) < box_variance(p.plain, 1.0f));
        assert_true(fabs(mean(p.filtered, 0, WIDTH) / mean(p.plain, 0, WIDTH) - 1) < 0.005);
    }
}

enum edge { EDGE_NONE, EDGE_DEPTH, EDGE_NORMAL, EDGE_ALBEDO, EDGE_ROUGHNESS, EDGE_COUNT };

/* Light that is brighter on the right, by too little for four samples to tell. */
static void show_edge(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    const bool right = x >= WIDTH / 2;
    const float light = (right ? 1.4f : 1.0f) * residual_noise(x, y, sample, 1);
    const int number = (int)s->level;
    const enum edge edge = (enum edge)(number % EDGE_COUNT);
    residual_grey(light, number < EDGE_COUNT ? out->direct : out->rest);
    if (!right) return;
    if (edge == EDGE_DEPTH) out->distance = 7.0f;
    if (edge == EDGE_NORMAL) out->normal[0] = 1.0f, out->normal[2] = 0.0f;
    if (edge == EDGE_ALBEDO) out->albedo[0] = 0.9f, out->albedo[1] = 0.1f;
    if (edge == EDGE_ROUGHNESS) out->alpha = 0.5f;
}

#define BESIDE 24 /* columns, more than most taps reach */

/* How much of the light beside the edge has gone over it, at most. */
static double leak(enum edge edge, bool rest)
{
    static struct pictures p;
    const struct residual_scene s = {.width = WIDTH,
                                     .height = HEIGHT,
                                     .spp = 4,
                                     .show = show_edge,
                                     .level = (float)(rest ? edge + EDGE_COUNT : edge)};
    make_pictures(&s, 2, &p);
    const int32_t x = WIDTH / 2;
    const double left = mean(p.filtered, x - BESIDE, x) / mean(p.plain, x - BESIDE, x) - 1;
    const double right = mean(p.filtered, x, x + BESIDE) / mean(p.plain, x, x + BESIDE) - 1;
    return fmax(fabs(left), fabs(right));
}

TEST(edges_of_surfaces_do_not_leak)
{
    for (int rest = 0; rest < 2; rest++) {
        assert_true(leak(EDGE_NONE, rest) > 0.006);  /* or this would say nothing */
        assert_true(leak(EDGE_DEPTH, rest) < 0.005); /* noise of those farther left */
        assert_true(leak(EDGE_NORMAL, rest) < 0.005);
    }
    /* Light of the diffuse lobe knows nothing of them. */
    assert_true(leak(EDGE_ALBEDO, true) < 0.01);
    assert_true(leak(EDGE_ROUGHNESS, true) < 0.005);
}

/* Metal with a pattern as fine as pixels, under even light. */
static float pattern(int32_t x, int32_t y)
{
    return 0.1f + 0.8f * residual_random(x, y, 0, 30);
}

static void show_metal(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    (void)s;
    residual_grey(0.0f, out->albedo);
    residual_grey(pattern(x, y), out->tint);
    residual_grey(pattern(x, y) * residual_noise(x, y, sample, 1), out->rest);
}

/* The remainder is filtered without the colour of what reflects it, or nearly so. */
TEST(patterns_of_metal_stay)
{
    static struct pictures p;
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_metal};
    double plain = 0, filtered = 0;
    make_pictures(&s, 0, &p);
    for (int32_t i = 0; i < AREA; i++) {
        const float truth = pattern(i % WIDTH, i / WIDTH);
        plain += pow((double)(p.plain[i] - truth), 2);
        filtered += pow((double)(p.filtered[i] - truth), 2);
    }
    assert_true(filtered < plain / 4);
}

/* A small lamp in smooth metal: no noise but that of where samples lie in their pixel. */
static void show_highlight(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                           struct residual_sample *out)
{
    const float u = (float)(x - WIDTH / 2) + residual_random(x, y, sample, 1),
                v = (float)(y - HEIGHT / 2) + residual_random(x, y, sample, 2);
    const float r2 = u * u + v * v, falls = 1.0f / (1.0f + 4.0f * r2);
    (void)s;
    residual_grey(0.0f, out->albedo);
    residual_grey(0.7f, out->tint);
    out->alpha = 0.01f;
    residual_grey(1e3f * falls * falls * falls, out->rest);
}

/* What is a million times as bright stays where it is. */
TEST(highlights_do_not_leak)
{
    static struct pictures p;
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_highlight};
    double whole = 0, leaked = 0;
    make_pictures(&s, 0, &p);
    for (int32_t i = 0; i < AREA; i++) {
        const int32_t x = i % WIDTH - WIDTH / 2, y = i / WIDTH - HEIGHT / 2;
        whole += (double)p.plain[i];
        if (x * x + y * y >= 16) leaked += (double)(p.filtered[i] - p.plain[i]);
    }
    print_message("%g of %g leaks from a highlight\n", leaked, whole);
    assert_true(leaked < 0.02 * whole);
}

/* An edge of light alone. */
static void show_shadow(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                        struct residual_sample *out)
{
    (void)s;
    residual_grey((x + y < WIDTH ? 0.1f : 1.0f) * (0.5f + residual_random(x, y, sample, 1)),
                  out->direct);
}

TEST(edges_of_light_do_not_leak)
{
    static struct pictures p;
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 16, .show = show_shadow};
    make_pictures(&s, 0, &p);
    double dark = 0, light = 0, dark_plain = 0, light_plain = 0;
    for (int32_t i = 0; i < AREA; i++) {
        const bool lit = i % WIDTH + i / WIDTH >= WIDTH;
        *(lit ? &light : &dark) += (double)p.filtered[i];
        *(lit ? &light_plain : &dark_plain) += (double)p.plain[i];
    }
    assert_true(fabs(dark / dark_plain - 1) < 0.01 && fabs(light / light_plain - 1) < 0.01);
}

/* Red light beside green light, of one brightness. */
static void show_colors(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                        struct residual_sample *out)
{
    (void)s;
    out->direct[x < WIDTH / 2 ? 0 : 1] = 0.5f + residual_random(x, y, sample, 1);
}

TEST(colors_do_not_leak)
{
    static struct pictures p;
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 64, .show = show_colors};
    make_pictures(&s, 0, &p);
    assert_true(mean(p.filtered, WIDTH / 2 - 4, WIDTH / 2) > 0.49); /* of 0.5 */
    assert_true(mean(p.filtered, WIDTH / 2, WIDTH / 2 + 4) < 0.01);
}

/* A texture of light as fine as pixels, behind noise. */
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

static double texture_error(const float *v)
{
    double sum = 0;
    for (int32_t i = 0; i < AREA; i++)
        sum += pow((double)(v[i] - texture(i % WIDTH, i / WIDTH)), 2);
    return sqrt(sum / AREA);
}

TEST(errors_fall_and_the_plain_mean_is_the_end)
{
    static const uint32_t counts[] = {4, 64, 1024};
    static struct pictures p;
    double before = INFINITY;
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        const struct residual_scene s = {
            .width = WIDTH, .height = HEIGHT, .spp = counts[k], .show = show_texture};
        make_pictures(&s, 0, &p);
        const double error = texture_error(p.filtered), plain = texture_error(p.plain);
        assert_true(error < 0.8 * before);
        before = error;
        if (counts[k] == 4) assert_true(error < 0.7 * plain);
        if (counts[k] == 1024) assert_true(error < 1.1 * plain);
    }
}

/* Slanted surfaces of several albedos, with gradients of light, and some sky. */
static void show_room(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    const float ramp = 0.2f + (float)x / WIDTH, turn = y < HEIGHT / 3 ? 0.8f : 0.0f;
    (void)s;
    out->distance = 4.0f + 0.05f * (float)(x + y);
    out->normal[0] = turn, out->normal[2] = sqrtf(1.0f - turn * turn);
    residual_grey(x / 16 % 2 ? 0.2f : 0.7f, out->albedo);
    residual_grey(ramp * residual_noise(x, y, sample, 1), out->direct);
    residual_grey(residual_random(x, y, sample, 2) < 0.1f ? 4.0f : 0.0f, out->indirect);
    residual_grey(0.3f * residual_noise(x, y, sample, 3), out->rest);
}

TEST(energy_stays)
{
    static struct pictures p;
    const struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_room};
    make_pictures(&s, 1, &p);
    assert_true(fabs(mean(p.filtered, 0, WIDTH) / mean(p.plain, 0, WIDTH) - 1) < 0.005);
}

/* One of four samples of every 49th pixel has 200 times what others have. */
static void show_spikes(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                        struct residual_sample *out)
{
    const bool spike = x % 7 == 3 && y % 7 == 3 && sample == 2;
    (void)s;
    out->distance = 4.0f;
    residual_grey(0.5f, out->albedo);
    residual_grey(spike ? 200.0f : 1.0f, out->direct);
    residual_grey(spike ? 200.0f : 1.0f, out->indirect);
}

/* One sample of the picture has all the light of the others together. */
static void show_lone_spike(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                            struct residual_sample *out)
{
    const bool spike = x == s->width / 2 && y == s->height / 2 && sample == 2;
    out->distance = 4.0f;
    residual_grey(0.5f, out->albedo);
    residual_grey(spike ? 4.0f * AREA : 1.0f, out->direct);
}

TEST(lone_spikes_say_nothing)
{
    static struct pictures p;
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_lone_spike};
    make_pictures(&s, 1, &p);
    assert_true(mean(p.plain, 0, WIDTH) > 0.9);
    for (int32_t i = 0; i < AREA; i++) assert_true(fabsf(p.filtered[i] - 0.5f) < 0.01f);
}

/* Many make no spots and lose hardly any light; at borders, where windows end, some is gained. */
TEST(spikes_are_spread)
{
    static struct pictures p;
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_spikes};
    double most = 0, least = INFINITY;
    make_pictures(&s, 1, &p);
    for (int32_t i = 0; i < AREA; i++) {
        most = fmax(most, (double)p.filtered[i]);
        least = fmin(least, (double)p.filtered[i]);
    }
    assert_true(fabs(mean(p.filtered, 0, WIDTH) / mean(p.plain, 0, WIDTH) - 1) < 0.03);
    assert_true(most < 2 * least);
}

/* All light comes by one of a hundred samples; on the right, none does. */
static void show_rare(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    const bool lit = x < s->width / 2 && residual_random(x, y, sample, 8) < 0.01f;
    out->distance = 4.0f;
    residual_grey(0.5f, out->albedo);
    residual_grey(lit ? 100.0f : 0.0f, out->indirect);
}

TEST(rare_light_is_kept_where_it_falls)
{
    static struct pictures p;
    const int32_t inside = WIDTH / 2 - 24, outside = WIDTH / 2 + 24;
    const struct residual_scene s = {.width = WIDTH, .height = HEIGHT, .spp = 4, .show = show_rare};
    make_pictures(&s, 1, &p);
    const double lit = mean(p.filtered, 0, inside);
    assert_true(fabs(lit / mean(p.plain, 0, inside) - 1) < 0.15);
    assert_true(mean(p.filtered, outside, WIDTH) < 0.02 * lit);
    int spots = 0; /* where both halves have it by chance, in a corner that tells little */
    for (int32_t i = 0; i < AREA; i++)
        spots += i % WIDTH < inside && fabs((double)p.filtered[i] / lit - 1) > 0.6;
    assert_in_range(spots, 0, 3);
}

/* Rounds have come to pixels more or less often: all counts gain from their neighbours. */
static uint32_t some(int32_t x, int32_t y)
{
    static const uint32_t counts[] = {2, 4, 9, 30};
    return counts[x / 8 % 2 + 2 * (y / 8 % 2)];
}

TEST(pixels_may_differ_in_samples)
{
    static struct pictures p;
    const struct residual_scene s = {
        .width = WIDTH, .height = HEIGHT, .spp = 30, .spp_of = some, .show = show_wall};
    double plain[31] = {0}, filtered[31] = {0};
    make_pictures(&s, 1, &p);
    for (int32_t i = 0; i < AREA; i++) {
        const uint32_t n = some(i % WIDTH, i / WIDTH);
        plain[n] += pow((double)p.plain[i] - 1, 2);
        filtered[n] += pow((double)p.filtered[i] - 1, 2);
    }
    for (int n = 0; n <= 30; n++)
        if (plain[n] > 0) assert_true(filtered[n] < plain[n] / 10);
    assert_true(fabs(mean(p.filtered, 0, WIDTH) / mean(p.plain, 0, WIDTH) - 1) < 0.01);
}
