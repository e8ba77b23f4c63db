/* The tone curve goes there and back, and exposures are those of pictures whose mean is known. */
#include "tests/bench/unet/tone.h"

#include <math.h>

#include "tests/unit/unit.h"

enum { WIDTH = 40, HEIGHT = 24 };

static float values[HEIGHT][WIDTH];

static float exposure(void)
{
    const struct plane plane = {values[0], WIDTH, HEIGHT, WIDTH};
    return tone_exposure((const struct plane *const[3]){&plane, &plane, &plane});
}

static void fill(int32_t from, int32_t end, float v)
{
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = from; x < end; x++) values[y][x] = v;
}

static void assert_near(float v, double want, double relative)
{
    if (!(fabs((double)v - want) <= relative * fabs(want))) fail_msg("%g, not %g", (double)v, want);
}

TEST(the_curve_goes_there_and_back)
{
    float before = 0;
    for (float v = 1e-8f; v < 65504.0f; v *= 1.07f) {
        const float tone = tone_forward(v);
        assert_true(tone > before);
        assert_near(tone_inverse(tone), (double)v, 2e-4);
        before = tone;
    }
}

TEST(the_curve_has_the_values_of_its_formula)
{
    assert_true(tone_forward(0) == 0.0f);
    assert_near(tone_forward(65504), 1, 1e-6);
    const double most = 1.92653254e-01 * log(65504 + 6.26026094e-03) + 9.98620152e-01;
    assert_near(tone_forward(1e-6f), 1.41283765e-03 / most, 1e-5);
    assert_near(tone_forward(0.01f),
                (1.64593172 * pow(0.01, 4.31384981e-01) - 2.94139609e-03) / most, 1e-5);
    assert_near(tone_forward(2), (1.92653254e-01 * log(2.00626026094) + 9.98620152e-01) / most,
                1e-5);
}

TEST(exposure_is_of_the_mean_of_logarithms)
{
    fill(0, WIDTH, 0);
    assert_near(exposure(), 1, 0);
    fill(0, WIDTH, 0.5f);
    assert_near(exposure(), 0.18 / 0.5, 1e-5);
    /* Three columns of cells begin at 0, 13 and 26; black ones do not count. */
    fill(0, 13, 0);
    fill(26, WIDTH, 8);
    assert_near(exposure(), 0.18 / 2, 1e-5);
    /* Within a cell the mean is that of light, not of its logarithm. */
    fill(0, WIDTH, 0);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = y % 2; x < WIDTH; x += 2) values[y][x] = 3;
    assert_near(exposure(), 0.18 / 1.5, 0.01);
}

TEST(what_is_no_light_counts_as_none)
{
    fill(0, WIDTH, 0.5f);
    fill(0, 13, NAN);
    assert_near(exposure(), 0.18 / 0.5, 1e-5);
    fill(0, 13, -4);
    assert_near(exposure(), 0.18 / 0.5, 1e-5);
}
