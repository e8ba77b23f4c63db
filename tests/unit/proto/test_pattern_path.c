/* The path tracer's random numbers. */
#include <stdbool.h>
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

/* Counts in `across` x `down` strata what samples first .. end - 1 of the pixels of a square have
 * in a dimension; whether each stratum has `each`. */
static bool fills(int32_t x0, int32_t y0, int32_t side, uint32_t spp, uint32_t first, uint32_t end,
                  uint32_t across, uint32_t down, int each)
{
    static int seen[4096];
    memset(seen, 0, sizeof seen);
    for (int32_t y = y0; y < y0 + side; y++)
        for (int32_t x = x0; x < x0 + side; x++)
            for (uint32_t s = first; s < end; s++) {
                const struct path_places p = path_places_of(9, 2, x, y, spp);
                float u, v;
                path_pair(path_place_key(p, s), path_place_sample(p, s), 5, &u, &v);
                seen[(uint32_t)(u * (float)across) + across * (uint32_t)(v * (float)down)]++;
            }
    for (uint32_t i = 0; i < across * down; i++)
        if (seen[i] != each) return false;
    return true;
}

/* Each pixel's samples are stratified, and so are those of each aligned square of pixels. */
TEST(neighbours_share_a_sequence)
{
    static const int32_t at[][2] = {{0, 0}, {64, 8}, {136, 1024}, {8, 56}};
    for (int k = 0; k < 4; k++) {
        const int32_t x = at[k][0], y = at[k][1];
        for (int32_t i = 0; i < 4; i++) {
            assert_true(fills(x + i, y, 1, 4, 0, 4, 4, 1, 1));
            assert_true(fills(x + i, y, 1, 4, 0, 4, 2, 2, 1));
            assert_true(fills(x + i, y, 1, 4, 0, 2, 2, 1, 1)); /* the first half by itself */
            assert_true(fills(x + i, y, 1, 4, 4, 8, 1, 4, 1)); /* and the second turn */
        }
        assert_true(fills(x, y, 2, 4, 0, 4, 4, 4, 1));
        assert_true(fills(x, y, 8, 4, 0, 4, 16, 16, 1));
        assert_true(fills(x, y, 8, 4, 0, 4, 256, 1, 1));
        assert_true(fills(x, y, 8, 16, 0, 16, 32, 32, 1));
        assert_true(fills(x, y, 8, 16, 16, 32, 32, 32, 1));
    }
    /* Squares that are not aligned, and halves over pixels, are left to chance. */
    assert_false(fills(3, 5, 8, 4, 0, 4, 256, 1, 1));
}

/* No two paths of a picture have the same numbers. */
TEST(places_differ)
{
    const struct path_places p = path_places_of(9, 2, 70, 3, 5), q = path_places_of(9, 2, 6, 3, 5);
    assert_int_equal(p.digits, 3);
    assert_int_not_equal(p.square, q.square);
    assert_int_equal(p.first, q.first);
    assert_int_equal(path_place_key(p, 7), p.square);
    assert_int_not_equal(path_place_key(p, 8), p.square);
    assert_int_equal(path_place_sample(p, 8), path_place_sample(p, 0));
    assert_int_not_equal(path_places_of(9, 3, 70, 3, 5).square, p.square);
    assert_int_equal(path_places_of(9, 2, 70, 3, 1u << 20).digits, 16);
    assert_int_equal(path_places_of(9, 2, 70, 3, 1).digits, 0);
}
