/* The sRGB curve and its table. */
#include <math.h>
#include <string.h>

#include "server/image/tonemap.h"
#include "tests/unit/unit.h"

TEST(known_values)
{
    /* IEC 61966-2-1, computed in double precision. */
    static const float pairs[][2] = {{0.0f, 0.0f},          {0.0031308f, 0.0404499f},
                                     {0.18f, 0.4613561f},   {0.5f, 0.7353569f},
                                     {0.2140f, 0.4999320f}, {1.0f, 1.0f}};
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        assert_true(fabsf(tonemap_srgb(pairs[i][0]) - pairs[i][1]) < 1e-4f);
    }
    assert_int_equal(tonemap_byte(0.18f, 1.0f), 118);
    assert_int_equal(tonemap_byte(0.25f, 2.0f), 188);
}

TEST(what_is_outside_is_clipped)
{
    assert_true(tonemap_srgb(-1.0f) == 0.0f);
    assert_true(tonemap_srgb(NAN) == 0.0f);
    assert_true(tonemap_srgb(INFINITY) == 1.0f);
    assert_int_equal(tonemap_byte(NAN, 1.0f), 0);
    assert_int_equal(tonemap_byte(1e30f, 1e30f), 255);
    assert_int_equal(tonemap_byte(-1e30f, 1.0f), 0);
}

static uint8_t table_byte(const struct tonemap_table *table, float v)
{
    const double linear = (double)v;
    uint8_t byte;
    tonemap_table_bytes(table, &linear, 1, &byte, 1);
    return byte;
}

TEST(the_table_gives_the_same_bytes)
{
    static struct tonemap_table table;
    tonemap_table_init(&table);
    for (uint32_t bits = 0; bits < 0x40000000u; bits += 4099) {
        float v;
        memcpy(&v, &bits, sizeof v);
        assert_int_equal(table_byte(&table, v), tonemap_byte(v, 1.0f));
    }
    for (int i = 1; i < 256; i++) {
        float v = table.least[i], below = nextafterf(v, 0.0f);
        assert_int_equal(table_byte(&table, v), i);
        assert_int_equal(table_byte(&table, below), i - 1);
    }
    static const float others[] = {NAN, -NAN, INFINITY, -INFINITY, -0.5f, 3e38f, -0.0f};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        assert_int_equal(table_byte(&table, others[i]), tonemap_byte(others[i], 1.0f));
}
