/* Errors of the filters of lens samples against dense averages: how much lower than those of the
 * plain average of the same samples, and lower with every sample. Prints a table. */
#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/server/reconstruct/lens/lens_brute.h"
#include "tests/unit/server/reconstruct/lens/lens_scene.h"
#include "tests/unit/unit.h"

static const uint32_t strata[] = {2, 3, 4, 8, 12};
#define COUNTS (sizeof strata / sizeof *strata)

static struct lens_error run(struct lens_picture *p, uint32_t filter, const float *reference)
{
    struct lens_statistics statistics;
    assert_int_equal(lens_run(p, filter, &statistics), 0);
    return lens_error_of(p, reference);
}

static void print(const char *name, struct lens_error e, struct lens_error plain)
{
    print_message(" %s %6.2f /%6.2f %% (%4.1f /%4.1f)", name, 100 * e.all, 100 * e.away,
                  plain.all / e.all, e.away > 0.0 ? plain.away / e.away : 0.0);
}

/* What few samples gain, at least: over all pixels at 9, away from silhouettes at 9. */
static const double gain_all[LENS_SCENES] = {3.3, 4.0, 6.0, 1.9};
static const double gain_away[LENS_SCENES] = {4.4, 5.5, 6.5, 2.4};

static void check_scene(enum lens_scene scene, uint32_t blades, size_t counts)
{
    float *reference = lens_reference(scene, blades);
    double last = 1e9;
    for (size_t k = 0; k < counts; k++) {
        struct lens_picture p;
        lens_picture_create(scene, strata[k], blades, &p);
        const struct lens_error plain = run(&p, LENS_FILTER_NONE, reference);
        const struct lens_error axis = run(&p, LENS_FILTER_AXIS_ALIGNED, reference);
        const struct lens_error shear = run(&p, LENS_FILTER_SHEARED, reference);
        print_message("%-6s %2u blades, %3u samples: average %6.2f /%6.2f %%",
                      lens_scene_names[scene], blades, strata[k] * strata[k], 100 * plain.all,
                      100 * plain.away);
        print("axis-aligned", axis, plain);
        print("sheared", shear, plain);
        print_message("\n");
        if (!(shear.all < last))
            fail_msg("%s: %g at %u samples", lens_scene_names[scene], shear.all,
                     strata[k] * strata[k]);
        if (strata[k] == 3 && plain.all < gain_all[scene] * shear.all)
            fail_msg("%s: %g, and %g", lens_scene_names[scene], plain.all, shear.all);
        if (strata[k] == 3 && plain.away < gain_away[scene] * shear.away)
            fail_msg("%s, away: %g, and %g", lens_scene_names[scene], plain.away, shear.away);
        last = shear.all;
        lens_picture_destroy(&p);
    }
    free(reference);
}

TEST(errors_fall)
{
    check_scene(LENS_PLANES, 0, COUNTS);
    check_scene(LENS_LAMPS, 0, COUNTS - 1);
    check_scene(LENS_FENCE, 0, COUNTS - 1);
    check_scene(LENS_FLOOR, 0, COUNTS - 1);
}

TEST(errors_fall_under_blades)
{
    check_scene(LENS_LAMPS, 5, COUNTS - 1);
    check_scene(LENS_FENCE, 6, COUNTS - 1);
}

/* Slopes of the wrong sign, or of none, do not say where samples go. */
TEST(signs_matter)
{
    float *reference = lens_reference(LENS_PLANES, 3);
    const size_t count = 9 * (size_t)LENS_SIDE * LENS_SIDE;
    struct lens_picture p;
    lens_picture_create(LENS_PLANES, 3, 3, &p);
    const struct lens_error right = run(&p, LENS_FILTER_SHEARED, reference);
    for (size_t i = 0; i < count; i++) p.patch.lens_slope[i] *= -1.0f;
    const struct lens_error wrong = run(&p, LENS_FILTER_SHEARED, reference);
    for (size_t i = 0; i < count; i++) p.patch.lens_slope[i] = 1e4f;
    const struct lens_error none = run(&p, LENS_FILTER_SHEARED, reference);
    print_message(
        "planes, 3 blades, 9 samples: %.2f %%, slopes negated %.2f %%, infinite %.2f %%\n",
        100 * right.all, 100 * wrong.all, 100 * none.all);
    assert_true(wrong.all > 2.0 * right.all);
    assert_true(none.all > 2.0 * right.all);
    lens_picture_destroy(&p);
    free(reference);
}

