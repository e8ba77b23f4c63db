/* The path tracer's random numbers. */
#include <string.h>

#include "proto/pattern_path.h"
#include "tests/unit/unit.h"

enum { BITS = 8, SAMPLES = 1 << BITS };

/* How many of the samples first .. first + 2^bits - 1 lie in each elementary interval of area
 * 2^-bits, 2^across wide intervals side by side; all must hold one. */
static void assert_net(uint32_t key, uint32_t dimension, uint32_t first, uint32_t bits,
                       uint32_t across)
{
    uint8_t seen[SAMPLES] = {0};
    const uint32_t columns = 1u << across, rows = 1u << (bits - across);
    for (uint32_t i = 0; i < 1u << bits; i++) {
        float u, v;
        path_pair(key, first + i, dimension, &u, &v);
        assert_true(u >= 0.0f && u < 1.0f && v >= 0.0f && v < 1.0f);
        uint32_t x = (uint32_t)(u * (float)columns), y = (uint32_t)(v * (float)rows);
        seen[y * columns + x]++;
    }
    for (uint32_t k = 0; k < 1u << bits; k++) assert_int_equal(seen[k], 1);
}

TEST(pairs_are_nets)
{
    for (uint32_t pixel = 0; pixel < 16; pixel++) {
        uint32_t key = path_key(7 + pixel, 1, (int32_t)pixel, 3);
        for (uint32_t bits = 1; bits <= BITS; bits++)
            for (uint32_t across = 0; across <= bits; across++) {
                assert_net(key, pixel, 0, bits, across);
                assert_net(key, pixel, 5u << bits, bits, across); /* a later pass */
            }
    }
}

/* Correlation of the same sample in two dimensions, and of neighbouring pixels in one. */
TEST(dimensions_and_pixels_are_independent)
{
    double dimensions = 0, pixels = 0;
    enum { COUNT = 65536 };
    for (int32_t i = 0; i < COUNT; i++) {
        float a, b, c, unused;
        uint32_t key = path_key(1, 0, i & 255, i >> 8),
                 other = path_key(1, 0, (i & 255) + 1, i >> 8);
        path_pair(key, 0, 5, &a, &unused);
        path_pair(key, 0, 6, &b, &unused);
        path_pair(other, 0, 5, &c, &unused);
        dimensions += ((double)a - 0.5) * ((double)b - 0.5) * 12;
        pixels += ((double)a - 0.5) * ((double)c - 0.5) * 12;
    }
    /* Standard error of a correlation: 1 / sqrt(COUNT) = 0.0039. */
    assert_true(dimensions / COUNT < 0.016 && dimensions / COUNT > -0.016);
    assert_true(pixels / COUNT < 0.016 && pixels / COUNT > -0.016);
}

TEST(keys_differ)
{
    const uint32_t key = path_key(1, 0, 10, 20);
    assert_int_not_equal(key, path_key(2, 0, 10, 20));
    assert_int_not_equal(key, path_key(UINT64_C(1) << 32 | 1, 0, 10, 20));
    assert_int_not_equal(key, path_key(1, 1, 10, 20));
    assert_int_not_equal(key, path_key(1, 0, 11, 20));
    assert_int_not_equal(key, path_key(1, 0, 20, 10));
    assert_int_not_equal(path_ray_key(key, 3, 2, PATH_RAY_NEXT),
                         path_ray_key(key, 3, 2, PATH_RAY_SHADOW));
    assert_int_not_equal(path_ray_key(key, 3, 2, PATH_RAY_NEXT),
                         path_ray_key(key, 3, 1, PATH_RAY_NEXT));
}
