/* Rare light is looked for in wide neighbourhoods: a block and the halo around it know all that its
 * pixels depend on. */
#include <math.h>

#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define SIDE 8

/* Spots are in both halves of a pixel's samples, spikes in one. */
static void show_rare(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    const float spot = residual_random(x / 3, y / 3, 0, 77) < 0.02f ? 40.0f : 0.05f;
    const float spike = residual_random(x, y, sample, 6) < 0.02f ? 60.0f : 0.0f;
    const float any = residual_random(x, y, sample, 5);
    (void)s;
    residual_grey(spot * (0.5f + any) + spike, out->direct);
    residual_grey(0.1f * powf(1.0f / (any + 0.001f), 1.2f), out->indirect);
    residual_grey(0.3f * spike + 0.02f, out->rest);
}

static void check_block(const struct residual_scene *s, const struct residual_picture *all,
                        int32_t x0, int32_t y0)
{
    const struct rect r = {x0, y0, x0 + SIDE, y0 + SIDE};
    struct residual_picture part = residual_scene_filter(s, r);
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int c = 0; c < 3; c++)
            assert_memory_equal(part.radiance[c] + residual_picture_at(&part, x0, y),
                                all->radiance[c] + residual_picture_at(all, x0, y),
                                SIDE * sizeof(float));
    residual_picture_fini(&part);
}

TEST(halos_hold_all_that_rare_light_depends_on)
{
    const struct residual_scene s = {.width = 420, .height = 220, .spp = 4, .show = show_rare};
    struct residual_picture all = residual_scene_filter_all(&s);
    for (int32_t x = 244; x < 316; x += SIDE) check_block(&s, &all, x, 108);
    residual_picture_fini(&all);
}
