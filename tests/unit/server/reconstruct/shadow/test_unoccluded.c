/* Irradiance without occlusion: Lambert's formula and quadrature against a fine midpoint rule. */
#include <math.h>

#include "proto/plan.h"
#include "server/reconstruct/shadow/shadow_kernels.h"
#include "tests/unit/unit.h"

#define FINE 240

static struct shadow_rectangle rectangle(float half_u, float half_v, uint32_t profile)
{
    return (struct shadow_rectangle){.centre = {0, 0, 0},
                                     .axis = {{1, 0, 0}, {0, 1, 0}},
                                     .half = {half_u, half_v},
                                     .normal = {0, 0, 1},
                                     .area = 4 * half_u * half_v,
                                     .profile = profile};
}

static float closed_by(const struct shadow_kernels *kernels, const struct shadow_rectangle *light,
                       const float p[3], const float n[3])
{
    const float *const points[3] = {&p[0], &p[1], &p[2]};
    const float *const normals[3] = {&n[0], &n[1], &n[2]};
    float e;
    kernels->unoccluded(light, 1, points, normals, &e);
    return e;
}

static float closed(const struct shadow_rectangle *light, const float p[3], const float n[3])
{
    return closed_by(KERNELS_BEST(shadow_kernels), light, p, n);
}

static double fine(const struct shadow_rectangle *light, const float p[3], const float n[3])
{
    double sum = 0.0;
    for (int i = 0; i < FINE * FINE; i++) {
        const double u = 2.0 * (i % FINE + 0.5) / FINE - 1.0, v = 2.0 * (i / FINE + 0.5) / FINE - 1;
        const double x = u * (double)light->half[0] - (double)p[0];
        const double y = v * (double)light->half[1] - (double)p[1], z = -(double)p[2];
        const double d2 = x * x + y * y + z * z;
        const double up = x * (double)n[0] + y * (double)n[1] + z * (double)n[2];
        const double front = (double)p[2];
        const double profile = light->profile == PROFILE_GAUSSIAN ? exp(-2 * (u * u + v * v)) : 1;
        if (up > 0 && front > 0) sum += profile * (up / d2) * (front / d2);
    }
    return sum / (FINE * FINE) * (double)light->area;
}

static void unit(float v[3])
{
    const float scale = 1.0f / sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] *= scale;
}

static float next(uint32_t *state)
{
    *state = *state * 747796405u + 2891336453u;
    return (float)(*state >> 8) * 0x1p-23f - 1.0f;
}

/* Random receivers at least `near` half-sides before the light, any normal: the largest error, in
 * parts of what a receiver there gets that faces the light. */
static double worst(uint32_t profile, float half_v, float near, float most)
{
    const struct shadow_rectangle light = rectangle(1, half_v, profile);
    uint32_t state = 5;
    double worst_error = 0.0;
    for (int k = 0; k < 300; k++) {
        float p[3] = {most * next(&state), most * next(&state), near + most * fabsf(next(&state))};
        float n[3] = {next(&state), next(&state), next(&state) - 0.3f};
        unit(n);
        float facing[3] = {-p[0], -p[1], -p[2]};
        unit(facing);
        const float e = closed(&light, p, n);
        const double error = fabs((double)e - fine(&light, p, n));
        /* SSE4.2 rounds products, too */
        assert_true(fabsf(closed_by(&shadow_kernels_sse42, &light, p, n) - e) <= 1e-5f * e + 1e-7f);
        worst_error = fmax(worst_error, error / fine(&light, p, facing));
    }
    print_message("profile %u: %.2g\n", profile, worst_error);
    return worst_error;
}

TEST(uniform_is_exact)
{
    /* the midpoint rule itself is that coarse where the horizon cuts the light */
    assert_true(worst(PROFILE_UNIFORM, 1.0f, 0.2f, 4.0f) < 5e-3);
    assert_true(worst(PROFILE_UNIFORM, 0.25f, 0.2f, 40.0f) < 5e-3);
}

