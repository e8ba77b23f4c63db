/* The elementary functions against the C library's in double, over all binades and at the edges. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "worker/shade/elementary.h"

static double worst;
static float worst_at;

static void begin(void)
{
    worst = 0.0;
    worst_at = 0.0f;
}

static void compare(float got, double expected, double floor_of_error, float at)
{
    assert_true(isfinite(got));
    const double scale = fmax(fabs(expected), floor_of_error);
    const double error = fabs((double)got - expected) / scale;
    if (error > worst) worst = error, worst_at = at;
}

static void end(const char *name, double bound)
{
    print_message("# %s: largest relative error %.3g at %.9g\n", name, worst, (double)worst_at);
    assert_true(worst <= bound);
}

/* Every 2003rd float from `low` to `high`, both positive: all binades. */
#define EACH_FLOAT(x, low, high)                                                                   \
    for (uint32_t bits_ = elementary_bits(low); bits_ <= elementary_bits(high); bits_ += 2003)     \
        for (float x = elementary_of_bits(bits_), *once_ = &x; once_; once_ = NULL)

TEST(test_sine)
{
    begin();
    EACH_FLOAT(x, 1e-30f, 1e8f)
    {
        compare(elementary_sin(x), sin((double)x), 1e-30, x);
        compare(elementary_sin(-x), -sin((double)x), 1e-30, x);
        compare(elementary_cos(x), cos((double)x), 1e-30, x);
        assert_true(elementary_cos(-x) == elementary_cos(x));
    }
    for (int i = -4000; i <= 4000; i++) {
        const float x = (float)(i * M_PI_4);
        compare(elementary_sin(x), sin((double)x), 1e-30, x);
        compare(elementary_cos(x), cos((double)x), 1e-30, x);
    }
    end("sin, cos", 2e-7);
    EACH_FLOAT(x, 1e8f, ELEMENTARY_MAX)
    {
        assert_true(fabsf(elementary_sin(x)) <= 1.0f && fabsf(elementary_cos(-x)) <= 1.0f);
    }
    assert_true(elementary_sin(0.0f) == 0.0f && elementary_cos(0.0f) == 1.0f);
}

TEST(test_turns)
{
    begin();
    for (int i = 0; i <= 1 << 20; i++) {
        const float u = (float)i / (1 << 20);
        float s, c;
        elementary_sincos_turn(u, &s, &c);
        if (i % (1 << 18)) {
            compare(s, sin(2.0 * M_PI * (double)u), 1e-30, u);
            compare(c, cos(2.0 * M_PI * (double)u), 1e-30, u);
        } else {
            static const float quarters[5] = {0, 1, 0, -1, 0};
            assert_true(s == quarters[i >> 18]);
            assert_true(c == quarters[((i >> 18) + 1) & 3]);
        }
    }
    end("sin, cos of turns", 2e-7);
}

TEST(test_exp)
{
    begin();
    EACH_FLOAT(x, 1e-12f, 87.33f)
    {
        compare(elementary_exp(x), exp((double)x), 1e-38, x);
        compare(elementary_exp(-x), exp(-(double)x), 1e-38, -x);
    }
    for (float x = 87.33f; x <= 88.37f; x += 0.001f)
        compare(elementary_exp(x), exp((double)x), 1e-38, x);
    end("exp", 2e-7);
    assert_true(elementary_exp(0.0f) == 1.0f);
    assert_true(elementary_exp(-88.0f) == 0.0f && elementary_exp(-ELEMENTARY_MAX) == 0.0f);
    assert_true(elementary_exp(89.0f) == ELEMENTARY_MAX);
    assert_true(elementary_exp(ELEMENTARY_MAX) == ELEMENTARY_MAX);
}

TEST(test_log)
{
    begin();
    EACH_FLOAT(x, ELEMENTARY_TINY, ELEMENTARY_MAX)
    compare(elementary_log(x), log((double)x), 1e-30, x);
    EACH_FLOAT(d, 6e-8f, 0.3f)
    {
        compare(elementary_log(1.0f + d), log((double)(1.0f + d)), 1e-30, 1.0f + d);
        compare(elementary_log(1.0f - d), log((double)(1.0f - d)), 1e-30, 1.0f - d);
    }
    end("log", 3e-7);
    assert_true(elementary_log(1.0f) == 0.0f);
    assert_true(fabsf(elementary_log(0.0f) + 87.3365f) < 1e-3f);
    assert_true(elementary_log(1e-44f) == elementary_log(0.0f));
}

