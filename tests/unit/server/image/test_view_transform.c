/* Views: closed forms in double precision, and what any of them must keep. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "server/image/tonemap.h"
#include "server/image/view_kernels.h"
#include "tests/unit/unit.h"

static const enum view_curve curves[] = {VIEW_LINEAR, VIEW_FILMIC, VIEW_AGX};

static void show(enum view_curve curve, double exposure_ev, double r, double g, double b,
                 double shown[3])
{
    const struct view_transform view = view_transform_of(curve, exposure_ev);
    struct view_pixels pixels = {{{r}, {g}, {b}}};
    view_transform_apply(&view, &pixels);
    for (int c = 0; c < 3; c++) shown[c] = pixels.channel[c][0];
}

static double grey(enum view_curve curve, double exposure_ev, double v)
{
    double shown[3];
    show(curve, exposure_ev, v, v, v, shown);
    return shown[1];
}

static bool is_near(double a, double b, double by)
{
    return fabs(a - b) <= by;
}

TEST(linear_light_is_exposed_and_clipped)
{
    double shown[3];
    show(VIEW_LINEAR, 1, 0.125, 0.5, 3, shown);
    assert_true(shown[0] == 0.25 && shown[1] == 1 && shown[2] == 1);
    show(VIEW_LINEAR, -2, 0.125, 0.5, 3, shown);
    assert_true(shown[0] == 0.03125 && shown[1] == 0.125 && shown[2] == 0.75);
}

/* Narkowicz's fraction, written out. */
TEST(filmic_is_a_fraction_of_each_channel)
{
    for (double v = 0; v < 40; v += 0.013) {
        double shown[3];
        show(VIEW_FILMIC, 0, v, v / 2, 2 * v, shown);
        for (int c = 0; c < 3; c++) {
            const double x = 0.6 * (c == 0 ? v : c == 1 ? v / 2 : 2 * v);
            const double top = 2.51 * x * x + 0.03 * x, bottom = 2.43 * x * x + 0.59 * x + 0.14;
            assert_true(is_near(shown[c], fmin(top / bottom, 1), 1e-12));
        }
    }
    assert_true(is_near(grey(VIEW_FILMIC, 0, 0.18), 0.14, 0.001)); /* middle grey */
}

/* The sum of powers as Wrensch prints it. The matrices leave grey nearly alone: Filament's are
 * rounded to four digits. */
TEST(agx_is_a_sigmoid_of_the_logarithm_on_greys)
{
    for (double ev = -14; ev < 6; ev += 0.05) {
        const double v = exp2(ev), x = fmin(fmax((ev + 12.47393) / 16.499999, 0), 1);
        const double y = 15.5 * pow(x, 6) - 40.14 * pow(x, 5) + 31.96 * pow(x, 4) -
                         6.868 * pow(x, 3) + 0.4298 * x * x + 0.1191 * x - 0.00232;
        assert_true(is_near(grey(VIEW_AGX, 0, v), pow(fmax(y, 0), 2.2), 2e-4));
    }
}

/* One pixel of each primary, by matrices multiplied out in another order: what Filament's and
 * three.js' shaders show. */
TEST(agx_of_colours_is_the_published_one)
{
    static const double light[][3] = {
        {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.8, 0.3, 0.05}, {20, 2, 1}};
    static const double inset[3][3] = {{0.5448121, 0.3737974, 0.081381},
                                       {0.1404193, 0.7541078, 0.1053967},
                                       {0.0888171, 0.1788598, 0.7323154}};
    static const double outset[3][3] = {{1.1271005818, -0.1106066431, -0.0164939387},
                                        {-0.1413297635, 1.1578237022, -0.0164939387},
                                        {-0.1413297635, -0.1106066431, 1.2519364066}};
    static const double to_709[3][3] = {
        {1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187}};
    for (size_t i = 0; i < sizeof light / sizeof light[0]; i++) {
        double curve[3], power[3], shown[3];
        for (int r = 0; r < 3; r++) {
            const double v =
                inset[r][0] * light[i][0] + inset[r][1] * light[i][1] + inset[r][2] * light[i][2];
            const double x = fmin((log2(v) + 12.47393) / 16.499999, 1);
            curve[r] = 15.5 * pow(x, 6) - 40.14 * pow(x, 5) + 31.96 * pow(x, 4) -
                       6.868 * pow(x, 3) + 0.4298 * x * x + 0.1191 * x - 0.00232;
        }
        for (int r = 0; r < 3; r++)
            power[r] = pow(
                outset[r][0] * curve[0] + outset[r][1] * curve[1] + outset[r][2] * curve[2], 2.2);
        show(VIEW_AGX, 0, light[i][0], light[i][1], light[i][2], shown);
        for (int r = 0; r < 3; r++) {
            const double v =
                to_709[r][0] * power[0] + to_709[r][1] * power[1] + to_709[r][2] * power[2];
            assert_true(is_near(shown[r], fmin(fmax(v, 0), 1), 1e-5));
        }
    }
}