TEST(gaussian_is_near)
{
    assert_true(worst(PROFILE_GAUSSIAN, 1.0f, 0.2f, 4.0f) < 2e-3);
    assert_true(worst(PROFILE_GAUSSIAN, 0.25f, 1.0f, 40.0f) < 1e-3);
}

/* Receivers that face Gaussian lights from twice their half-diagonal on, nearer and farther than
 * where few points take over. */
TEST(few_points_are_enough)
{
    double worst_error = 0.0;
    for (int k = 0; k < 12 * 5 * 2; k++) {
        const struct shadow_rectangle light = rectangle(1, k % 2 ? 1.0f : 0.3f, PROFILE_GAUSSIAN);
        const float away = hypotf(light.half[0], light.half[1]) * (2.05f + 0.2f * (float)(k / 10));
        const float angle = 0.3f * (float)(k / 2 % 5);
        const float p[3] = {away * sinf(angle), 0, away * cosf(angle)};
        const float n[3] = {-sinf(angle), 0, -cosf(angle)};
        worst_error =
            fmax(worst_error, fabs((double)closed(&light, p, n) / fine(&light, p, n) - 1));
    }
    print_message("few points: %.2g\n", worst_error);
    assert_true(worst_error < 2e-5);
}

/* Where round things turn away from a light, their horizon goes through it: what is left counts,
 * however little, of what comes there itself. */
TEST(horizons_cut)
{
    double worst_error = 0.0;
    for (uint32_t profile = PROFILE_UNIFORM; profile <= PROFILE_GAUSSIAN; profile++) {
        const struct shadow_rectangle light = rectangle(1, 0.7f, profile);
        for (int k = 0; k < 4 * 6 * 8; k++) {
            const float away = (float[]){1, 4, 12, 60}[k % 4], angle = 0.26f * (float)(k / 4 % 6);
            const float above =
                -0.6f + 0.2f * (float)(k / 24); /* parts of the light's half width */
            const float n[3] = {cosf(angle), sinf(angle), 0};
            const float width = n[0] + 0.7f * n[1];
            const float p[3] = {-above * width * n[0], -above * width * n[1], away};
            const double right = fine(&light, p, n), e = (double)closed(&light, p, n);
            worst_error = fmax(worst_error, fabs(e / right - 1));
        }
    }
    print_message("of what is left: %.2g\n", worst_error);
    assert_true(worst_error < 1e-2);
}

/* Receivers beside each other, whose horizons are near an edge of the light, on either side: what
 * each gets is to the last bit what it gets alone. */
TEST(neighbours_change_nothing)
{
    enum { MANY = 96 };
    uint32_t seed = 11;
    for (int round = 0; round < 200; round++) {
        const struct shadow_rectangle light =
            rectangle(1, 0.4f + 0.5f * fabsf(next(&seed)), (uint32_t)(round % 2));
        static float p[3][MANY], n[3][MANY], e[MANY];
        const float *const points[3] = {p[0], p[1], p[2]}, *const normals[3] = {n[0], n[1], n[2]};
        for (int i = 0; i < MANY; i++) {
            float normal[3] = {next(&seed), next(&seed), 0.3f * next(&seed) - 0.2f};
            unit(normal);
            const float rise = fabsf(normal[0]) + light.half[1] * fabsf(normal[1]);
            const float off = (float[]){1e-7f, 1e-5f, 1e-3f, 0.5f}[i % 4] * next(&seed);
            const float z = 0.5f + 8.0f * fabsf(next(&seed));
            /* so far up that the lowest corner is `off` above */
            const float flat = normal[0] * normal[0] + normal[1] * normal[1];
            const float away = (rise * (1 + off) + normal[2] * z) / flat;
            for (int k = 0; k < 2; k++) p[k][i] = -away * normal[k];
            p[2][i] = z;
            for (int k = 0; k < 3; k++) n[k][i] = normal[k];
        }
        KERNELS_BEST(shadow_kernels)->unoccluded(&light, MANY, points, normals, e);
        for (int i = 0; i < MANY; i++) {
            const float alone = closed(&light, (float[]){p[0][i], p[1][i], p[2][i]},
                                       (float[]){n[0][i], n[1][i], n[2][i]});
            assert_memory_equal(&alone, &e[i], sizeof alone);
        }
    }
}

