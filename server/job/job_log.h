#pragma once
/* What happened to a job, and when: lines for people, [{time, what, text, times, until}], oldest
 * first. `what` sorts them: "state", "frame", "tiles", "worker", "warning", "error", "omitted".
 *
 * Bounded: the same said again and again is one line with a count, and of more than LIMIT_LOG_LINES
 * the first LOG_BEGINNING and the latest stay. The log is kept with the job's report, so it is as
 * durable as that: at the latest when the job changes its state or a frame ends. */
#include <jansson.h>
#include <stdint.h>

#define LOG_SUBMITTED "submitted" /* the first line of every log */
#define LOG_BEGINNING 20          /* lines: how a job began explains most of what follows */

/* A moment as the contract writes it, here and of jobs: RFC 3339, UTC, with milliseconds; null for
 * what no calendar has. New reference. */
json_t *time_json(int64_t time_ms);

/* Adds a line to *log, which is made when it is NULL. Without memory the line is lost: no job fails
 * for want of its log. A character that was cut off at the end goes as a whole; a text that is no
 * UTF-8 is lost. */
void job_log_add(json_t **log, int64_t time_ms, const char *what, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* The log of a report that was read back, checked as everything from outside; NULL when there is
 * none. New reference. */
json_t *job_log_read(const json_t *report);