TEST(a_brighter_grey_is_never_shown_darker)
{
    for (size_t k = 0; k < 3; k++) {
        double before = -1;
        for (double ev = -20; ev < 20; ev += 1.0 / 64) {
            const double now = grey(curves[k], 0, exp2(ev));
            assert_true(now >= before && now <= 1);
            before = now;
        }
        assert_true(before > 0.996 && grey(curves[k], 0, 0) < 1e-9);
        assert_int_equal(tonemap_byte((float)before, 1), 255);
    }
}

TEST(exposure_is_a_factor_of_light)
{
    for (size_t k = 0; k < 3; k++)
        for (double v = 0.001; v < 30; v *= 1.7)
            assert_true(is_near(grey(curves[k], 1.5, v), grey(curves[k], 0, v * exp2(1.5)), 1e-14));
    assert_true(view_transform_of(VIEW_LINEAR, 1e9).scale == exp2(126));
    assert_true(view_transform_of(VIEW_LINEAR, -1e9).scale == exp2(-126));
    assert_true(view_transform_of(VIEW_LINEAR, (double)NAN).scale == 1);
}

TEST(numbers_that_are_no_light_are_black_and_infinite_light_is_white)
{
    for (size_t k = 0; k < 3; k++) {
        double shown[3];
        show(curves[k], 0, (double)NAN, -3, -(double)INFINITY, shown);
        assert_true(shown[0] < 1e-9 && shown[1] < 1e-9 && shown[2] < 1e-9);
        show(curves[k], 100, (double)INFINITY, 1e38, 3e38, shown);
        for (int c = 0; c < 3; c++) assert_true(shown[c] > 0.996 && shown[c] <= 1);
    }
}

/* Each place of a row is shown as it is alone, with the same bits on all instruction sets. */
TEST(pixels_side_by_side_are_shown_as_one_is)
{
    const struct view_kernels *const sets[] = {&view_kernels_sse42, &view_kernels_avx2,
                                               &view_kernels_avx512};
    const int sets_here = 1 + (strcmp(build_isa(), "sse42") != 0) + !strcmp(build_isa(), "avx512");
    for (size_t k = 0; k < 3; k++) {
        struct view_pixels light, first;
        for (int i = 0; i < VIEW_PIXELS; i++)
            for (int c = 0; c < 3; c++) light.channel[c][i] = exp2(0.3 * i - 15 + c);
        for (int set = 0; set < sets_here; set++) {
            struct view_pixels shown = light;
            sets[set]->show(curves[k], 1, &shown);
            if (set == 0) first = shown;
            assert_memory_equal(&shown, &first, sizeof shown);
        }
        for (int i = 0; i < VIEW_PIXELS; i++) {
            double alone[3];
            show(curves[k], 0, light.channel[0][i], light.channel[1][i], light.channel[2][i],
                 alone);
            for (int c = 0; c < 3; c++) assert_true(first.channel[c][i] == alone[c]);
        }
    }
}

/* What AgX is for: bright saturated light goes to white, not to a flat primary. */
TEST(agx_takes_colour_out_of_highlights)
{
    double dim[3], bright[3], clipped[3];
    show(VIEW_AGX, 0, 0.2, 0.02, 0.02, dim);
    show(VIEW_AGX, 0, 20, 2, 2, bright);
    show(VIEW_LINEAR, 0, 20, 0.5, 0.5, clipped);
    assert_true(dim[0] > 4 * dim[1] && bright[1] > 0.5 * bright[0] && clipped[1] == 0.5);
}
