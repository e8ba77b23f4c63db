/* Directions on the octahedron: error bounds over the whole sphere, special directions, all codes.
 */
#include <math.h>

#include "proto/octahedron.h"
#include "tests/unit/unit.h"

#define DIRECTIONS 400000

/* Fibonacci sphere: even cover, no randomness. */
static void direction(int i, float n[3])
{
    double z = 1.0 - (2.0 * i + 1.0) / DIRECTIONS;
    double turn = i * 2.399963229728653;
    double r = sqrt(1.0 - z * z);
    n[0] = (float)(r * cos(turn));
    n[1] = (float)(r * sin(turn));
    n[2] = (float)z;
}

/* Through the cross product: acos loses all small angles. */
static double angle(const float a[3], const float b[3])
{
    double x = (double)a[1] * b[2] - (double)a[2] * b[1];
    double y = (double)a[2] * b[0] - (double)a[0] * b[2];
    double z = (double)a[0] * b[1] - (double)a[1] * b[0];
    double dot = (double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2];
    return atan2(sqrt(x * x + y * y + z * z), dot);
}

static void check_unit(const float n[3])
{
    double square = (double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2];
    assert_true(fabs(square - 1.0) < 1e-6);
}

TEST(errors_are_small)
{
    double worst16 = 0, worst8 = 0, coarsest = 0;
    for (int i = 0; i < DIRECTIONS; i++) {
        float n[3], back[3];
        direction(i, n);
        octahedron_unpack16(octahedron_pack16(n), back);
        worst16 = fmax(worst16, angle(n, back));
        octahedron_unpack8(octahedron_pack8(n), back);
        worst8 = fmax(worst8, angle(n, back));
        octahedron_unpack8((uint16_t)octahedron_coarsen(octahedron_pack16(n)), back);
        coarsest = fmax(coarsest, angle(n, back));
    }
    if (worst16 >= 5e-5) fail_msg("16 bits: %g rad", worst16);
    if (worst8 >= 0.013) fail_msg("8 bits: %g rad", worst8);
    if (coarsest >= 0.02) fail_msg("8 bits of 16: %g rad", coarsest);
}

TEST(length_does_not_matter)
{
    for (int i = 0; i < DIRECTIONS; i += 997) {
        float n[3];
        direction(i, n);
        float scaled[3] = {n[0] * 1024.0f, n[1] * 1024.0f, n[2] * 1024.0f};
        assert_int_equal(octahedron_pack16(n), octahedron_pack16(scaled));
        assert_int_equal(octahedron_pack8(n), octahedron_pack8(scaled));
    }
}

TEST(axes_are_exact)
{
    for (int axis = 0; axis < 3; axis++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            float n[3] = {0, 0, 0}, back[3];
            n[axis] = (float)sign;
            octahedron_unpack16(octahedron_pack16(n), back);
            assert_true(back[0] == n[0] && back[1] == n[1] && back[2] == n[2]);
            octahedron_unpack8(octahedron_pack8(n), back);
            assert_true(back[0] == n[0] && back[1] == n[1] && back[2] == n[2]);
        }
    }
}

TEST(every_code_is_a_direction)
{
    float n[3];
    for (uint32_t code = 0; code < 65536; code++) {
        octahedron_unpack8((uint16_t)code, n);
        check_unit(n);
        octahedron_unpack16(code * 65537u, n);
        check_unit(n);
        octahedron_unpack16(code | 0x80000000u, n);
        check_unit(n);
    }
    octahedron_unpack16(0, n); /* what an absent plane reads as */
    assert_true(n[0] == 0.0f && n[1] == 0.0f && n[2] == 1.0f);
}

TEST(repacking_changes_nothing)
{
    for (int i = 0; i < DIRECTIONS; i += 37) {
        float n[3], back[3];
        direction(i, n);
        uint32_t packed = octahedron_pack16(n);
        octahedron_unpack16(packed, back);
        assert_int_equal(octahedron_pack16(back), packed);
    }
}

TEST(no_direction_is_harmless)
{
    static const float bad[][3] = {
        {0, 0, 0}, {NAN, 0, 1}, {INFINITY, 1, 0}, {-INFINITY, NAN, 0}, {3e38f, 3e38f, 3e38f}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(octahedron_pack16(bad[i]), 0);
        assert_int_equal(octahedron_pack8(bad[i]), 0);
    }
}
