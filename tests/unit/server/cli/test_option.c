/* The option parser: values, limits, help, wrong usage. */
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "server/cli/option.h"
#include "tests/unit/unit.h"

static bool quiet;
static const char *out;
static long count;

static const struct option_line lines[] = {
    {"quiet", 'q', OPTION_FLAG, NULL, "say nothing", 0, 0, &quiet},
    {"out", 'o', OPTION_TEXT, "FILE", "where to", 0, 0, &out},
    {"count", 0, OPTION_NUMBER, "N", "how many", 1, 64, &count},
};
static const struct option_table table = {"test FILE [options]", "Tests.", lines, 3, 1, 2};

/* Parses words with both outputs shut, so that the test's own stay readable. */
static int parse(char **words, int *arguments)
{
    int argc = 0, saved[2] = {dup(1), dup(2)}, null = open("/dev/null", O_WRONLY);
    while (words[argc]) argc++;
    quiet = false;
    out = NULL;
    count = 5;
    fflush(stdout);
    dup2(null, 1);
    dup2(null, 2);
    int status = option_parse(&table, argc, words, arguments);
    fflush(stdout);
    for (int i = 0; i < 2; i++) {
        dup2(saved[i], i + 1);
        close(saved[i]);
    }
    close(null);
    return status;
}
#define PARSE(...) parse((char *[]){(char *)"test", __VA_ARGS__, NULL}, &arguments)

TEST(takes_options_anywhere)
{
    int arguments = 0;
    char *words[] = {"test", "a.json", "-o", "x.exr", "--count=7", "b.json", "-q", NULL};
    assert_int_equal(parse(words, &arguments), OPTION_GO_ON);
    assert_int_equal(arguments, 2);
    assert_string_equal(words[1], "a.json");
    assert_string_equal(words[2], "b.json");
    assert_true(quiet);
    assert_string_equal(out, "x.exr");
    assert_int_equal(count, 7);
}

TEST(refuses_wrong_usage)
{
    int arguments = 0;
    assert_int_equal(PARSE("a", "--count", "65"), 2);
    assert_int_equal(PARSE("a", "--count", "0"), 2);
    assert_int_equal(PARSE("a", "--count", "7x"), 2);
    assert_int_equal(PARSE("a", "--count", "99999999999999999999"), 2);
    assert_int_equal(PARSE("a", "--count", ""), 2);
    assert_int_equal(PARSE("a", "--out", ""), 2);
    assert_int_equal(PARSE("a", "--out"), 2);
    assert_int_equal(PARSE("a", "--nonsense"), 2);
    assert_int_equal(PARSE("a", "-z"), 2);
    assert_int_equal(PARSE("-q"), 2);
    assert_int_equal(PARSE("a", "b", "c"), 2);
}

TEST(helps_and_ends_options)
{
    int arguments = 0;
    assert_int_equal(PARSE("--help"), 0);
    assert_int_equal(PARSE("--", "--help"), OPTION_GO_ON);
    assert_int_equal(arguments, 1);
}
