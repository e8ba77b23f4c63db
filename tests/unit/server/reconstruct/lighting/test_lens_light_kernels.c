/* Where lens samples lie that light fields light, and what they send: the kernels of every
 * instruction set give the reference's bits, and those are what single functions say. */
#include <math.h>
#include <string.h>

#include "proto/octahedron.h"
#include "proto/pattern_path.h"
#include "proto/samples.h"
#include "proto/shared_exponent.h"
#include "server/reconstruct/lighting/lens_light_kernels.h"
#include "tests/kernel/kernel_tests.h"
#include "tests/unit/unit.h"

#define NUMBERS 67 /* of a row: no multiple of any vector */
#define INPUTS  6
#define FLOATS  10
#define FIRST   3 /* samples that are placed: not from the row's start on */

/* along, height, left, length, slope, z */
static const float low[INPUTS] = {0.0f, -1.0f, -1.0f, 0.0f, -24.0f, 0.01f};
static const float high[INPUTS] = {1.0f, 1.0f, 0.0f, 1.0f, 24.0f, 9.0f};

struct numbers {
    float in[INPUTS][NUMBERS], out[FLOATS][NUMBERS];
    uint32_t bits[5][NUMBERS]; /* seeds, albedo, light */
    uint16_t code[NUMBERS];
    int32_t pixel[2][NUMBERS];
    float light[6][NUMBERS], most; /* light, and what is sent on */
};

static uint32_t draw(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return path_mix(*state);
}

static void fill(struct numbers *n)
{
    uint32_t state = 5;
    *n = (struct numbers){.most = 0.0f};
    for (int k = 0; k < INPUTS; k++)
        for (int i = 0; i < NUMBERS; i++)
            n->in[k][i] = low[k] + (high[k] - low[k]) * path_unit(draw(&state));
    for (int i = 0; i < NUMBERS; i++) {
        const float albedo[3] = {path_unit(draw(&state)), path_unit(draw(&state)), 0.5f};
        const float light[3] = {1e6f * path_unit(draw(&state)), 3.0f, path_unit(draw(&state))};
        for (int k = 0; k < 3; k++) n->bits[k][i] = draw(&state);
        n->bits[3][i] = shared_exponent_pack(albedo, SHARED_EXPONENT_9);
        n->bits[4][i] = shared_exponent_pack(light, SHARED_EXPONENT_8);
        n->code[i] = (uint16_t)draw(&state);
    }
}

static struct lens_light_row row_of(struct numbers *n)
{
    return (struct lens_light_row){
        .along = n->in[0],
        .height = n->in[1],
        .left = n->in[2],
        .length = n->in[3],
        .order = n->bits[0],
        .u = n->bits[1],
        .v = n->bits[2],
        .x = 100,
        .y = 7,
        .l = 3,
        .k = 1,
        .sample = 4,
        .a_start = -0.5f,
        .a_step = 0.005f,
        .b_start = 0.5f,
        .b_step = -0.005f,
        .right = {1, 0, 0},
        .up = {0, 1, 0},
        .forward = {0, 0, -1},
        .unit = 2,
        .allowed = 0.0075f,
        .x_low = 90,
        .x_high = 170,
        .y_low = -1,
        .y_high = 30,
        .slope = n->in[4],
        .code = n->code,
        .z = n->in[5],
        .column = n->pixel[0],
        .row = n->pixel[1],
        .across = n->out[0],
        .down = n->out[1],
        .distance = n->out[2],
        .off = n->out[3],
        .point = {n->out[4], n->out[5], n->out[6]},
        .normal = {n->out[7], n->out[8], n->out[9]},
    };
}

static void run(const struct lens_light_kernels *kernels, struct numbers *n)
{
    fill(n);
    const struct lens_light_row row = row_of(n);
    kernels->place(&row, FIRST, NUMBERS);
    kernels->own(n->bits[4], 0.25f, NUMBERS, (float *[3]){n->light[0], n->light[1], n->light[2]});
    for (uint32_t c = 0; c < 3; c++) {
        memcpy(n->light[3 + c], n->in[3], sizeof n->in[3]);
        kernels->add(n->bits[3], n->light[c], n->light[3 + c], c, NUMBERS, n->light[3 + c]);
    }
    n->most = kernels->most(n->in[4], NUMBERS, 1.0f);
}

static void compare(const struct lens_light_kernels *tested)
{
    static struct numbers expected, result;
    run(&lens_light_kernels_sse42, &expected);
    run(tested, &result);
    assert_memory_equal(&expected, &result, sizeof result);
}

TEST(samples_lie_where_the_middle_sees_their_points)
{
    static struct numbers before, after;
    int within = 0;
    fill(&before);
    run(&lens_light_kernels_sse42, &after);
    for (int i = FIRST; i < NUMBERS; i++) {
        const struct path_seeds seeds = {before.bits[0][i], before.bits[1][i], before.bits[2][i]};
        float p[2], normal[3];
        path_seeded_pair(seeds, 4, &p[0], &p[1]);
        octahedron_unpack8(before.code[i], normal);
        const float u = before.in[2][i] + before.in[3][i] * (before.in[0][i] + 1.0f) / 3.0f;
        const float x = 100.0f + (float)i + p[0] + before.in[4][i] * u;
        const float y = 7.0f + p[1] + before.in[4][i] * before.in[1][i];
        const float a = -0.5f + 0.005f * x, z = 2.0f * before.in[5][i];
        for (int k = 0; k < 3; k++) assert_true(fabsf(after.out[7 + k][i] - normal[k]) < 1e-6f);
        assert_true(fabsf(after.out[4][i] - z * a) < 1e-4f);
        assert_true(after.pixel[0][i] >= 0 && after.pixel[0][i] <= 80);
        assert_true(after.pixel[1][i] >= 0 && after.pixel[1][i] <= 31);
        if (x < 91.0f || x > 170.0f || y < 0.0f || y > 30.0f) continue;
        assert_true(fabsf(90.5f + (float)after.pixel[0][i] + after.out[0][i] - x) < 1e-4f);
        assert_true(fabsf(-0.5f + (float)after.pixel[1][i] + after.out[1][i] - y) < 1e-4f);
        within++;
    }
    assert_true(within > NUMBERS / 2);
}

TEST(samples_send_on_what_falls_on_them)
{
    static struct numbers n;
    float most = 0.0f;
    run(&lens_light_kernels_sse42, &n);
    for (int i = 0; i < NUMBERS; i++) {
        float albedo[3], light[3];
        shared_exponent_unpack(n.bits[3][i], SHARED_EXPONENT_9, albedo);
        shared_exponent_unpack(n.bits[4][i], SHARED_EXPONENT_8, light);
        for (int c = 0; c < 3; c++) {
            assert_true(n.light[c][i] == 0.25f * light[c]);
            assert_true(n.light[3 + c][i] == n.in[3][i] + albedo[c] * n.light[c][i]);
        }
        most = fmaxf(most, fabsf(n.in[4][i]));
    }
    assert_true(n.most == most);
    n.light[0][0] = LENS_RADIANCE_MAX * 4.0f;
    lens_light_kernels_sse42.add(&(uint32_t){n.bits[3][0] | 511u}, n.light[0], n.in[3], 0, 1,
                                 n.light[3]);
    assert_true(n.light[3][0] <= LENS_RADIANCE_MAX);
}

KERNEL_TESTS(lens_light, compare)
