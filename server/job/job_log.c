#include "server/job/job_log.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "proto/limits.h"

json_t *time_json(int64_t time_ms)
{
    char text[48];
    struct tm parts;
    time_t seconds = (time_t)(time_ms / 1000);
    if (!gmtime_r(&seconds, &parts)) return json_null();
    size_t n = strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
    snprintf(text + n, sizeof text - n, ".%03dZ", (int)(time_ms % 1000));
    return json_string(text);
}

static bool says(const json_t *line, const char *what, const char *text)
{
    const char *its_what = json_string_value(json_object_get(line, "what"));
    const char *its_text = json_string_value(json_object_get(line, "text"));
    return its_what && its_text && !strcmp(its_what, what) && !strcmp(its_text, text);
}

/* Counts a line that repeats. */
static void count_again(json_t *line, int64_t time_ms)
{
    json_int_t times = json_integer_value(json_object_get(line, "times"));
    json_object_set_new(line, "times", json_integer(times + 1));
    json_object_set_new(line, "until", time_json(time_ms));
}

/* The line after the beginning says how many are missing there. */
static void make_room(json_t *log)
{
    json_t *gap = json_array_get(log, LOG_BEGINNING);
    if (!says(gap, "omitted", "lines are left out here")) {
        json_object_set_new(gap, "what", json_string("omitted"));
        json_object_set_new(gap, "text", json_string("lines are left out here"));
        json_object_set_new(gap, "times", json_integer(1));
    }
    json_t *next = json_incref(json_array_get(log, LOG_BEGINNING + 1));
    json_int_t times = json_integer_value(json_object_get(gap, "times"));
    json_object_set_new(gap, "times", json_integer(times + 1));
    json_object_set(gap, "until", json_object_get(next, "time"));
    json_array_remove(log, LOG_BEGINNING + 1);
    json_decref(next);
}

/* Bytes that a character of UTF-8 with this first byte has. */
static size_t character_bytes(unsigned char first)
{
    return first < 0xc0 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
}

/* Takes off a character at the end whose last bytes were cut off. */
static void trim_part(char *text)
{
    const size_t size = strlen(text);
    size_t at = size;
    while (at > 0 && size - at < 3 && ((unsigned char)text[at - 1] & 0xc0) == 0x80) at--;
    if (at > 0 && at - 1 + character_bytes((unsigned char)text[at - 1]) > size) text[at - 1] = '\0';
}

void job_log_add(json_t **log, int64_t time_ms, const char *what, const char *format, ...)
{
    char text[LIMIT_DETAIL_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    trim_part(text);
    if (!*log) *log = json_array();
    size_t count = json_array_size(*log);
    json_t *last = count > 0 ? json_array_get(*log, count - 1) : NULL;
    if (last && says(last, what, text)) {
        count_again(last, time_ms);
        return;
    }
    if (count >= LIMIT_LOG_LINES) make_room(*log);
    json_t *line = json_pack("{s:o,s:s,s:s,s:i,s:n}", "time", time_json(time_ms), "what", what,
                             "text", text, "times", 1, "until");
    if (line) json_array_append_new(*log, line);
}

static bool is_line(const json_t *line)
{
    return json_is_string(json_object_get(line, "time")) &&
           json_is_string(json_object_get(line, "what")) &&
           json_is_string(json_object_get(line, "text")) &&
           json_is_integer(json_object_get(line, "times"));
}

json_t *job_log_read(const json_t *report)
{
    size_t i;
    json_t *line;
    json_t *log = json_object_get(report, "log");
    if (!json_is_array(log) || json_array_size(log) > LIMIT_LOG_LINES) return NULL;
    json_array_foreach (log, i, line)
        if (!is_line(line)) return NULL;
    return json_incref(log);
}
