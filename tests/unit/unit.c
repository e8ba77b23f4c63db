/* The list of a program's tests, and its main(). */
#include "tests/unit/unit.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static struct {
    struct unit_test *first;
    size_t count;
    CMFixtureFunction each_set_up, each_tear_down, all_set_up, all_tear_down;
} unit;

/* Adds a test at its place: the order in which constructors run is the compiler's. */
void unit_add(struct unit_test *test)
{
    struct unit_test **at = &unit.first;
    while (*at && (*at)->place <= test->place) at = &(*at)->next;
    test->next = *at;
    *at = test;
    unit.count++;
}

void unit_each(CMFixtureFunction set_up, CMFixtureFunction tear_down)
{
    unit.each_set_up = set_up;
    unit.each_tear_down = tear_down;
}

void unit_all(CMFixtureFunction set_up, CMFixtureFunction tear_down)
{
    unit.all_set_up = set_up;
    unit.all_tear_down = tear_down;
}

void scene_path(const char *name, char path[UNIT_PATH_BYTES])
{
    const char *folder = getenv("SHEARWATER_SCENES");
    snprintf(path, UNIT_PATH_BYTES, "%s/%s", folder ? folder : "scenes", name);
    if (access(path, R_OK) != 0) skip();
}

int ignore_broken_pipes(void **state)
{
    (void)state;
    return signal(SIGPIPE, SIG_IGN) == SIG_ERR;
}

int unit_run(const char *group)
{
    struct CMUnitTest *tests = calloc(unit.count + 1, sizeof *tests);
    if (!tests || unit.count == 0) {
        fprintf(stderr, "%s: %s\n", group, tests ? "no test is registered" : strerror(ENOMEM));
        free(tests);
        return 1;
    }
    size_t count = 0;
    for (const struct unit_test *t = unit.first; t; t = t->next) {
        tests[count] = t->test;
        tests[count].setup_func = unit.each_set_up;
        tests[count++].teardown_func = unit.each_tear_down;
    }
    const int failed =
        _cmocka_run_group_tests(group, tests, count, unit.all_set_up, unit.all_tear_down);
    free(tests);
    return failed;
}

/* Is weak, so that a program may have a main() of its own. */
__attribute__((weak)) int main(void)
{
    const char *name = program_invocation_short_name, *prefix = "test_";
    const size_t length = strlen(prefix);
    return unit_run(strncmp(name, prefix, length) == 0 ? name + length : name);
}
