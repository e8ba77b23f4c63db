#include "proto/log.h"

#include <errno.h>
#include <poll.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

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

void log_write(struct log *log, enum log_level level, const char *what, const struct trace *trace,
               const struct log_field *fields, size_t count)
{
    char line[LOG_LINE_BYTES];
    struct timespec now;
    if (!log || level < log->least) return;
    clock_gettime(CLOCK_REALTIME, &now);
    const int64_t at_ms = (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
    const size_t n = log_line(log->format, at_ms, level, what, trace, fields, count, line);
    if (write_whole(log->fd, line, n))
        log->lines[level]++;
    else
        log->dropped++;
}
