/* Filters of planes: whatever they are given comes back, and smooth numbers become small ones. */
#include <stdlib.h>
#include <string.h>

#include "proto/limits.h"
#include "proto/plane_filter.h"
#include "tests/random.h"
#include "tests/unit/unit.h"

enum { SIDE_MAX = 40 };

static const int32_t sides[][2] = {{1, 1}, {1, 17}, {17, 1}, {2, 2}, {7, 3}, {40, 40}, {16, 33}};
#define SIDES (sizeof sides / sizeof sides[0])

static void put(uint8_t *to, uint32_t element_bytes, uint32_t number)
{
    memcpy(to, &number, element_bytes); /* little-endian */
}

/* Numbers of one kind: extremes and zeros, noise, or a slope across and down. */
static void fill(int kind, uint32_t element_bytes, int32_t width, int32_t height,
                 struct random *random, uint8_t *out)
{
    static const uint32_t extremes[] = {0,      1,      0x7f,       0x80,       0xff,
                                        0x7fff, 0x8000, 0x7fffffff, 0x80000000, 0xffffffff};
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            const uint32_t any = (uint32_t)random_bits(random);
            const uint32_t number = kind == 0   ? extremes[any % 10]
                                    : kind == 1 ? any
                                                : (uint32_t)(900 + 3 * x + 5 * y);
            put(out + (size_t)(y * width + x) * element_bytes, element_bytes, number);
        }
}

TEST(everything_comes_back)
{
    uint8_t numbers[4 * SIDE_MAX * SIDE_MAX], filtered[sizeof numbers];
    struct random random = {5};
    for (uint32_t bytes = 1; bytes <= 4; bytes *= 2)
        for (size_t s = 0; s < SIDES; s++)
            for (int kind = 0; kind < 3; kind++)
                for (int filter = 0; filter < PLANE_FILTER_COUNT; filter++) {
                    const int32_t w = sides[s][0], h = sides[s][1];
                    const size_t size = (size_t)(w * h) * bytes;
                    fill(kind, bytes, w, h, &random, numbers);
                    memset(filtered, 0xaa, sizeof filtered);
                    plane_filter_apply((enum plane_filter)filter, numbers, bytes, w, h, filtered);
                    if (size < sizeof filtered) assert_int_equal(filtered[size], 0xaa);
                    plane_filter_undo((enum plane_filter)filter, filtered, bytes, w, h);
                    assert_memory_equal(filtered, numbers, size);
                }
}

/* By the definitions, one number at a time. */
TEST(they_do_what_is_said)
{
    const uint16_t numbers[6] = {5, 3, 65535, 4, 4, 4};
    const uint16_t left[6] = {10, 3, 7, 10, 0, 0};    /* 5 -2 -4 5 0 0, folded */
    const uint16_t gradient[6] = {10, 3, 7, 1, 4, 8}; /* 5 -2 -4, then -1 2 4 */
    const uint16_t bits[6] = {5, 6, 65532, 65531, 0, 0};
    uint16_t out[6];
    plane_filter_apply(PLANE_FILTER_LEFT, numbers, 2, 3, 2, out);
    assert_memory_equal(out, left, sizeof out);
    plane_filter_apply(PLANE_FILTER_XOR, numbers, 2, 3, 2, out);
    assert_memory_equal(out, bits, sizeof out);
    plane_filter_apply(PLANE_FILTER_GRADIENT, numbers, 2, 3, 2, out);
    assert_memory_equal(out, gradient, sizeof out);
}

static enum plane_filter chosen(const uint16_t *numbers, int32_t width, int32_t height)
{
    return plane_filter_choose(numbers, 2, width, height);
}

TEST(each_is_chosen_where_it_pays)
{
    static uint16_t numbers[SIDE_MAX * SIDE_MAX];
    struct random random = {9};
    for (int i = 0; i < SIDE_MAX * SIDE_MAX; i++) numbers[i] = (uint16_t)random_bits(&random);
    assert_int_equal(chosen(numbers, SIDE_MAX, SIDE_MAX), PLANE_FILTER_NONE);
    for (int i = 0; i < SIDE_MAX * SIDE_MAX; i++)
        numbers[i] = (uint16_t)(20000 + 37 * (i % SIDE_MAX) + 211 * (i / SIDE_MAX));
    assert_int_equal(chosen(numbers, SIDE_MAX, SIDE_MAX), PLANE_FILTER_GRADIENT);
    for (int i = 0; i < SIDE_MAX * SIDE_MAX; i++)
        numbers[i] =
            (uint16_t)(30000 + (int)(random_bits(&random) % 4) + 5000 * (i / SIDE_MAX % 2));
    assert_int_equal(chosen(numbers, SIDE_MAX, SIDE_MAX), PLANE_FILTER_XOR);
    for (int i = 0; i < SIDE_MAX * SIDE_MAX; i++) {
        const int steep = i / SIDE_MAX % 2 ? 1 : 3;
        numbers[i] = (uint16_t)(20000 + i % SIDE_MAX * 17 * steep);
    }
    assert_int_equal(chosen(numbers, SIDE_MAX, SIDE_MAX), PLANE_FILTER_LEFT);
    memset(numbers, 0, sizeof numbers);
    assert_int_equal(chosen(numbers, SIDE_MAX, SIDE_MAX), PLANE_FILTER_NONE);
}

/* A row has no row above. */
TEST(few_rows_are_left_alone)
{
    uint32_t numbers[LIMIT_TILE_SIDE_PX];
    for (int i = 0; i < LIMIT_TILE_SIDE_PX; i++) numbers[i] = 70000u + (uint32_t)i;
    assert_int_equal(plane_filter_choose(numbers, 4, LIMIT_TILE_SIDE_PX, 1), PLANE_FILTER_NONE);
    assert_int_not_equal(plane_filter_choose(numbers, 4, 1, 2), PLANE_FILTER_NONE);
}
