/* Points of a lens: uniform over round and straight-edged apertures, one line of equal area after
 * another, the right way up, and the same for ever. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "proto/lens_pattern.h"
#include "tests/unit/unit.h"

#define PI 3.14159265358979323846

static struct plan plan_of(uint32_t l, uint32_t blades, float rotation_rad)
{
    struct plan plan;
    memset(&plan, 0, sizeof plan);
    plan.pattern = (struct pattern){.seed = 3, .frame = 2};
    plan.lens_strata_per_axis = l;
    plan.camera.aperture_radius = 1.0f;
    plan.camera.blade_count = blades;
    plan.camera.blade_rotation_rad = rotation_rad;
    return plan;
}

/* How far a point is inside the edge of a regular polygon, whose first corner is at `rotation` from
 * right towards up; or of the disc. */
static double inside(const struct plan_camera *c, const float u[2])
{
    const double s = (double)u[0], t = -(double)u[1];
    if (c->blade_count == 0) return 1.0 - sqrt(s * s + t * t);
    double least = 2.0;
    for (uint32_t k = 0; k < c->blade_count; k++) {
        const double at = (double)c->blade_rotation_rad + 2.0 * PI * (k + 0.5) / c->blade_count;
        least = fmin(least, cos(PI / c->blade_count) - s * cos(at) - t * sin(at));
    }
    return least;
}

static const struct {
    uint32_t blades;
    float rotation_rad;
} apertures[] = {{0, 0.0f},  {3, 0.0f}, {3, 1.5707964f}, {4, 0.0f},     {4, 0.78539816f},
                 {5, 0.3f},  {6, 0.0f}, {6, -0.2f},      {7, 123.456f}, {8, 0.39269908f},
                 {32, 0.1f}, {3, 1e6f}, {31, -2.0f},     {4, 1e-7f},    {6, 1.5707963f}};
#define APERTURES (sizeof apertures / sizeof *apertures)

TEST(points_are_inside)
{
    for (size_t a = 0; a < APERTURES; a++) {
        const struct plan plan = plan_of(4, apertures[a].blades, apertures[a].rotation_rad);
        double nearest = 1.0;
        for (int32_t p = 0; p < 4000; p++)
            for (uint32_t i = 0; i < 4; i++) {
                float u[2];
                lens_pattern_point(&plan, p % 80, p / 80, i, (uint32_t)p % 4, u);
                nearest = fmin(nearest, inside(&plan.camera, u));
            }
        if (nearest < -4e-6) fail_msg("aperture %zu: %g outside", a, -nearest);
    }
}

/* Moments of the points are those of the aperture: a polygon's area and inertia have closed forms.
 */
TEST(points_are_uniform)
{
    for (size_t a = 0; a < APERTURES; a++) {
        const uint32_t n = apertures[a].blades;
        const struct plan plan = plan_of(3, n, apertures[a].rotation_rad);
        struct lens_pattern pattern;
        double mean[2] = {0}, square[2] = {0}, product = 0.0;
        const int side = 96, count = side * side * 9;
        lens_pattern_init(&pattern, &plan);
        for (int k = 0; k < count; k++) {
            float u[2];
            lens_pattern_at(&pattern, k / 9 % side, k / 9 / side, (uint32_t)k % 3,
                            (uint32_t)k / 3 % 3, u);
            for (int c = 0; c < 2; c++) {
                mean[c] += (double)u[c] / count;
                square[c] += (double)u[c] * (double)u[c] / count;
            }
            product += (double)u[0] * (double)u[1] / count;
        }
        const double expected = n == 0 ? 0.25 : (2.0 + cos(2.0 * PI / n)) / 12.0;
        for (int c = 0; c < 2; c++) {
            if (fabs(mean[c]) > 1e-3) fail_msg("aperture %zu: mean %g", a, mean[c]);
            if (fabs(square[c] - expected) > 1e-3)
                fail_msg("aperture %zu: %g, not %g", a, square[c], expected);
        }
        assert_true(fabs(product) < 1e-3);
    }
}

