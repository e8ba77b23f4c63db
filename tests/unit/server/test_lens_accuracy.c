/* Errors of the filters of lens samples against dense averages: how much lower than those of the
 * plain average of the same samples, and lower with every sample. Prints a table. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>

#include "tests/unit/server/lens_brute.h"
#include "tests/unit/server/lens_scene.h"

static const uint32_t strata[] = {2, 3, 4, 8, 16};
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

static void errors_fall(void **state)
{
    (void)state;
    for (int scene = 0; scene < LENS_SCENES; scene++)
        check_scene((enum lens_scene)scene, 0, COUNTS);
}

static void errors_fall_under_blades(void **state)
{
    (void)state;
    check_scene(LENS_LAMPS, 5, COUNTS - 1);
    check_scene(LENS_FENCE, 6, COUNTS - 1);
}

/* Slopes of the wrong sign, or of none, do not say where samples go. */
static void signs_matter(void **state)
{
    (void)state;
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
static void factored_is_what_it_stands_for(void **state)
{
    (void)state;
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_fall),
        cmocka_unit_test(errors_fall_under_blades),
        cmocka_unit_test(signs_matter),
        cmocka_unit_test(factored_is_what_it_stands_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