/* Both formulas agree where one takes over from the other: no seam. */
TEST(no_seams)
{
    const float down[3] = {0, 0, -1};
    const float edges[2] = {8.0f * 1.41421356f, 2.44948974f * 1.41421356f};
    for (uint32_t profile = 0; profile < 2; profile++) {
        const struct shadow_rectangle light = rectangle(1, 1, profile);
        const float before[3] = {0, 0, edges[profile] * 0.9999f};
        const float after[3] = {0, 0, edges[profile] * 1.0001f};
        const float a = closed(&light, before, down), b = closed(&light, after, down);
        assert_true(fabsf(a / b - 1.0f - 4e-4f) < 3e-5f);
    }
}

/* Analytic: a disc's worth of sky above a receiver that touches the light; far away a point. */
TEST(limits)
{
    const float down[3] = {0, 0, -1}, up[3] = {0, 0, 1};
    const struct shadow_rectangle light = rectangle(1, 1, PROFILE_UNIFORM);
    assert_true(fabsf(closed(&light, (const float[]){0.3f, 0.2f, 1e-5f}, down) - 3.14159265f) <
                1e-4f);
    assert_true(fabsf(closed(&light, (const float[]){0, 0, 1e4f}, down) - 4e-8f) < 1e-13f);
    assert_true(closed(&light, (const float[]){0.3f, 0.2f, -1}, up) == 0.0f);
    assert_true(closed(&light, (const float[]){0.3f, 0.2f, 1}, up) == 0.0f);
    const struct shadow_rectangle tiny = rectangle(1e-6f, 1e-6f, PROFILE_UNIFORM);
    assert_true(fabsf(closed(&tiny, (const float[]){0, 0, 1}, down) / 4e-12f - 1.0f) < 1e-5f);
    const struct shadow_rectangle huge = rectangle(1e12f, 1e12f, PROFILE_UNIFORM);
    assert_true(fabsf(closed(&huge, (const float[]){5, 3, 1}, down) - 3.14159265f) < 1e-5f);
    /* one that a vertical receiver sees the half of */
    const float side[3] = {1, 0, 0};
    assert_true(fabsf(closed(&huge, (const float[]){0, 0, 1}, side) - 1.57079633f) < 1e-5f);
}

/* A lamp's own surface, and what lies beside it in its plane, gets nothing of its light, however
 * depths and normals are rounded; what faces it from near gets nearly all there is. */
TEST(lamps_do_not_light_themselves)
{
    for (uint32_t profile = PROFILE_UNIFORM; profile <= PROFILE_GAUSSIAN; profile++) {
        const struct shadow_rectangle light = rectangle(0.5f, 0.25f, profile);
        uint32_t seed = 5;
        for (int i = 0; i < 2000; i++) {
            const float p[3] = {next(&seed), next(&seed), 2e-5f * next(&seed)};
            float n[3] = {3e-5f * next(&seed), 3e-5f * next(&seed), 1.0f};
            unit(n);
            assert_true(closed(&light, p, n) == 0.0f);
            /* the same of the other side of a lamp with two */
            const float behind[3] = {p[0], p[1], 1e-6f * next(&seed) * (fabsf(p[0]) + fabsf(p[1]))};
            const float out[3] = {n[0], n[1], -n[2]};
            assert_true(closed(&light, behind, out) == 0.0f);
            const float near[3] = {0.3f * p[0], 0.15f * p[1], 1e-3f};
            const float facing[3] = {n[0], n[1], -n[2]};
            assert_true(closed(&light, near, facing) > (profile == PROFILE_UNIFORM ? 3.1f : 0.3f));
        }
    }
}

