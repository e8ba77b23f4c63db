/* Texts of JSON values, and what is read and written while memory is missing. */
#include <stdlib.h>

#include "proto/json.h"
#include "tests/unit/proto/json_memory.h"
#include "tests/unit/unit.h"

static json_t *document(void)
{
    return json_pack("{s:s, s:[f, i, b, n], s:{s:s}, s:I}", "b", "a \"quote\" and \n", "list", 0.25,
                     -7, 1, "inner", "key", "\xc3\xa9", "a", (json_int_t)1 << 60);
}

ALL_TESTS(fail_when_told, fail_no_more);

TEST(a_text_is_jansson_s)
{
    static const size_t flags[] = {JSON_COMPACT, JSON_INDENT(2), JSON_COMPACT | JSON_SORT_KEYS,
                                   JSON_COMPACT | JSON_REAL_PRECISION(6)};
    json_t *value = document();
    for (size_t i = 0; i < sizeof flags / sizeof flags[0]; i++) {
        char *text = json_text(value, flags[i]), *same = json_dumps(value, flags[i]);
        assert_string_equal(text, same);
        free(text);
        free(same);
    }
    json_decref(value);
    assert_null(json_text(NULL, JSON_COMPACT));
}

/* json_dumps gives texts without a quote here and there. */
TEST(without_memory_there_is_no_text_rather_than_half_of_one)
{
    json_t *value = document();
    char *whole = json_text(value, JSON_COMPACT | JSON_SORT_KEYS);
    unsigned failed = 0, k = 0;
    do {
        until_failure = ++k;
        char *text = json_text(value, JSON_COMPACT | JSON_SORT_KEYS);
        if (text) assert_string_equal(text, whole);
        failed += !text;
        free(text);
    } while (until_failure == 0);
    assert_in_range(failed, 1, k - 1);
    free(whole);
    json_decref(value);
}

/* jansson gives strings of which bytes are missing. */
TEST(without_memory_nothing_is_read_rather_than_a_part)
{
    static const char text[] =
        "{\"asset\":\"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\","
        "\"a name that is a long one, too, of more than thirty bytes\":[1.25,-7,true,null,\"x\"],"
        "\"number\":1234567890123456789}";
    json_t *value = NULL;
    struct fault fault = {0};
    unsigned k = 1;
    for (until_failure = k; json_read(text, sizeof text - 1, sizeof text, &value, &fault) != 0;
         until_failure = ++k) {
        assert_int_equal(until_failure, 0);
        assert_int_equal(fault.code, ERR_MEMORY);
        assert_null(value);
    }
    assert_in_range(until_failure, 1, k);
    assert_true(k > 10);
    until_failure = 0;
    char *same = json_text(value, JSON_COMPACT);
    assert_string_equal(same, text);
    free(same);
    json_decref(value);
}

TEST(so_is_what_another_program_wrote)
{
    static const char text[] = "[\"a string that is a long one, of more than thirty bytes\",7]";
    json_t *value = NULL;
    unsigned k = 1;
    for (until_failure = k; json_read_foreign(text, sizeof text - 1, &value) != 0;
         until_failure = ++k) {
        assert_int_equal(until_failure, 0);
        assert_null(value);
    }
    assert_true(k > 5);
    until_failure = 0;
    char *same = json_text(value, JSON_COMPACT);
    assert_string_equal(same, text);
    free(same);
    json_decref(value);
    assert_int_equal(json_read_foreign("[1", 2, &value), ERR_SYNTAX);
    assert_null(value);
    assert_int_equal(json_read_foreign("", 0, &value), ERR_SYNTAX);
    assert_int_equal(json_read_foreign("{\"a\":1,\"a\":2}", 13, &value), ERR_SYNTAX);
    assert_int_equal(json_read_foreign("12345678901234567890", 20, &value), ERR_RANGE);
    assert_int_equal(json_read_foreign("7", 1, &value), 0);
    json_decref(value);
}

TEST(what_lacks_a_member_has_no_text_and_the_next_one_has)
{
    json_t *value = json_object();
    until_failure = 1;
    json_object_set_new(value, "a", json_integer(1));
    assert_null(json_text(value, JSON_COMPACT));
    json_object_set_new(value, "a", json_integer(1));
    char *text = json_text(value, JSON_COMPACT);
    assert_string_equal(text, "{\"a\":1}");
    free(text);
    json_decref(value);
}

/* What was read in between neither hides what is missing nor is it blamed. */
TEST(reading_leaves_what_is_missing_of_a_text)
{
    json_t *value = json_object(), *other;
    until_failure = 1;
    json_object_set_new(value, "a", json_integer(1));
    assert_int_equal(json_read("{}", 2, 2, &other, NULL), 0);
    json_decref(other);
    assert_null(json_text(value, JSON_COMPACT));
    until_failure = 1;
    assert_int_equal(json_read("{}", 2, 2, &other, NULL), ERR_MEMORY);
    char *text = json_text(value, JSON_COMPACT);
    assert_string_equal(text, "{}");
    free(text);
    json_decref(value);
}
