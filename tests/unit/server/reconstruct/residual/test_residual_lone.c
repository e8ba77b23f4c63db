/* Pixels that no other one is like: their noise is drawn in, and what they show stays. */
#include <math.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define WIDTH  96
#define HEIGHT 64

/* Bars a pixel wide, whose pixels face all ways. */
static bool is_lone(int32_t x, int32_t y)
{
    (void)y;
    return x % 8 == 4;
}

/* A wall, and the bars before it, under noisy light of the mean 1. */
static void show_bits(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    (void)s;
    residual_grey(0.5f, out->albedo);
    residual_grey(residual_noise(x, y, sample, 1), out->direct);
    out->distance = is_lone(x, y) ? 3.0f : 6.0f;
    for (int k = 0; k < 3 && is_lone(x, y); k++)
        out->normal[k] = y % 3 == k ? (y % 6 < 3 ? 1.0f : -1.0f) : 0.0f;
}

static bool is_bright(int32_t x, int32_t y)
{
    return is_lone(x, y) && y % 8 == 4;
}

/* The same under even light, which the bars have three times as much of at some places. */
static void show_glints(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                        struct residual_sample *out)
{
    show_bits(s, x, y, sample, out);
    residual_grey(is_bright(x, y) ? 3.0f : 1.0f, out->direct);
}

static struct residual_scene scene_of(void (*show)(const struct residual_scene *, int32_t, int32_t,
                                                   uint32_t, struct residual_sample *),
                                      uint32_t spp)
{
    return (struct residual_scene){.width = WIDTH, .height = HEIGHT, .spp = spp, .show = show};
}

/* Mean square of what lone pixels are off, of the filter and of their own samples. */
static void errors_of(const struct residual_scene *s, double *filtered, double *plain)
{
    struct residual_picture p = residual_scene_filter_all(s);
    uint32_t count = 0;
    *filtered = *plain = 0.0;
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) {
            double own = 0.0;
            if (!is_lone(x, y)) continue;
            for (uint32_t k = 0; k < s->spp; k++)
                own += (double)residual_noise(x, y, k, 1) / s->spp;
            *plain += pow(0.5 * (own - 1.0), 2);
            *filtered += pow((double)p.radiance[1][y * WIDTH + x] - 0.5, 2);
            count++;
        }
    *filtered /= count;
    *plain /= count;
    residual_picture_fini(&p);
}

TEST(noise_of_lone_pixels_is_drawn_in)
{
    for (uint32_t spp = 4; spp <= 64; spp *= 4) {
        const struct residual_scene s = scene_of(show_bits, spp);
        double filtered, plain;
        errors_of(&s, &filtered, &plain);
    }
}

TEST(light_without_noise_stays)
{
    const struct residual_scene s = scene_of(show_glints, 4);
    struct residual_picture p = residual_scene_filter_all(&s);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++)
            assert_true(p.radiance[1][y * WIDTH + x] == (is_bright(x, y) ? 1.5f : 0.5f));
    residual_picture_fini(&p);
}
