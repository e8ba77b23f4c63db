/* Counts of single pixels over the wire: what was packed comes back, damage is told, nothing is
 * written beyond the tile. */
#include <stdlib.h>
#include <string.h>

#include "proto/count_map.h"
#include "tests/unit/unit.h"

#define MOST COUNT_MAP_BYTES_MAX

static uint8_t counts[MOST], back[MOST + 8];

static void round_trip(uint32_t maps, int32_t width, int32_t height)
{
    struct bytes_writer w;
    const size_t area = maps * (size_t)width * (size_t)height;
    bytes_writer_init(&w);
    memset(back, 0xa5, sizeof back);
    assert_int_equal(count_map_pack(&w, counts, maps, width, height), 0);
    assert_true(w.size_bytes <= area);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, maps, width, height, back), 0);
    assert_memory_equal(counts, back, area);
    for (size_t i = area; i < area + 8; i++) assert_int_equal(back[i], 0xa5);
    for (size_t cut = 0; cut < w.size_bytes; cut += 1 + w.size_bytes / 64)
        assert_int_equal(count_map_unpack(w.data, cut, maps, width, height, back), ERR_CORRUPT);
    bytes_writer_fini(&w);
}

TEST(maps_round_trip)
{
    static const int32_t sides[][2] = {{1, 1}, {3, 5}, {17, 1}, {64, 64}, {256, 256}, {250, 31}};
    for (size_t k = 0; k < 2 * sizeof sides / sizeof sides[0]; k++) {
        const uint32_t maps = 1 + (uint32_t)k % 2;
        for (size_t i = 0; i < MOST; i++) counts[i] = (uint8_t)(i * 2654435761u >> 13);
        round_trip(maps, sides[k / 2][0], sides[k / 2][1]);
        for (size_t i = 0; i < MOST; i++) counts[i] = (uint8_t)(16 + (i / 40) % 3);
        round_trip(maps, sides[k / 2][0], sides[k / 2][1]);
        memset(counts, 0, sizeof counts);
        round_trip(maps, sides[k / 2][0], sides[k / 2][1]);
    }
}

TEST(other_sizes_are_refused)
{
    struct bytes_writer w;
    memset(counts, 7, sizeof counts);
    bytes_writer_init(&w);
    assert_int_equal(count_map_pack(&w, counts, 1, 0, 5), ERR_LIMIT);
    assert_int_equal(count_map_pack(&w, counts, 1, 257, 5), ERR_LIMIT);
    assert_int_equal(count_map_pack(&w, counts, 0, 64, 64), ERR_LIMIT);
    assert_int_equal(count_map_pack(&w, counts, 3, 64, 64), ERR_LIMIT);
    assert_int_equal(count_map_pack(&w, counts, 1, 64, 64), 0);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, 1, 64, 63, back), ERR_CORRUPT);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, 2, 64, 64, back), ERR_CORRUPT);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, 1, 256, 256, back), ERR_CORRUPT);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, 1, 64, -1, back), ERR_LIMIT);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, 3, 64, 64, back), ERR_LIMIT);
    bytes_writer_fini(&w);
}

TEST(damage_does_no_harm)
{
    struct bytes_writer w;
    for (size_t i = 0; i < MOST; i++) counts[i] = (uint8_t)(i / 7 % 5);
    bytes_writer_init(&w);
    assert_int_equal(count_map_pack(&w, counts, 1, 64, 64), 0);
    for (size_t i = 0; i < w.size_bytes; i++) {
        const uint8_t was = w.data[i];
        memset(back, 0xa5, sizeof back);
        w.data[i] ^= (uint8_t)(1u << i % 8);
        (void)count_map_unpack(w.data, w.size_bytes, 1, 64, 64, back);
        for (size_t k = 64 * 64; k < 64 * 64 + 8; k++) assert_int_equal(back[k], 0xa5);
        w.data[i] = was;
    }
    bytes_writer_fini(&w);
}
