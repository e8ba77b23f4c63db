/* Texts of JSON values. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "proto/json.h"

/* Finds no memory for the n-th piece that is asked for. */
static unsigned until_failure;

static void *fail_once(size_t size)
{
    return until_failure > 0 && --until_failure == 0 ? NULL : malloc(size);
}

static json_t *document(void)
{
    return json_pack("{s:s, s:[f, i, b, n], s:{s:s}, s:I}", "b", "a \"quote\" and \n", "list", 0.25,
                     -7, 1, "inner", "key", "\xc3\xa9", "a", (json_int_t)1 << 60);
}

static void a_text_is_jansson_s(void **state)
{
    (void)state;
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
static void without_memory_there_is_no_text_rather_than_half_of_one(void **state)
{
    (void)state;
    json_t *value = document();
    char *whole = json_text(value, JSON_COMPACT | JSON_SORT_KEYS);
    unsigned failed = 0, k = 0;
    json_set_alloc_funcs(fail_once, free);
    do {
        until_failure = ++k;
        char *text = json_text(value, JSON_COMPACT | JSON_SORT_KEYS);
        if (text) assert_string_equal(text, whole);
        failed += !text;
        free(text);
    } while (until_failure == 0);
    json_set_alloc_funcs(malloc, free);
    assert_in_range(failed, 1, k - 1);
    free(whole);
    json_decref(value);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_is_jansson_s),
        cmocka_unit_test(without_memory_there_is_no_text_rather_than_half_of_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
