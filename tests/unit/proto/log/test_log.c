/* Lines of the log: one line each, whatever the bytes; valid JSON at any length; never a wait. */
#include <fcntl.h>
#include <jansson.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "proto/log/log.h"
#include "tests/random.h"
#include "tests/unit/unit.h"

static size_t one_field(enum log_format format, const char *key, const char *text,
                        char out[LOG_LINE_BYTES])
{
    const struct log_field field = {key, text, 0};
    return log_line(format, 1700000000042, LOG_WARNING, "what", NULL, &field, 1, out);
}

ALL_TESTS(ignore_broken_pipes, NULL);

TEST(reads_in_text)
{
    char line[LOG_LINE_BYTES + 1];
    const struct log_field fields[] = {{"job", "abc", 0},     {"none", "", 0},
                                       {"n", NULL, 3},        {"seconds", NULL, 0.25},
                                       {"path", "a b\"c", 0}, {"detail", "as it \x1b[31m is\n", 0}};
    line[log_line(LOG_TEXT, 1700000000042, LOG_INFO, "what", NULL, fields, 6, line)] = '\0';
    assert_string_equal(line, "2023-11-14T22:13:20.042Z info what job=abc n=3 seconds=0.25 "
                              "path=\"a b\\\"c\" as it \\u001b[31m is\\u000a\n");
}

TEST(reads_in_json)
{
    char line[LOG_LINE_BYTES];
    struct trace_context_source source = {5};
    struct trace_context trace;
    trace_context_begin(&source, NULL, &trace);
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
TEST(any_bytes)
{
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

TEST(many_fields)
{
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
TEST(full_pipe)
{
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

enum { LINES = 20000 };

static void tell_number(struct log *log, int number)
{
    const struct log_field field = {"n", NULL, number};
    log_write(log, LOG_INFO, "what", NULL, &field, 1);
}

/* Reads lines until the other end is closed: their numbers grow by one but where it is said that so
 * many are missing. Returns how many there are, and the number of those that are not. */
static int read_numbers(int fd, double *lost)
{
    FILE *in = fdopen(fd, "r");
    char line[LOG_LINE_BYTES];
    int count = 0, next = 0;
    assert_non_null(in);
    *lost = 0;
    while (fgets(line, sizeof line, in)) {
        json_t *read = json_loads(line, 0, NULL);
        assert_non_null(read);
        const json_t *lines = json_object_get(read, "lines");
        if (lines) {
            next += (int)json_number_value(lines);
            *lost += json_number_value(lines);
        } else {
            assert_int_equal(json_integer_value(json_object_get(read, "n")), next);
            next++;
            count++;
        }
        json_decref(read);
    }
    fclose(in);
    return count;
}

struct reading {
    int fd, count;
    double lost;
};

static void *read_on(void *ctx)
{
    struct reading *r = ctx;
    r->count = read_numbers(r->fd, &r->lost);
    return NULL;
}

/* Somebody reads, and there is time: all lines are there, in order. */
TEST(all_lines)
{
    int ends[2];
    pthread_t reader;
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    struct reading r = {.fd = ends[0]};
    struct log log = {.fd = ends[1], .format = LOG_JSON};
    assert_int_equal(pthread_create(&reader, NULL, read_on, &r), 0);
    log_begin(&log);
    for (int i = 0; i < LINES; i++) {
        tell_number(&log, i);
        if (i % 500 == 499) usleep(20000);
    }
    log_end(&log);
    close(ends[1]);
    pthread_join(reader, NULL);
    assert_int_equal(log.lines[LOG_INFO], LINES);
    assert_int_equal(r.count, LINES);
    assert_int_equal(log_lost(&log), 0);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Nobody reads for a while: who tells goes on, and what is missing is told where it is missing. */
TEST(lost_lines)
{
    int ends[2];
    pthread_t reader;
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    struct reading r = {.fd = ends[0]};
    struct log log = {.fd = ends[1], .format = LOG_JSON};
    log_begin(&log);
    const double begun_s = seconds();
    for (int i = 0; i < LINES; i++) tell_number(&log, i);
    assert_true(seconds() - begun_s < 5);
    assert_true(log.dropped > 0 && log.dropped < LINES);
    assert_int_equal(pthread_create(&reader, NULL, read_on, &r), 0);
    usleep(300000);
    for (int i = LINES; i < LINES + 10; i++) tell_number(&log, i);
    log_end(&log);
    close(ends[1]);
    pthread_join(reader, NULL);
    assert_true(log.lines[LOG_WARNING] >= 1);
    assert_true(r.lost == (double)log.dropped);
    assert_true(r.count + r.lost == LINES + 10);
}

/* Nobody ever reads: the end comes all the same, and nothing is written behind it. */
TEST(unread_at_the_end)
{
    int ends[2];
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    struct log log = {.fd = ends[1], .format = LOG_JSON};
    log_begin(&log);
    for (int i = 0; i < LINES; i++) tell_number(&log, i);
    const double begun_s = seconds();
    log_end(&log);
    const double took_s = seconds() - begun_s;
    assert_true(took_s > 1e-3 * LOG_END_MS - 0.1 && took_s < 1e-3 * LOG_END_MS + 5);
    const uint64_t dropped = log.dropped;
    tell_number(&log, LINES);
    assert_int_equal(log.dropped, dropped + 1);
    close(ends[0]); /* which lets the thread go on, fail, and go */
    usleep(500000);
}

/* A full disk: what there is room for waits until somebody has made some. */
TEST(full_disk)
{
    int ends[2];
    const int fd = open("/dev/full", O_WRONLY | O_CLOEXEC);
    struct reading r = {0};
    assert_true(fd >= 0);
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    struct log log = {.fd = fd, .format = LOG_JSON};
    log_begin(&log);
    for (int i = 0; i < LINES; i++) tell_number(&log, i);
    assert_true(log.dropped > 0 && log.lines[LOG_INFO] > 0);
    pthread_t reader;
    r.fd = ends[0];
    assert_int_equal(pthread_create(&reader, NULL, read_on, &r), 0);
    assert_int_equal(dup3(ends[1], fd, O_CLOEXEC), fd);
    close(ends[1]);
    usleep(500000);
    tell_number(&log, LINES);
    log_end(&log);
    close(fd);
    pthread_join(reader, NULL);
    assert_true(r.lost == (double)log.dropped && r.count + r.lost == LINES + 1);
}

/* Who read has gone: lines are counted, and nothing waits. */
TEST(gone_reader)
{
    int ends[2];
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    struct log log = {.fd = ends[1], .format = LOG_JSON};
    close(ends[0]);
    log_begin(&log);
    for (int i = 0; i < 100; i++) tell_number(&log, i);
    for (int i = 0; i < 500 && log_lost(&log) < 100; i++) usleep(10000);
    assert_true(log_lost(&log) >= 100);
    log_end(&log);
    close(ends[1]);
}
