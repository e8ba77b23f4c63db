#pragma once
/* The log of a server or a worker: one line a fact, for people (TEXT: time level what key=value...)
 * or for programs (JSON: one object a line). Whatever bytes a value has, a line stays one line.
 *
 * Nobody waits for who reads it, nor for a disk that hangs: from log_begin to log_end a thread
 * writes the lines (log_writer.h). Those that there is no room for, or that could not be written,
 * are counted, and a line says how many they were as soon as there is room. For the loop's thread.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/log/trace_context.h"

struct log_writer;

#define LOG_END_MS     2000
#define LOG_LINE_BYTES 4096 /* PIPE_BUF: written whole or not at all */

enum log_format { LOG_TEXT, LOG_JSON };
enum log_level { LOG_INFO, LOG_WARNING, LOG_ERROR };

struct log {
    int fd;
    enum log_format format;
    enum log_level least;          /* what is below is not written */
    uint64_t lines[LOG_ERROR + 1]; /* written, by level */
    uint64_t dropped;              /* there was no room for */
    uint64_t told;                 /* of those that were lost: a line says so */
    struct log_writer *writer;     /* owned; NULL: lines are written at once */
};

struct log_field {
    const char *key;  /* "detail": in text without its key, and bare */
    const char *text; /* NULL: the number */
    double number;
};

/* "text" and "json". */
bool log_format_from_name(const char *name, enum log_format *out);
const char *log_format_name(enum log_format format);
const char *log_level_name(enum log_level level);

/* From here on a thread writes the lines; without one (no memory) they are written as before. */
void log_begin(struct log *log);
/* What waits is written, for at most LOG_END_MS; then lines are written at once again, but none if
 * even that was too short: a process that ends must not hang. */
void log_end(struct log *log);

/* Lines that nobody will read: there was no room, or they could not be written. */
uint64_t log_lost(const struct log *log);

/* trace may be NULL; log, too: nothing is written. Fields whose text is "" are left out. What is
 * too long is cut short. */
void log_write(struct log *log, enum log_level level, const char *what,
               const struct trace_context *trace, const struct log_field *fields, size_t count);

/* The line, with its '\n'; returns its size. at_ms: since 1970. */
size_t log_line(enum log_format format, int64_t at_ms, enum log_level level, const char *what,
                const struct trace_context *trace, const struct log_field *fields, size_t count,
                char out[LOG_LINE_BYTES]);
