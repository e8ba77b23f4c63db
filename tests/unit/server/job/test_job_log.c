/* A job's log: lines with times, the same said again, bounds, what is read back. */
#include <stdio.h>
#include <string.h>

#include "proto/limits.h"
#include "server/job/job_log.h"
#include "tests/unit/unit.h"

static const char *text_of(const json_t *log, size_t at, const char *member)
{
    return json_string_value(json_object_get(json_array_get(log, at), member));
}

static json_int_t times_of(const json_t *log, size_t at)
{
    return json_integer_value(json_object_get(json_array_get(log, at), "times"));
}

TEST(times_are_written_as_rfc_3339)
{
    json_t *time = time_json(1762732800007);
    assert_string_equal(json_string_value(time), "2025-11-10T00:00:00.007Z");
    json_decref(time);
}

TEST(lines_keep_their_order)
{
    json_t *log = NULL;
    job_log_add(&log, 0, "state", "submitted");
    job_log_add(&log, 1500, "frame", "frame %d is begun", 7);
    assert_int_equal(json_array_size(log), 2);
    assert_string_equal(text_of(log, 0, "time"), "1970-01-01T00:00:00.000Z");
    assert_string_equal(text_of(log, 1, "time"), "1970-01-01T00:00:01.500Z");
    assert_string_equal(text_of(log, 1, "what"), "frame");
    assert_string_equal(text_of(log, 1, "text"), "frame 7 is begun");
    json_decref(log);
}

TEST(the_same_again_is_counted)
{
    json_t *log = NULL;
    for (int i = 0; i < 5; i++) job_log_add(&log, 1000 * i, "worker", "a has left");
    job_log_add(&log, 9000, "worker", "b has left");
    job_log_add(&log, 9500, "tiles", "b has left");
    assert_int_equal(json_array_size(log), 3);
    assert_int_equal(times_of(log, 0), 5);
    assert_string_equal(text_of(log, 0, "time"), "1970-01-01T00:00:00.000Z");
    assert_string_equal(text_of(log, 0, "until"), "1970-01-01T00:00:04.000Z");
    assert_int_equal(times_of(log, 1), 1);
    assert_true(json_is_null(json_object_get(json_array_get(log, 1), "until")));
    json_decref(log);
}

TEST(of_very_many_the_middle_goes)
{
    json_t *log = NULL;
    const int all = 3 * LIMIT_LOG_LINES;
    for (int i = 0; i < all; i++) job_log_add(&log, i, "tiles", "line %d", i);
    assert_int_equal(json_array_size(log), LIMIT_LOG_LINES);
    assert_string_equal(text_of(log, LOG_BEGINNING - 1, "text"), "line 19");
    assert_string_equal(text_of(log, LOG_BEGINNING, "what"), "omitted");
    /* Every line is there or counted. */
    assert_int_equal(times_of(log, LOG_BEGINNING), all - (LIMIT_LOG_LINES - 1));
    char first[32];
    snprintf(first, sizeof first, "line %d", all - (LIMIT_LOG_LINES - 1 - LOG_BEGINNING));
    assert_string_equal(text_of(log, LOG_BEGINNING + 1, "text"), first);
    snprintf(first, sizeof first, "line %d", all - 1);
    assert_string_equal(text_of(log, LIMIT_LOG_LINES - 1, "text"), first);
    json_decref(log);
}

TEST(bytes_that_are_no_text_are_left_out)
{
    json_t *log = NULL;
    job_log_add(&log, 0, "worker", "%s has left", "\xff\xfe");
    assert_int_equal(json_array_size(log), 0);
    job_log_add(&log, 0, "worker", "%s has left", "a");
    assert_int_equal(json_array_size(log), 1);
    json_decref(log);
}

/* Wherever text is cut, by its writer or by the bound, whole characters stay. */
TEST(text_is_cut_between_characters)
{
    static const char text[] = "a\u00e9\u20ac\U0001f426"; /* 1, 2, 3 and 4 bytes */
    static const int whole[] = {0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10};
    char padding[LIMIT_DETAIL_BYTES] = "";
    for (int bytes = 0; bytes <= 10; bytes++) {
        json_t *log = NULL;
        job_log_add(&log, 0, "tiles", "%.*s", bytes, text);
        assert_int_equal(json_array_size(log), 1);
        assert_int_equal(strlen(text_of(log, 0, "text")), whole[bytes]);
        memset(padding, '.', sizeof padding - 1 - (size_t)bytes);
        padding[sizeof padding - 1 - (size_t)bytes] = '\0';
        job_log_add(&log, 0, "tiles", "%s%s", padding, text);
        assert_int_equal(json_array_size(log), 2);
        assert_int_equal(strlen(text_of(log, 1, "text")),
                         sizeof padding - 1 - (size_t)(bytes - whole[bytes]));
        json_decref(log);
    }
}

TEST(a_stored_log_is_checked)
{
    json_t *log = NULL;
    job_log_add(&log, 0, "state", "submitted");
    json_t *report = json_pack("{s:O}", "log", log);
    json_t *back = job_log_read(report);
    assert_true(json_equal(log, back));
    json_decref(back);
    json_array_append_new(log, json_string("no line"));
    assert_null(job_log_read(report));
    json_object_set_new(report, "log", json_object());
    assert_null(job_log_read(report));
    assert_null(job_log_read(NULL));
    json_decref(report);
    json_decref(log);
}
