/* Counts of single pixels over the wire: what was packed comes back, damage is told, nothing is
 * written beyond the tile. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "proto/count_map.h"

#define MOST COUNT_MAP_BYTES_MAX

static uint8_t counts[MOST], back[MOST + 8];

static void round_trip(int32_t width, int32_t height)
{
    struct bytes_writer w;
    const size_t area = (size_t)width * (size_t)height;
    bytes_writer_init(&w);
    memset(back, 0xa5, sizeof back);
    assert_int_equal(count_map_pack(&w, counts, width, height), 0);
    assert_true(w.size_bytes <= area);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, width, height, back), 0);
    assert_memory_equal(counts, back, area);
    for (size_t i = area; i < area + 8; i++) assert_int_equal(back[i], 0xa5);
    for (size_t cut = 0; cut < w.size_bytes; cut += 1 + w.size_bytes / 64)
        assert_int_equal(count_map_unpack(w.data, cut, width, height, back), ERR_CORRUPT);
    bytes_writer_fini(&w);
}

static void maps_round_trip(void **state)
{
    static const int32_t sides[][2] = {{1, 1}, {3, 5}, {17, 1}, {64, 64}, {256, 256}, {250, 31}};
    (void)state;
    for (size_t k = 0; k < sizeof sides / sizeof sides[0]; k++) {
        for (size_t i = 0; i < MOST; i++) counts[i] = (uint8_t)(i * 2654435761u >> 13);
        round_trip(sides[k][0], sides[k][1]);
        for (size_t i = 0; i < MOST; i++) counts[i] = (uint8_t)(16 + (i / 40) % 3);
        round_trip(sides[k][0], sides[k][1]);
        memset(counts, 0, sizeof counts);
        round_trip(sides[k][0], sides[k][1]);
    }
}

static void other_sizes_are_refused(void **state)
{
    struct bytes_writer w;
    (void)state;
    memset(counts, 7, sizeof counts);
    bytes_writer_init(&w);
    assert_int_equal(count_map_pack(&w, counts, 0, 5), ERR_LIMIT);
    assert_int_equal(count_map_pack(&w, counts, 257, 5), ERR_LIMIT);
    assert_int_equal(count_map_pack(&w, counts, 64, 64), 0);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, 64, 63, back), ERR_CORRUPT);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, 256, 256, back), ERR_CORRUPT);
    assert_int_equal(count_map_unpack(w.data, w.size_bytes, 64, -1, back), ERR_LIMIT);
    bytes_writer_fini(&w);
}

static void damage_does_no_harm(void **state)
{
    struct bytes_writer w;
    (void)state;
    for (size_t i = 0; i < MOST; i++) counts[i] = (uint8_t)(i / 7 % 5);
    bytes_writer_init(&w);
    assert_int_equal(count_map_pack(&w, counts, 64, 64), 0);
    for (size_t i = 0; i < w.size_bytes; i++) {
        const uint8_t was = w.data[i];
        memset(back, 0xa5, sizeof back);
        w.data[i] ^= (uint8_t)(1u << i % 8);
        (void)count_map_unpack(w.data, w.size_bytes, 64, 64, back);
        for (size_t k = 64 * 64; k < 64 * 64 + 8; k++) assert_int_equal(back[k], 0xa5);
        w.data[i] = was;
    }
    bytes_writer_fini(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_round_trip),
        cmocka_unit_test(other_sizes_are_refused),
        cmocka_unit_test(damage_does_no_harm),
    };
    return cmocka_run_group_tests_name("count_map", tests, NULL, NULL);
}
