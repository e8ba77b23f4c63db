/* Three numbers below one exponent. */
#include <float.h>
#include <math.h>

#include "proto/shared_exponent.h"
#include "tests/unit/unit.h"

static uint32_t next(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*state >> 33);
}

/* Half a step of the largest's mantissa, which has its first bit. */
TEST(errors_are_half_a_step)
{
    static const int bits[] = {SHARED_EXPONENT_9, SHARED_EXPONENT_8};
    uint64_t seed = 7;
    for (int k = 0; k < 200000; k++) {
        const int m = bits[k & 1], range = m == SHARED_EXPONENT_9 ? 14 : 100;
        float in[3], out[3], largest = 0.0f;
        const float scale = ldexpf(1.0f, (int)(next(&seed) % (2u * (uint32_t)range)) - range);
        for (int c = 0; c < 3; c++) {
            in[c] = scale * (float)(next(&seed) % 65536) / 65536.0f;
            largest = fmaxf(largest, in[c]);
        }
        shared_exponent_unpack(shared_exponent_pack(in, m), m, out);
        const float least = ldexpf(1.0f, shared_exponent_min(m));
        const float half = fmaxf(largest * ldexpf(1.0f, -m), 0.5f * least);
        for (int c = 0; c < 3; c++)
            assert_true(fabsf(out[c] - in[c]) <= 1.004f * half); /* full ones are rounded up */
    }
}

TEST(what_is_exact_stays)
{
    static const float in[][3] = {{0, 0, 0}, {1, 1, 1}, {1, 0.5f, 0.25f}, {0.125f, 0, 0.75f}};
    for (size_t k = 0; k < sizeof in / sizeof in[0]; k++)
        for (int m = SHARED_EXPONENT_8; m <= SHARED_EXPONENT_9; m++) {
            float out[3];
            shared_exponent_unpack(shared_exponent_pack(in[k], m), m, out);
            for (int c = 0; c < 3; c++) assert_true(out[c] == in[k][c]);
        }
    const float black[3] = {0, 0, 0};
    assert_int_equal(shared_exponent_pack(black, SHARED_EXPONENT_9), 0);
    assert_int_equal(shared_exponent_pack(black, SHARED_EXPONENT_8), 0);
}

TEST(odd_numbers_are_bounded)
{
    static const float odd[] = {NAN, -1, INFINITY, FLT_MAX, FLT_MIN, 1e-45f, 65504, 1e6f};
    for (size_t k = 0; k < sizeof odd / sizeof odd[0]; k++)
        for (int m = SHARED_EXPONENT_8; m <= SHARED_EXPONENT_9; m++) {
            const float in[3] = {odd[k], odd[(k + 1) % 8], 0};
            float out[3];
            const uint32_t packed = shared_exponent_pack(in, m);
            assert_true(packed >> 3 * m <= shared_exponent_max(m));
            shared_exponent_unpack(packed, m, out);
            for (int c = 0; c < 3; c++) assert_true(out[c] >= 0.0f && out[c] <= FLT_MAX);
        }
}

/* Over all that random bits can be, in the mean nothing is lost, also where the largest mantissa is
 * full; no error is above a step. */
TEST(random_rounding_has_no_bias)
{
    static const float in[][3] = {
        {0.7f, 0.3f, 0.001f}, {0.9985f, 0.5f, 0.25f}, {0.9999f, 0.1f, 0}, {0.99805f, 0.3f, 0.6f}};
    for (size_t k = 0; k < sizeof in / sizeof in[0]; k++)
        for (int m = SHARED_EXPONENT_8; m <= SHARED_EXPONENT_9; m++) {
            double sum[3] = {0};
            const float step =
                ldexpf(1.0f, in[k][0] * ldexpf(1.0f, m) > ldexpf(1.0f, m) - 1.01f ? 1 - m : -m);
            for (uint32_t r = 0; r < 256; r++) {
                float out[3];
                shared_exponent_unpack(shared_exponent_pack_random(in[k], m, r * 0x010101u), m,
                                       out);
                for (int c = 0; c < 3; c++) {
                    assert_true(fabsf(out[c] - in[k][c]) < step);
                    sum[c] += (double)out[c] / 256;
                }
            }
            for (int c = 0; c < 3; c++)
                assert_true(fabs(sum[c] - (double)in[k][c]) <= (double)step / 500);
        }
    const float exact[] = {0.125f, 0.75f, 1.0f};
    for (uint32_t r = 0; r < 256; r++)
        assert_int_equal(shared_exponent_pack_random(exact, SHARED_EXPONENT_9, r * 0x010101u),
                         shared_exponent_pack(exact, SHARED_EXPONENT_9));
}