/* The height below which lies a share of the area, against the area below it by sums of chords. */
TEST(heights_halve_areas)
{
    for (size_t a = 0; a < APERTURES; a++) {
        const struct plan plan = plan_of(1, apertures[a].blades, apertures[a].rotation_rad);
        struct lens_aperture aperture;
        const int steps = 20000;
        lens_aperture_init(&plan.camera, &aperture);
        double below[20001] = {0};
        for (int k = 0; k < steps; k++) {
            float left, right;
            lens_aperture_chord(&aperture, (float)(2.0 * (k + 0.5) / steps - 1.0), &left, &right);
            assert_true(right >= left);
            below[k + 1] = below[k] + (double)(right - left) * 2.0 / steps;
        }
        assert_true(fabs(below[steps] - (double)aperture.area) < 1e-4);
        for (int k = 0; k <= 100; k++) {
            const double height = (double)lens_aperture_height(&aperture, (float)k / 100.0f);
            const double at = (height + 1.0) * 0.5 * steps;
            const int first = at >= steps ? steps - 1 : (int)at;
            const double share = below[first] + (at - first) * (below[first + 1] - below[first]);
            if (fabs(share / below[steps] - k / 100.0) > 1e-4)
                fail_msg("aperture %zu: %g below, not %g", a, share / below[steps], k / 100.0);
        }
    }
}

/* A triangle whose first corner points up has its narrow end where image rows begin; one turned by
 * nothing, to the right. */
TEST(corners_point_as_the_plan_says)
{
    struct lens_aperture aperture;
    float left, right;
    struct plan plan = plan_of(1, 3, (float)(PI / 2));
    lens_aperture_init(&plan.camera, &aperture);
    lens_aperture_chord(&aperture, -0.99f, &left, &right);
    assert_true(right - left < 0.03f);
    lens_aperture_chord(&aperture, 0.49f, &left, &right);
    assert_true(right - left > 1.7f);
    plan = plan_of(1, 3, 0.0f);
    lens_aperture_init(&plan.camera, &aperture);
    lens_aperture_chord(&aperture, 0.0f, &left, &right);
    assert_true(fabsf(right - 1.0f) < 1e-5f && fabsf(left + 0.5f) < 1e-5f);
}

TEST(lines_are_lines_of_equal_area)
{
    const struct plan plan = plan_of(5, 6, 0.1f);
    struct lens_aperture aperture;
    lens_aperture_init(&plan.camera, &aperture);
    for (int32_t p = 0; p < 200; p++)
        for (uint32_t i = 0; i < 5; i++) {
            const float from = lens_aperture_height(&aperture, (float)i / 5.0f);
            const float to = lens_aperture_height(&aperture, (float)(i + 1) / 5.0f);
            float first[2], u[2], left, right;
            lens_pattern_point(&plan, p % 20, p / 20, i, 0, first);
            assert_true(first[1] >= from && first[1] <= to);
            lens_aperture_chord(&aperture, first[1], &left, &right);
            for (uint32_t k = 1; k < 5; k++) {
                lens_pattern_point(&plan, p % 20, p / 20, i, k, u);
                assert_true(u[1] == first[1]);
                assert_true(fabsf(u[0] - first[0] - (right - left) * (float)k / 5.0f) < 1e-5f);
            }
        }
}

/* Anyone may recompute a sample of a result that is years old: these never change. */
TEST(points_are_golden)
{
    static const struct {
        uint32_t l, blades;
        int32_t x, y;
        uint32_t i, k;
        float u[2];
    } golden[] = {
        {3, 0, 0, 0, 0, 0, {-0x1.a33e36p-1f, -0x1.843e9p-2f}},
        {3, 0, 17, 5, 2, 1, {-0x1.1ec2p-5f, 0x1.52b12p-2f}},
        {8, 0, 1000, 2000, 7, 3, {-0x1.7140b8p-3f, 0x1.4d776ap-1f}},
        {4, 5, 9, 9, 1, 3, {0x1.022d42p-1f, -0x1.3658fep-2f}},
        {6, 6, 640, 359, 5, 0, {-0x1.43bb32p-1f, 0x1.23b3dcp-1f}},
    };
    for (size_t g = 0; g < sizeof golden / sizeof *golden; g++) {
        const struct plan plan = plan_of(golden[g].l, golden[g].blades, 0.25f);
        float u[2];
        lens_pattern_point(&plan, golden[g].x, golden[g].y, golden[g].i, golden[g].k, u);
        if (u[0] != golden[g].u[0] || u[1] != golden[g].u[1])
            fail_msg("point %zu: {%af, %af}", g, (double)u[0], (double)u[1]);
    }
}
