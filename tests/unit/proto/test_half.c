/* Half floats: all 65536 of them, rounding to nearest even, and rows equal to the scalar functions.
 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#include "proto/half.h"
#include "tests/unit/unit.h"

static uint32_t bits_of(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static float float_of(uint32_t bits)
{
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static bool is_nan_half(unsigned h)
{
    return (h & 0x7c00u) == 0x7c00u && (h & 0x3ffu) != 0;
}

/* The definition: (-1)^s 2^(e-15) (1 + m/1024), and m 2^-24 for e = 0. */
static double value_of(unsigned h)
{
    int exponent = (int)(h >> 10 & 31);
    double mantissa = h & 0x3ff;
    double magnitude =
        exponent == 0 ? ldexp(mantissa, -24) : ldexp(1024.0 + mantissa, exponent - 25);
    return (h & 0x8000u) != 0 ? -magnitude : magnitude;
}

TEST(all_halves_read_right)
{
    for (unsigned h = 0; h < 65536; h++) {
        float v = half_to_float((uint16_t)h);
        if (is_nan_half(h)) {
            assert_true(isnan(v));
        } else if ((h & 0x7fffu) == 0x7c00u) {
            assert_true(isinf(v) && (signbit(v) != 0) == (h >= 0x8000u));
        } else if ((double)v != value_of(h) || (signbit(v) != 0) != (h >= 0x8000u)) {
            fail_msg("half %04x reads as %a", h, (double)v);
        }
    }
}

TEST(all_halves_round_trip)
{
    for (unsigned h = 0; h < 65536; h++) {
        unsigned back = half_from_float(half_to_float((uint16_t)h));
        unsigned expected = is_nan_half(h) ? h | 0x200u : h; /* NaN comes back quiet */
        if (back != expected) fail_msg("half %04x comes back as %04x", h, back);
    }
}

/* Midpoint between each two neighbours goes to the even one, and the floats beside it to their
 * nearest. */
TEST(ties_go_to_even)
{
    for (unsigned h = 0; h < 0x7bff; h++) {
        float middle = (float)((value_of(h) + value_of(h + 1)) / 2);
        unsigned even = (h & 1) == 0 ? h : h + 1;
        float below = nextafterf(middle, 0.0f), above = nextafterf(middle, INFINITY);
        if (half_from_float(middle) != even) fail_msg("tie above %04x", h);
        if (half_from_float(below) != h) fail_msg("below the tie above %04x", h);
        if (half_from_float(above) != h + 1) fail_msg("above the tie above %04x", h);
        if (half_from_float(-middle) != (even | 0x8000u)) fail_msg("negative tie above %04x", h);
    }
}

TEST(range_is_clamped)
{
    static const float large[] = {65504.0f, 65519.0f, 65520.0f, 65536.0f, 1e10f, 3.4e38f};
    for (size_t i = 0; i < sizeof large / sizeof *large; i++) {
        assert_int_equal(half_from_float(large[i]), 0x7bff);
        assert_int_equal(half_from_float(-large[i]), 0xfbff);
    }
    assert_true(half_to_float(0x7bff) == HALF_MAX);
    assert_int_equal(half_from_float(INFINITY), 0x7c00);
    assert_int_equal(half_from_float(-INFINITY), 0xfc00);
    assert_true(isnan(half_to_float(half_from_float(NAN))));
    assert_int_equal(half_from_float(1e-30f), 0);
    assert_int_equal(half_from_float(-1e-30f), 0x8000);
    assert_int_equal(half_from_float(-0.0f), 0x8000);
}

static void check_row(const float *in, size_t count)
{
    uint16_t out[64];
    assert_true(count <= 64);
    half_from_floats(in, out, count);
    for (size_t i = 0; i < count; i++)
        if (out[i] != half_from_float(in[i]))
            fail_msg("%08x: row gives %04x, scalar %04x", bits_of(in[i]), out[i],
                     half_from_float(in[i]));
}

/* Every exponent and sign, with mantissas around all rounding edges. */
static void check_rows_of_floats(void)
{
    static const uint32_t mantissas[] = {
        0,      1,        0xfff,    0x1000,   0x1001,   0x1fff,   0x2000,   0x2fff,   0x3000,
        0x3001, 0x3fffff, 0x400000, 0x400001, 0x7fdfff, 0x7fe000, 0x7fefff, 0x7ff000, 0x7fffff};
    float row[64];
    size_t filled = 0;
    for (uint32_t top = 0; top < 512; top++) {
        for (size_t m = 0; m < sizeof mantissas / sizeof *mantissas; m++) {
            row[filled++] = float_of(top << 23 | mantissas[m]);
            if (filled == 64) {
                check_row(row, filled);
                filled = 0;
            }
        }
    }
    check_row(row, filled);
}

static void check_random_rows(void)
{
    uint64_t seed = 88172645463325252ull;
    float row[64];
    for (int i = 0; i < 20000; i++) {
        for (size_t k = 0; k < 64; k++) {
            seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
            uint32_t bits = (uint32_t)(seed >> 32);
            /* Half of them near a half's range, where the roundings are. */
            if (k & 1) bits = (bits & 0x8fffffffu) | 0x30000000u;
            row[k] = float_of(bits);
        }
        check_row(row, 64);
    }
}

static void check_rows_of_halves(void)
{
    uint16_t in[64];
    float out[64];
    for (unsigned first = 0; first < 65536; first += 64) {
        for (unsigned k = 0; k < 64; k++) in[k] = (uint16_t)(first + k);
        half_to_floats(in, out, 64);
        for (unsigned k = 0; k < 64; k++)
            if (bits_of(out[k]) != bits_of(half_to_float(in[k])))
                fail_msg("half %04x: row gives %08x, scalar %08x", first + k, bits_of(out[k]),
                         bits_of(half_to_float(in[k])));
    }
}

TEST(rows_equal_scalars)
{
    check_rows_of_floats();
    check_random_rows();
    check_rows_of_halves();
}

/* Tracing threads flush subnormals; the conversions must not care. */
TEST(rows_ignore_flushing)
{
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | 0x8040u); /* FTZ and DAZ */
    check_rows_of_floats();
    check_rows_of_halves();
    _mm_setcsr(before);
}

TEST(odd_lengths_stay_inside)
{
    for (size_t count = 0; count <= 33; count++) {
        float in[40], back[40];
        uint16_t out[40];
        for (size_t i = 0; i < 40; i++) in[i] = (float)i, back[i] = -1.0f, out[i] = 0xabcd;
        half_from_floats(in + 1, out + 1, count); /* unaligned */
        assert_int_equal(out[0], 0xabcd);
        assert_int_equal(out[count + 1], 0xabcd);
        half_to_floats(out + 1, back + 1, count);
        assert_true(back[0] == -1.0f && back[count + 1] == -1.0f);
        for (size_t i = 1; i <= count; i++) assert_true(back[i] == in[i]);
    }
}
