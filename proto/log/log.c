#include "proto/log/log.h"

#include <errno.h>
#include <poll.h>
#include <string.h>
#include <unistd.h>

#include "proto/log/log_writer.h"
#include "proto/runtime/clock.h"

static const char *const level_names[] = {"info", "warning", "error"};

bool log_format_from_name(const char *name, enum log_format *out)
{
    const bool json = !strcmp(name, "json");
    *out = json ? LOG_JSON : LOG_TEXT;
    return json || !strcmp(name, "text");
}

const char *log_format_name(enum log_format format)
{
    return format == LOG_JSON ? "json" : "text";
}

const char *log_level_name(enum log_level level)
{
    return level_names[level];
}

/* A slow reader of a pipe would hold the loop; one that has gone ends nothing here. */
static bool has_room(int fd)
{
    struct pollfd p = {.fd = fd, .events = POLLOUT};
    return poll(&p, 1, 0) == 1 && (p.revents & POLLOUT);
}

static bool write_whole(int fd, const char *line, size_t size_bytes)
{
    ssize_t n;
    if (!has_room(fd)) return false;
    do n = write(fd, line, size_bytes);
    while (n < 0 && errno == EINTR);
    return n == (ssize_t)size_bytes;
}

void log_begin(struct log *log)
{
    if (!log->writer) log->writer = log_writer_create(log->fd);
}

uint64_t log_lost(const struct log *log)
{
    return log->dropped + (log->writer ? log_writer_failed(log->writer) : 0);
}

static bool pass_on(struct log *log, const char *line, size_t size_bytes)
{
    if (log->fd < 0) return false;
    return log->writer ? log_writer_put(log->writer, line, size_bytes)
                       : write_whole(log->fd, line, size_bytes);
}

/* Writes how many lines are missing, if any. Returns false without room for that. */
static bool tell_lost(struct log *log, int64_t at_ms)
{
    char line[LOG_LINE_BYTES];
    const uint64_t lost = log_lost(log);
    const struct log_field field = {"lines", NULL, (double)(lost - log->told)};
    if (lost == log->told) return true;
    const size_t n = log_line(log->format, at_ms, LOG_WARNING, "lines of the log were lost", NULL,
                              &field, 1, line);
    if (!pass_on(log, line, n)) return false;
    log->lines[LOG_WARNING]++;
    log->told = lost;
    return true;
}

static int64_t now_ms(void)
{
    return (int64_t)(clock_us(CLOCK_REALTIME) / 1000);
}

void log_end(struct log *log)
{
    if (!log->writer) return;
    (void)tell_lost(log, now_ms());
    const uint64_t failed = log_writer_failed(log->writer);
    if (!log_writer_close(&log->writer, LOG_END_MS)) log->fd = -1;
    log->dropped += failed;
}

void log_write(struct log *log, enum log_level level, const char *what,
               const struct trace_context *trace, const struct log_field *fields, size_t count)
{
    char line[LOG_LINE_BYTES];
    if (!log || level < log->least) return;
    const int64_t at_ms = now_ms();
    const size_t n = log_line(log->format, at_ms, level, what, trace, fields, count, line);
    if (tell_lost(log, at_ms) && pass_on(log, line, n))
        log->lines[level]++;
    else
        log->dropped++;
}
