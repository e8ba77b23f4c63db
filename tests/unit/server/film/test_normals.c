/* Rows of packed normals: the bits of normals read one by one. */
#include "proto/octahedron.h"
#include "server/film/normals.h"
#include "tests/random.h"
#include "tests/unit/unit.h"

TEST(normals_are_read_as_one_by_one)
{
    struct random r = {7};
    static uint32_t wide[100];
    static uint16_t narrow[100];
    static float x[104], y[104], z[104];
    float *const out[3] = {x, y, z};
    for (uint32_t round = 0; round < 500; round++) {
        const size_t count = 1 + random_bits(&r) % 100, to = round % 4;
        for (size_t i = 0; i < count; i++) {
            wide[i] = i > 0 && random_bits(&r) % (round % 40 + 2) ? wide[i - 1]
                                                                  : (uint32_t)random_bits(&r);
            narrow[i] = (uint16_t)wide[i];
        }
        normals_unpack16(wide, count, to, out);
        for (size_t i = 0; i < count; i++) {
            float n[3];
            octahedron_unpack16(wide[i], n);
            assert_true(x[to + i] == n[0] && y[to + i] == n[1] && z[to + i] == n[2]);
        }
        normals_unpack8(narrow, count, to, out);
        for (size_t i = 0; i < count; i++) {
            float n[3];
            octahedron_unpack8(narrow[i], n);
            assert_true(x[to + i] == n[0] && y[to + i] == n[1] && z[to + i] == n[2]);
        }
    }
}
