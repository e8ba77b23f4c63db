#pragma once
/* The thread that writes a log's lines, so that the caller waits for no hanging disk and no full
 * pipe. Lines wait in LOG_BUFFER_BYTES of memory and are written in their order. Each write has
 * whole lines of at most PIPE_BUF bytes, so that other writers of the same pipe cannot split a
 * line. While a disk is full or fails, a write is retried. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LOG_BUFFER_BYTES 262144u

struct log_writer;

/* Starts a writer. The descriptor is borrowed until the writer is closed. NULL without memory or
 * without a thread. */
struct log_writer *log_writer_create(int fd);

/* Takes a line of at most LOG_LINE_BYTES with its '\n'. False: there is no room for it. For one
 * thread at a time. */
bool log_writer_put(struct log_writer *w, const char *line, size_t size_bytes);

/* Returns the number of lines taken so far that can never be written, since their reader is gone.
 */
uint64_t log_writer_failed(struct log_writer *w);

/* Waits until all lines are written, for at most most_ms, and frees the writer. False: the time was
 * too short; the writer goes on and frees itself. Nulls the pointer. */
bool log_writer_close(struct log_writer **w, unsigned most_ms);