/* Anything finite gives something finite in [0, pi]. */
TEST(always_finite)
{
    static const float sizes[] = {1e-15f, 1e-6f, 1e-3f, 1, 1e3f, 1e8f, 1e15f};
    static const float places[] = {0, 1e-30f, -1e-20f, 1e-6f, 1, -1, 1e4f, 1e10f, -1e16f, 1e16f};
    for (size_t i = 0; i < 7 * 7 * 2; i++) {
        const struct shadow_rectangle light =
            rectangle(sizes[i % 7], sizes[i / 7 % 7], (uint32_t)(i / 49));
        for (size_t j = 0; j < 1000 * 3; j++) {
            const float p[3] = {places[j % 10], places[j / 10 % 10], places[j / 100 % 10]};
            const float n[3] = {j / 1000 == 0, j / 1000 == 1, j / 1000 == 2 ? -1 : 0};
            const float e = closed(&light, p, n);
            assert_true(e >= 0.0f && e <= 3.1417f);
        }
    }
}

/* The normal nearest to the horizon, from the one that faces the light towards `aside`, above
 * which even the lowest corner is by `margin` of the way to it. */
static void tilt(const struct shadow_rectangle *light, const float p[3], const float aside[3],
                 double margin, float out[3])
{
    float least = 0.0f, most = 1.0f;
    for (int turn = 0; turn < 40; turn++) {
        const float at = 0.5f * (least + most);
        float n[3] = {at * aside[0], at * aside[1], at * aside[2] - (1.0f - at)};
        unit(n);
        double rise = 0.0, way = (double)(light->half[0] + light->half[1]);
        for (int k = 0; k < 3; k++) {
            rise -= (double)(p[k] * n[k]);
            way += fabs((double)p[k]);
            if (k < 2) rise -= fabs((double)(n[k] * light->half[k]));
        }
        if (rise > margin * way) {
            least = at;
            for (int k = 0; k < 3; k++) out[k] = n[k];
        } else {
            most = at;
        }
    }
}

/* Receivers above whose horizons the whole light is, some by next to nothing, go
 * another way than those alone, and than those of which some see a corner set: to the same bits. */
TEST(lights_that_are_up_are_whole)
{
    enum { COUNT = 32 };
    static const double margins[] = {2e-5, 1e-3, 0.1, -1e-3};
    uint32_t seed = 5;
    for (uint32_t turn = 0; turn < 600; turn++) {
        const struct shadow_rectangle light = rectangle(1, 0.3f, turn & 1u);
        float p[3][COUNT], n[3][COUNT], together[COUNT], alone[COUNT];
        for (int i = 0; i < COUNT; i++) {
            float at[3] = {2 * next(&seed), 2 * next(&seed), 0.1f + 20 * fabsf(next(&seed))};
            float aside[3] = {next(&seed), next(&seed), next(&seed)}, normal[3] = {0, 0, -1};
            unit(aside);
            tilt(&light, at, aside, margins[turn / 2 % 4], normal);
            for (int k = 0; k < 3; k++) p[k][i] = at[k], n[k][i] = normal[k];
        }
        for (int t = 0; t < 2; t++) {
            const struct shadow_kernels *kernels =
                t ? KERNELS_BEST(shadow_kernels) : &shadow_kernels_sse42;
            kernels->unoccluded(&light, COUNT, (const float *const[]){p[0], p[1], p[2]},
                                (const float *const[]){n[0], n[1], n[2]}, together);
            for (int i = 0; i < COUNT; i++) {
                kernels->unoccluded(&light, 1, (const float *const[]){&p[0][i], &p[1][i], &p[2][i]},
                                    (const float *const[]){&n[0][i], &n[1][i], &n[2][i]},
                                    &alone[i]);
                assert_true(alone[i] > 0.0f);
            }
            assert_memory_equal(together, alone, sizeof alone);
        }
    }
}