TEST(test_near_zero)
{
    begin();
    EACH_FLOAT(x, 1e-30f, 87.0f)
    {
        compare(elementary_expm1(x), expm1((double)x), 1e-38, x);
        compare(elementary_expm1(-x), expm1(-(double)x), 1e-38, -x);
    }
    end("expm1", 4e-7);
    begin();
    EACH_FLOAT(x, 1e-30f, 0.9999999f)
    {
        compare(elementary_log1p(x * 100.0f), log1p((double)(x * 100.0f)), 1e-38, x);
        compare(elementary_log1p(-x), log1p(-(double)x), 1e-38, -x);
    }
    end("log1p", 3e-7);
}

TEST(test_atan2)
{
    begin();
    for (int i = 0; i < 20000; i++) {
        const double angle = (i + 0.5) * 2.0 * M_PI / 20000;
        for (int e = -36; e <= 36; e += 9) {
            const float y = (float)(sin(angle) * pow(10, e)), x = (float)(cos(angle) * pow(10, e));
            compare(elementary_atan2(y, x), atan2((double)y, (double)x), 1e-30, (float)angle);
        }
    }
    EACH_FLOAT(t, 1e-18f, 1e18f)
    {
        compare(elementary_atan2(t, 1.0f), atan2((double)t, 1.0), 1e-30, t);
        compare(elementary_atan2(-1.0f, -t), atan2(-1.0, -(double)t), 1e-30, t);
    }
    end("atan2", 3e-7);
    static const float edges[] = {0.0f,           -0.0f,           1.0f,           -1.0f,
                                  ELEMENTARY_MAX, -ELEMENTARY_MAX, ELEMENTARY_TINY};
    for (int i = 0; i < 7; i++)
        for (int j = 0; j < 7; j++) {
            const float got = elementary_atan2(edges[i], edges[j]);
            assert_true(fabs((double)got - atan2((double)edges[i], (double)edges[j])) < 3e-7);
        }
}

TEST(test_erf)
{
    begin();
    EACH_FLOAT(x, 1e-20f, 1e10f)
    {
        compare(elementary_erf(x), erf((double)x), 1e-30, x);
        assert_true(elementary_erf(-x) == -elementary_erf(x));
    }
    end("erf", 5e-7);
    begin();
    for (int i = 0; i <= 4000; i++) {
        const float x = (float)i / 1000;
        compare(elementary_erfcx(x), exp((double)x * (double)x) * erfc((double)x), 1e-30, x);
    }
    end("erfcx", 4e-7);
    assert_true(elementary_erf(0.0f) == 0.0f && elementary_erf(ELEMENTARY_MAX) == 1.0f);
}

/* The inverse is compared by Newton's step from it: (erf(y) - x) / erf'(y). */
static void compare_inverse(float x)
{
    const double y = (double)elementary_erfinv(x), a = fabs((double)x), b = fabs(y);
    const double miss = a < 0.5 ? erf(b) - a : (1.0 - a) - erfc(b);
    const double step = miss * 0.886226925452758 * exp(b * b);
    compare((float)y, y - (y < 0 ? -step : step), 1e-30, x);
}

TEST(test_erfinv)
{
    begin();
    EACH_FLOAT(x, 1e-10f, 0.999f) compare_inverse(x);
    for (uint32_t b = elementary_bits(0.999f); b < elementary_bits(1.0f); b++)
        compare_inverse(elementary_of_bits(b)), compare_inverse(-elementary_of_bits(b));
    end("erfinv", 1e-6);
    assert_true(elementary_erfinv(0.0f) == 0.0f);
    assert_true(elementary_erfinv(1.0f) == elementary_erfinv(0x1.fffffep-1f));
    assert_true(elementary_erfinv(-2.0f) == -elementary_erfinv(1.0f));
}
