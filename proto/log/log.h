#pragma once
/* The log of a server or a worker. A line is one event, for users (TEXT: time level what
 * key=value...) or for programs (JSON: one object). It stays one line whatever bytes a value has.
 *
 * From log_begin to log_end a thread writes the lines (log_writer.h), so that the loop waits for no
 * slow reader and no hanging disk. Lines without room, and those that could not be written, are
 * counted; a line tells their number as soon as there is room. For the loop's thread. */
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
    enum log_level least;          /* lower levels are not written */
    uint64_t lines[LOG_ERROR + 1]; /* written, by level */
    uint64_t dropped;              /* for want of room */
    uint64_t told;                 /* lost lines that a line has reported */
    struct log_writer *writer;     /* owned; NULL: lines are written at once */
};

struct log_field {
    const char *key;  /* "detail": in text without its key, and bare */
    const char *text; /* NULL: the number */
    double number;
};

/* Read and return names: "text" and "json", and those of levels. */
bool log_format_from_name(const char *name, enum log_format *out);
const char *log_format_name(enum log_format format);
const char *log_level_name(enum log_level level);

/* Starts the thread that writes the lines. Without memory for it they are written at once. */
void log_begin(struct log *log);
/* Writes the waiting lines, for at most LOG_END_MS. Later lines are written at once, or, if that
 * time was too short, not at all: a process that ends must not hang. */
void log_end(struct log *log);

/* Returns the number of lost lines: those without room, and those that could not be written. */
uint64_t log_lost(const struct log *log);

/* Writes a line. `trace` may be NULL. A NULL log writes nothing. Fields whose text is "" are left
 * out, and long texts are cut. */
void log_write(struct log *log, enum log_level level, const char *what,
               const struct trace_context *trace, const struct log_field *fields, size_t count);

/* Formats a line with its '\n' and returns its size. at_ms counts from 1970. */
size_t log_line(enum log_format format, int64_t at_ms, enum log_level level, const char *what,
                const struct trace_context *trace, const struct log_field *fields, size_t count,
                char out[LOG_LINE_BYTES]);
