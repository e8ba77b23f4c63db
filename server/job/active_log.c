/* A job's log: what is worth a line. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/job_log.h"
#include "server/job/jobs_table.h"

/* Writes a line to the server's log, under the request that submitted the job. A failed job is no
 * failure of the server. */
static void tell(const struct active_job *job, const char *kind, const char *text)
{
    const bool is_bad = !strcmp(kind, "error") || !strcmp(kind, "warning");
    const struct log_field fields[] = {
        {"job", job->id, 0}, {"owner", job->owner, 0}, {"kind", kind, 0}, {"detail", text, 0}};
    log_write(job->jobs->options.log, is_bad ? LOG_WARNING : LOG_INFO, "job",
              job->trace.request[0] ? &job->trace : NULL, fields, sizeof fields / sizeof fields[0]);
}

void active_job_log_accepted(const struct active_job *job)
{
    tell(job, "state", "accepted");
}

void active_job_log(struct active_job *job, const char *what, const char *format, ...)
{
    char text[LIMIT_DETAIL_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    job_log_add(&job->log, jobs_time_ms(), what, "%s", text);
    tell(job, what, text);
    job->revision++;
    job->log_due = true;
}

/* Workers may come and go by the hundred: a commit for each would be too many. */
#define KEEP_EVERY_US 2000000u

void active_job_keep_log(struct active_job *job)
{
    uint64_t now_us = jobs_clock_us();
    if (!job->log_due || job->state != JOB_RUNNING || now_us - job->log_kept_us < KEEP_EVERY_US)
        return;
    job->log_due = false;
    job->log_kept_us = now_us;
    active_job_keep_report(job, NULL);
}

void active_job_take_log(struct active_job *job, const json_t *report)
{
    if (job->log) return;
    job->log = job_log_read(report);
    if (job->log)
        active_job_log(job, "state", "taken up again after a restart of the coordinator");
    else
        job_log_add(&job->log, job->created_ms, "state", LOG_SUBMITTED);
}

static void log_warnings(struct active_job *job)
{
    size_t i;
    json_t *warning;
    json_array_foreach (json_object_get(job->plan, "warnings"), i, warning)
        active_job_log(job, "warning", "%s", json_string_value(warning));
}

static void log_failure(struct active_job *job)
{
    const char *detail = json_string_value(json_object_get(job->error, "detail"));
    const char *title = json_string_value(json_object_get(job->error, "title"));
    const char *pointer = json_string_value(json_object_get(job->error, "pointer"));
    active_job_log(job, "error", "failed: %s%s%s", pointer ? pointer : "", pointer ? ": " : "",
                   detail  ? detail
                   : title ? title
                           : "");
}

void active_job_log_state(struct active_job *job)
{
    switch (job->state) {
    case JOB_IMPORTING:
        active_job_log(job, "state", "the scene is imported and the frame planned");
        break;
    case JOB_RUNNING:
        active_job_log(job, "state", "planned: tiles are given out");
        log_warnings(job);
        break;
    case JOB_FAILED:
        log_failure(job);
        break;
    case JOB_RESTING:
        active_job_log(job, "state", "resting: the full picture is there, the camera may be moved");
        break;
    case JOB_FINISHED:
        active_job_log(job, "state", "finished: all files are stored");
        break;
    default:
        active_job_log(job, "state", "%s", job_state_name(job->state));
    }
}
