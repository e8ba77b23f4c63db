#pragma once
/* The thread that writes a log's lines, so that nobody who tells something waits for a disk that
 * hangs or for a pipe that nobody reads. Lines wait in LOG_BUFFER_BYTES of memory and are written
 * in their order, whole lines in pieces of at most PIPE_BUF: what others write to the same pipe
 * comes between lines, never into one. While a disk is full or fails a piece is tried again and
 * again. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LOG_BUFFER_BYTES 262144u

struct log_writer;

/* The descriptor is borrowed until the writer is closed. NULL on failed allocation, or without a
 * thread. */
struct log_writer *log_writer_create(int fd);

/* Takes a line, with its '\n', of at most LOG_LINE_BYTES. False: there is no room, and nothing was
 * taken. Of one thread at a time. */
bool log_writer_put(struct log_writer *w, const char *line, size_t size_bytes);

/* Lines that were taken and never can be written (who read them has gone), so far. */
uint64_t log_writer_failed(struct log_writer *w);

/* Waits until all lines are written, for at most so long, and frees the writer. False: it was not
 * done by then; it is left to write on, and frees itself. Nulls the pointer. */
bool log_writer_close(struct log_writer **w, unsigned most_ms);
