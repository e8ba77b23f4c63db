/* The residual filter where pixels have one sample each: neighbours lend the half that is missing.
 */
#include <math.h>
#include <stdlib.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define WIDTH  100
#define HEIGHT 70
#define LONE_X 41
#define LONE_Y 30

/* A wall under noise, with a hole around one pixel. */
static void show_wall(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    const int32_t dx = abs(x - LONE_X), dy = abs(y - LONE_Y);
    (void)s;
    out->hits = dx + dy == 0 || dx > 1 || dy > 1;
    if (!out->hits) return;
    residual_grey(0.5f, out->albedo);
    residual_grey(residual_noise(x, y, sample, 1), out->direct);
    residual_grey(0.3f * residual_noise(x, y, sample, 2), out->rest);
}

static const struct residual_scene wall = {
    .width = WIDTH, .height = HEIGHT, .spp = 1, .show = show_wall};

/* Squared, over all pixels but those of the hole. */
static double deviation2(const struct residual_picture *p, double truth, double *mean)
{
    double sum = 0.0, squares = 0.0;
    uint32_t count = 0;
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) {
            const double value = (double)p->radiance[0][residual_picture_at(p, x, y)];
            if (abs(x - LONE_X) <= 1 && abs(y - LONE_Y) <= 1) continue;
            sum += value;
            squares += pow(value - truth, 2);
            count++;
        }
    *mean = sum / count;
    return squares / count;
}

/* Light of mean .5 + .3, of deviation .58. */
TEST(noise_of_single_samples_is_taken_out)
{
    struct residual_picture p = residual_scene_filter_all(&wall);
    double mean;
    const double left = sqrt(deviation2(&p, 0.8, &mean));
    if (!(left < 0.1)) fail_msg("%g of .58 are left", left);
    if (!(fabs(mean - 0.8) < 0.02)) fail_msg("the mean is %g", mean);
    residual_picture_fini(&p);
}

TEST(what_no_neighbour_shows_keeps_its_sample)
{
    struct residual_picture p = residual_scene_filter_all(&wall);
    struct patch *patch = residual_scene_patch(&wall, p.block);
    const size_t i = residual_picture_at(&p, LONE_X, LONE_Y);
    for (int c = 0; c < 3; c++)
        assert_true(p.radiance[c][i] == residual_scene_mean(patch, c, LONE_X, LONE_Y));
    patch_destroy(&patch);
    residual_picture_fini(&p);
}

/* Colours of the chessboard are the picture's, not the block's. */
TEST(single_samples_know_no_blocks)
{
    static const struct rect blocks[] = {{0, 0, 33, 20}, {33, 0, 100, 41}, {20, 41, 61, 70}};
    struct residual_picture all = residual_scene_filter_all(&wall);
    for (int k = 0; k < 3; k++) {
        struct residual_picture part = residual_scene_filter(&wall, blocks[k]);
        for (int32_t y = blocks[k].y0; y < blocks[k].y1; y++)
            for (int32_t x = blocks[k].x0; x < blocks[k].x1; x++)
                for (int c = 0; c < 3; c++)
                    assert_true(part.radiance[c][residual_picture_at(&part, x, y)] ==
                                all.radiance[c][residual_picture_at(&all, x, y)]);
        residual_picture_fini(&part);
    }
    residual_picture_fini(&all);
}