/* Cells lose nothing against samples by themselves. */
TEST(factored_is_what_it_stands_for)
{
    float *reference = lens_reference(LENS_PLANES, 6);
    struct lens_picture p;
    lens_picture_create(LENS_PLANES, 3, 6, &p);
    const struct lens_error factored = run(&p, LENS_FILTER_SHEARED, reference);
    assert_int_equal(lens_brute(&p), 0);
    const struct lens_error brute = lens_error_of(&p, reference);
    print_message("planes, 6 blades, 9 samples: %.2f %%, by brute force %.2f %%\n",
                  100 * factored.all, 100 * brute.all);
    assert_true(factored.all < 1.05 * brute.all);
    assert_true(brute.all < 1.3 * factored.all);
    lens_picture_destroy(&p);
    free(reference);
}

/* A white slat of that slope before what is grey and in focus, or behind it. */
static void show_slat(struct lens_picture *p, float slope, float behind)
{
    const size_t area = (size_t)LENS_SIDE * LENS_SIDE;
    const uint32_t l = p->plan.lens_strata_per_axis;
    struct lens_pattern pattern;
    lens_pattern_init(&pattern, &p->plan);
    for (size_t i = 0; i < area; i++)
        for (uint32_t j = 0; j < l * l; j++) {
            const int32_t x = (int32_t)(i % LENS_SIDE), y = (int32_t)(i / LENS_SIDE);
            float u[2], at[2];
            lens_pattern_at(&pattern, x, y, j / l, j % l, u);
            pattern_shuffled(&p->plan.pattern, x, y, PATTERN_PIXEL, l, j, at);
            const float from = (float)x + at[0] + slope * u[0];
            const bool white = from > 40.0f && from < 60.3f;
            p->patch.lens_slope[j * area + i] = white ? slope : behind;
            for (uint32_t c = 0; c < 3; c++)
                p->patch.lens_radiance[(j * 3 + c) * area + i] = white ? 1.0f : 0.2f;
        }
}

/* Adds a picture's columns. */
static void add_columns(const struct lens_picture *p, double columns[LENS_SIDE])
{
    for (int y = 16; y < LENS_SIDE - 16; y++)
        for (int x = 0; x < LENS_SIDE; x++) columns[x] += (double)p->out[0][y * LENS_SIDE + x];
}

/* How far columns' means over many seeds are off at most beside the slat. */
static double most_off(float slope, float behind)
{
    enum { SEEDS = 8 };
    double plain[LENS_SIDE] = {0}, sheared[LENS_SIDE] = {0}, most = 0.0;
    for (uint32_t seed = 1; seed <= SEEDS; seed++) {
        struct lens_statistics statistics;
        struct lens_picture p;
        lens_picture_create_seeded(LENS_FENCE, 3, 0, seed, &p);
        show_slat(&p, slope, behind);
        assert_int_equal(lens_run(&p, LENS_FILTER_NONE, &statistics), 0);
        add_columns(&p, plain);
        assert_int_equal(lens_run(&p, LENS_FILTER_SHEARED, &statistics), 0);
        add_columns(&p, sheared);
        lens_picture_destroy(&p);
    }
    for (int x = 0; x < LENS_SIDE; x++)
        most = fmax(most, fabs(sheared[x] - plain[x]) / (SEEDS * (LENS_SIDE - 32)));
    return most;
}

/* Means over seeds keep silhouettes where they are: cells on the lines between quarters of the lens
 * count once, in front as for what is behind. (2.9 % where they do not.) */
TEST(silhouettes_do_not_move)
{
    const double focus = most_off(5.0f, 0.0f), behind = most_off(5.0f, -3.0f);
    print_message("beside a slat: off by %.2f %% before what is in focus, %.2f %% before others\n",
                  100.0 * focus, 100.0 * behind);
    assert_true(focus < 0.01 && behind < 0.01);
}
