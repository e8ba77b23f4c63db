/* Where lens samples lie that light fields light, and what they send: the kernels of every
 * instruction set give the reference's bits, and those are what single functions say. */
#include <math.h>

#include "proto/octahedron.h"
#include "proto/pattern_path.h"
#include "proto/samples.h"
#include "tests/kernel/kernel_lens_relight.h"
#include "tests/kernel/kernel_tests.h"
#include "tests/unit/unit.h"

#define NUMBERS 131 /* of a row: no multiple of any vector */
#define FIRST   3   /* samples that are placed: not from the row's start on */

static void compare(const struct lens_relight_kernels *tested)
{
    for (uint32_t seed = 1; seed <= 4; seed++) {
        struct lens_relight_case k;
        lens_relight_case_init(&k, 27 + 20 * seed, seed);
        for (enum lens_relight_kernel i = 0; i < LIT_LENS_KERNEL_COUNT; i++)
            for (uint32_t first = 0; first <= FIRST; first += FIRST)
                assert_true(lens_relight_case_compare(&k, tested, i, first) == 0.0f);
        lens_relight_case_fini(&k);
    }
}

TEST(samples_lie_where_the_middle_sees_their_points)
{
    static float out[LENS_RELIGHT_PLANES * NUMBERS];
    struct lens_relight_case k;
    int within = 0;
    lens_relight_case_init(&k, NUMBERS, 5);
    lens_relight_case_run(&k, &lens_relight_kernels_sse42, LIT_LENS_PLACE, FIRST, out);
    const struct lens_relight_row row = lens_relight_case_row(&k, out);
    for (int i = FIRST; i < NUMBERS; i++) {
        const struct path_seeds seeds = {row.order[i], row.u[i], row.v[i]};
        float p[2], normal[3];
        path_seeded_pair(seeds, row.sample, &p[0], &p[1]);
        octahedron_unpack8(row.code[i], normal);
        const float u = row.left[i] + row.length[i] * (row.along[i] + 1.0f) / 3.0f;
        const float x = row.x + (float)i + p[0] + row.slope[i] * u;
        const float y = row.y + p[1] + row.slope[i] * row.height[i];
        const float a = row.a_start + row.a_step * x, z = row.unit * k.number[5][i];
        for (int c = 0; c < 3; c++) assert_true(fabsf(row.normal[c][i] - normal[c]) < 1e-6f);
        assert_true(fabsf(row.point[0][i] - z * a) < 1e-4f);
        assert_true(row.column[i] >= 0 && (float)row.column[i] <= row.x_high - row.x_low);
        assert_true(row.row[i] >= 0 && (float)row.row[i] <= row.y_high - row.y_low);
        if (x < row.x_low + 1.0f || x > row.x_high) continue;
        if (y < row.y_low + 1.0f || y > row.y_high) continue;
        assert_true(fabsf(row.x_low + 0.5f + (float)row.column[i] + row.across[i] - x) < 1e-4f);
        assert_true(fabsf(row.y_low + 0.5f + (float)row.row[i] + row.down[i] - y) < 1e-4f);
        within++;
    }
    assert_true(within > NUMBERS / 2);
    lens_relight_case_fini(&k);
}

TEST(samples_send_on_what_falls_on_them)
{
    static float own[3][NUMBERS], sent[3][NUMBERS];
    struct lens_relight_case k;
    float most = 0.0f, found;
    lens_relight_case_init(&k, NUMBERS, 5);
    lens_relight_case_run(&k, &lens_relight_kernels_sse42, LIT_LENS_OWN, 0, own[0]);
    lens_relight_case_run(&k, &lens_relight_kernels_sse42, LIT_LENS_ADD, 0, sent[0]);
    lens_relight_case_run(&k, &lens_relight_kernels_sse42, LIT_LENS_MAX, 0, &found);
    for (int i = 0; i < NUMBERS; i++) {
        float albedo[3], light[3];
        shared_exponent_unpack(k.words[3][i], SHARED_EXPONENT_9, albedo);
        shared_exponent_unpack(k.words[4][i], SHARED_EXPONENT_8, light);
        for (int c = 0; c < 3; c++) {
            assert_true(own[c][i] == 0.25f * light[c]);
            assert_true(sent[c][i] == k.number[3][i] + albedo[c] * k.number[5][i]);
        }
        most = fmaxf(most, fabsf(k.number[4][i]));
    }
    assert_true(found == most);
    k.number[5][0] = LENS_RADIANCE_MAX * 4.0f;
    k.words[3][0] |= 511u;
    lens_relight_case_run(&k, &lens_relight_kernels_sse42, LIT_LENS_ADD, 0, sent[0]);
    assert_true(sent[0][0] <= LENS_RADIANCE_MAX);
    lens_relight_case_fini(&k);
}

KERNEL_TESTS(lens_relight, compare)
