#pragma once
/* The log of one job, for people: [{time, what, text, times, until}], oldest first. `what` sorts
 * the lines: "state", "frame", "tiles", "worker", "warning", "error", "omitted".
 *
 * It is bounded. A text that repeats is one line with a count, and of more than LIMIT_LOG_LINES
 * lines the first LOG_BEGINNING and the latest stay. It is kept with the job's report, so it is
 * durable when the job changes its state or a frame ends, at the latest. */
#include <jansson.h>
#include <stdint.h>

#define LOG_SUBMITTED "submitted" /* the first line of every log */
#define LOG_BEGINNING 20          /* lines: the beginning explains most of what follows */

/* Writes a moment as RFC 3339, UTC, with milliseconds; null for times outside the calendar. New
 * reference. */
json_t *time_json(int64_t time_ms);

/* Adds a line to *log, which is created when it is NULL. Without memory the line is lost: no job
 * fails for want of its log. A character that is cut at the end is left out; a text that is not
 * UTF-8 is lost. */
void job_log_add(json_t **log, int64_t time_ms, const char *what, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Returns the log of a report that was read back, checked like all input; NULL when there is none.
 * New reference. */
json_t *job_log_read(const json_t *report);
