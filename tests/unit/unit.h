#pragma once
/* What unit tests are written with: cmocka, and tests that register themselves.
 *
 *     TEST(numbers_add_up)
 *     {
 *         assert_int_equal(1 + 1, 2);
 *     }
 *
 * Each file test_NAME.c is a program; unit.c has its main(), which runs the tests in the order of
 * the source. A test may read cmocka's `state`, which EACH_TEST's or ALL_TESTS' functions have
 * filled. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
/* cmocka.h needs those four before it. */
#include <cmocka.h>

struct unit_test {
    struct CMUnitTest test;
    int place; /* in the source */
    struct unit_test *next;
};

void unit_add(struct unit_test *test);
void unit_each(CMFixtureFunction set_up, CMFixtureFunction tear_down);
void unit_all(CMFixtureFunction set_up, CMFixtureFunction tear_down);

/* Runs all tests that are registered, and returns how many failed. Only a main() that runs them
 * more than once needs it. */
int unit_run(const char *group);

enum { UNIT_PATH_BYTES = 4096 };

/* Writes the path of a file of the folder of scenes, $SHEARWATER_SCENES, or skips the test where
 * there is none (tests/golden/README.md). */
void scene_path(const char *name, char path[UNIT_PATH_BYTES]);

/* Makes writes to a closed pipe fail with an error instead of ending the process, for ALL_TESTS. */
int ignore_broken_pipes(void **state);

#define TEST(name)                                                                                 \
    static void name(void **state);                                                                \
    __attribute__((constructor)) static void register_##name(void)                                 \
    {                                                                                              \
        static struct unit_test test = {{#name, name, NULL, NULL, NULL}, __COUNTER__, NULL};       \
        unit_add(&test);                                                                           \
    }                                                                                              \
    static void name(void **state __attribute__((unused)))

/* Gives the functions that run before and after each test of the file; either may be NULL. */
#define EACH_TEST(set_up, tear_down) UNIT_FIXTURE(unit_each, set_up, tear_down)
/* Gives those that run before the first test of the file and after the last. */
#define ALL_TESTS(set_up, tear_down) UNIT_FIXTURE(unit_all, set_up, tear_down)

#define UNIT_FIXTURE(function, set_up, tear_down)                                                  \
    __attribute__((constructor)) static void function##_here(void)                                 \
    {                                                                                              \
        function(set_up, tear_down);                                                               \
    }                                                                                              \
    static void function##_here(void)
