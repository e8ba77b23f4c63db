/* Lines of the log: one line each, whatever the bytes; valid JSON at any length; never a wait. */
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "proto/log.h"
#include "tests/random.h"

static size_t one_field(enum log_format format, const char *key, const char *text,
                        char out[LOG_LINE_BYTES])
{
    const struct log_field field = {key, text, 0};
    return log_line(format, 1700000000042, LOG_WARNING, "what", NULL, &field, 1, out);
}

static void reads_in_text(void **state)
{
    (void)state;
    char line[LOG_LINE_BYTES + 1];
    const struct log_field fields[] = {{"job", "abc", 0},     {"none", "", 0},
                                       {"n", NULL, 3},        {"seconds", NULL, 0.25},
                                       {"path", "a b\"c", 0}, {"detail", "as it \x1b[31m is\n", 0}};
    line[log_line(LOG_TEXT, 1700000000042, LOG_INFO, "what", NULL, fields, 6, line)] = '\0';
    assert_string_equal(line, "2023-11-14T22:13:20.042Z info what job=abc n=3 seconds=0.25 "
                              "path=\"a b\\\"c\" as it \\u001b[31m is\\u000a\n");
}

static void reads_in_json(void **state)
{
    (void)state;
    char line[LOG_LINE_BYTES];
    struct trace_source source = {5};
    struct trace trace;
    trace_begin(&source, NULL, &trace);
    const struct log_field fields[] = {{"n", NULL, 3}, {"text", "\"\\\xff\xc3\xa9\t", 0}};
    const size_t n = log_line(LOG_JSON, 1700000000042, LOG_ERROR, "what", &trace, fields, 2, line);
    json_t *read = json_loadb(line, n, 0, NULL);
    assert_non_null(read);
    assert_string_equal(json_string_value(json_object_get(read, "time")),
                        "2023-11-14T22:13:20.042Z");
    assert_string_equal(json_string_value(json_object_get(read, "level")), "error");
    assert_string_equal(json_string_value(json_object_get(read, "request")), trace.request);
    assert_string_equal(json_string_value(json_object_get(read, "trace")), trace.id);
    assert_null(json_object_get(read, "parent"));
    assert_int_equal(json_integer_value(json_object_get(read, "n")), 3);
    assert_string_equal(json_string_value(json_object_get(read, "text")),
                        "\"\\\xef\xbf\xbd\xc3\xa9\t");
    json_decref(read);
}

/* Any bytes at all lengths around what fits. */
static void any_bytes(void **state)
{
    (void)state;
    static char text[2 * LOG_LINE_BYTES];
    char line[LOG_LINE_BYTES];
    struct random random = {11};
    for (int round = 0; round < 4000; round++) {
        const size_t length = LOG_LINE_BYTES / 8 + random_bits(&random) % (LOG_LINE_BYTES);
        const unsigned least = round % 2 ? 1 : 0x20, span = round % 2 ? 255 : 95;
        for (size_t i = 0; i < length; i++) text[i] = (char)(least + random_bits(&random) % span);
        text[length] = '\0';
        for (int format = LOG_TEXT; format <= LOG_JSON; format++) {
            const size_t n =
                one_field((enum log_format)format, round % 3 ? "detail" : "path", text, line);
            assert_in_range(n, 2, LOG_LINE_BYTES);
            assert_ptr_equal(memchr(line, '\n', n), line + n - 1);
            json_t *read = format == LOG_JSON ? json_loadb(line, n, 0, NULL) : NULL;
            assert_int_equal(read != NULL, format == LOG_JSON);
            json_decref(read);
        }
    }
}

static void many_fields(void **state)
{
    (void)state;
    char line[LOG_LINE_BYTES];
    struct log_field fields[512];
    for (size_t i = 0; i < 512; i++)
        fields[i] = (struct log_field){"some_name", i % 2 ? "text" : NULL, (double)i * 1e3 + 0.5};
    for (size_t count = 0; count <= 512; count++) {
        const size_t n = log_line(LOG_JSON, 0, LOG_INFO, "what", NULL, fields, count, line);
        json_t *read = json_loadb(line, n, 0, NULL);
        assert_non_null(read);
        json_decref(read);
    }
}

/* Nobody reads the pipe: lines are dropped, and the writer goes on. */
static void full_pipe(void **state)
{
    (void)state;
    int ends[2];
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    struct log log = {.fd = ends[1], .least = LOG_WARNING};
    for (int i = 0; i < 10000; i++) log_write(&log, LOG_WARNING, "what", NULL, NULL, 0);
    log_write(&log, LOG_INFO, "below the least", NULL, NULL, 0);
    assert_true(log.lines[LOG_WARNING] > 0 && log.dropped > 0);
    assert_int_equal(log.lines[LOG_WARNING] + log.dropped, 10000);
    assert_int_equal(log.lines[LOG_INFO], 0);
    close(ends[0]);
    close(ends[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_in_text), cmocka_unit_test(reads_in_json),
        cmocka_unit_test(any_bytes),     cmocka_unit_test(many_fields),
        cmocka_unit_test(full_pipe),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
