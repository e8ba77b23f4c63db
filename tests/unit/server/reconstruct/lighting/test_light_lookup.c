/* Which pixels lend their light to lens samples. */
#include <math.h>

#include "server/reconstruct/lighting/light_lookup.h"
#include "tests/unit/unit.h"

/* What lies on a floor at `z`, seen `tilt` off along it where the middle sees the edge of something
 * round, 4 away, whose tangent plane is the ray. */
static bool look_up(float z, float tilt, float light[3], float gloss[3])
{
    struct light_lookup_pixel pixels[4];
    lens_quad lobes[4];
    struct light_lookup lookup = {.width = 2, .pixels = pixels, .lobes = lobes};
    const struct plan plan = {.width_px = 200,
                              .height_px = 200,
                              .camera = {.type = CAMERA_PERSPECTIVE,
                                         .right = {1, 0, 0},
                                         .up = {0, 1, 0},
                                         .forward = {0, 0, -1},
                                         .half_width = 0.5f,
                                         .half_height = 0.5f}};
    int32_t zero = 0;
    float half = 0.5f, off = 0.01f, distance = z;
    float point[3] = {0, 0, -z}, normal[3] = {0, cosf(tilt), sinf(tilt)};
    const struct lens_relight_row row = {.column = &zero,
                                         .row = &zero,
                                         .across = &half,
                                         .down = &half,
                                         .off = &off,
                                         .distance = &distance,
                                         .point = {point, point + 1, point + 2},
                                         .normal = {normal, normal + 1, normal + 2}};
    surface_view_init(&lookup.view, &plan);
    for (int k = 0; k < 4; k++)
        pixels[k] = (struct light_lookup_pixel){{0, 1, 0, 0}, {1, 2, 3, 4}, {0, 0, -4, 0}};
    for (int k = 0; k < 4; k++) lobes[k] = (lens_quad){(float)k, 7, (float)(k * k), 0};
    return light_lookup_at(&lookup, &row, 0, light, gloss);
}

/* A floor behind a ball whose top is turned like it takes no light from there. */
TEST(round_edges_light_nothing_behind_them)
{
    float light[3] = {0}, gloss[3];
    assert_true(look_up(4.0f, 0.0f, light, gloss) && light[2] == 3.0f);
    assert_true(look_up(4.02f, 0.1f, light, gloss) && light[2] == 3.0f);
    assert_true(!look_up(8.0f, 0.15f, light, gloss));
    assert_true(!look_up(5.0f, 0.25f, light, gloss));
}

/* What lobes see is lent with the same weights, where all four pixels show the surface, and where
 * some do. */
TEST(lobes_are_looked_up_too)
{
    static const float tilts[] = {0.0f, 0.1f};
    for (int k = 0; k < 2; k++) {
        float light[3], gloss[3] = {0};
        assert_true(look_up(4.0f + 0.02f * (float)k, tilts[k], light, gloss));
        assert_true(fabsf(gloss[0] - 1.5f) < 1e-5f && fabsf(gloss[1] - 7.0f) < 1e-5f);
        assert_true(fabsf(gloss[2] - 3.5f) < 1e-5f);
    }
}
