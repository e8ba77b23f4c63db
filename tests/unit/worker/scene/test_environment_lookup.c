/* Lookups in environment maps. */
#include <math.h>

#include "tests/unit/worker/scene/environment_draws.h"

TEST(a_constant_map_is_constant_exactly)
{
    float texels[3 * 7 * 5];
    for (uint32_t i = 0; i < 105; i++) texels[i] = 0.1f + 0.3f * (float)(i % 3);
    environment_fixture_open(&f, 7, 5, texels);
    for (int i = 0; i < 10000; i++) {
        float d[3], rgb[3];
        random_direction(d);
        environment_lookup(f.map, d, rgb);
        for (int c = 0; c < 3; c++) assert_true(rgb[c] == texels[c]);
        assert_true(fabs((double)environment_pdf(f.map, d) * 4.0 * M_PI - 1.0) < 1e-6);
        assert_true(fabs((double)draw(d) * 4.0 * M_PI - 1.0) < 1e-6);
    }
    environment_fixture_close(&f);
}

TEST(lookups_are_bilinear)
{
    numbers.state = 1;
    open_random(8, 6);
    const float *t = f.blob.texels;
    for (uint32_t y = 0; y < 6; y++)
        for (uint32_t x = 0; x < 8; x++) {
            float d[3], at_centre[3], between[3];
            const float *here = t + 3 * (8 * y + x), *right = t + 3 * (8 * y + (x + 1) % 8);
            towards((x + 0.5) / 8.0, (y + 0.5) / 6.0, d);
            environment_lookup(f.map, d, at_centre);
            towards((x + 1.25) / 8.0, (y + 0.5) / 6.0, d);
            environment_lookup(f.map, d, between);
            for (int c = 0; c < 3; c++) {
                assert_true(fabsf(at_centre[c] - here[c]) < 1e-4f);
                assert_true(fabsf(between[c] - (0.25f * here[c] + 0.75f * right[c])) < 1e-4f);
            }
        }
    environment_fixture_close(&f);
}

TEST(poles_and_seam_are_as_the_header_says)
{
    float texels[3 * 4 * 2], rgb[3];
    for (uint32_t i = 0; i < 24; i++) texels[i] = (float)(i / 3);
    environment_fixture_open(&f, 4, 2, texels);
    /* +x stands at u = 1/2, between columns 1 and 2; -x on the seam, between 3 and 0 */
    environment_lookup(f.map, (const float[3]){1.0f, 0.0f, 0.0f}, rgb);
    assert_true(fabsf(rgb[0] - 3.5f) < 1e-5f);
    const float around[2] = {0.0f, -0.0f};
    for (int i = 0; i < 2; i++) {
        environment_lookup(f.map, (const float[3]){-1.0f, 0.0f, around[i]}, rgb);
        assert_true(fabsf(rgb[0] - 3.5f) < 1e-5f); /* (0 + 3 + 4 + 7) / 4 */
        assert_true(environment_pdf(f.map, (const float[3]){-1.0f, 0.0f, around[i]}) > 0.0f);
    }
    /* +z at u = 3/4, between 2 and 3; up is the upper row alone */
    environment_lookup(f.map, (const float[3]){0.0f, 0.0f, 1.0f}, rgb);
    assert_true(fabsf(rgb[0] - 4.5f) < 1e-5f);
    environment_lookup(f.map, (const float[3]){0.0f, 1.0f, 0.0f}, rgb);
    assert_true(rgb[0] >= 0.0f && rgb[0] <= 3.0f);
    environment_lookup(f.map, (const float[3]){0.0f, -1.0f, 0.0f}, rgb);
    assert_true(rgb[0] >= 4.0f && rgb[0] <= 7.0f);
    environment_fixture_close(&f);
}

TEST(no_direction_leaves_the_map)
{
    static const float odd[][3] = {
        {0, 0, 0},         {0, 1, 0},   {0, -1, 0},        {-1, 0, 1e-30f},      {-1, 0, -1e-30f},
        {-1, 1e-30f, 0},   {2, 2, 2},   {NAN, NAN, NAN},   {1e-20f, 1, -1e-20f}, {INFINITY, 0, 0},
        {0, -INFINITY, 0}, {0, NAN, 1}, {1e-4f, -1, 1e-4f}};
    numbers.state = 2;
    const uint32_t sizes[][2] = {{1, 1}, {1, 7}, {7, 1}, {5, 3}, {64, 33}};
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        open_random(sizes[k][0], sizes[k][1]);
        for (size_t i = 0; i < sizeof odd / sizeof odd[0]; i++) {
            float rgb[3];
            environment_lookup(f.map, odd[i], rgb);
            (void)environment_pdf(f.map, odd[i]);
        }
        environment_fixture_close(&f);
    }
}
