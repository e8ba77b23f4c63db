#include "server/job/active_job.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/json.h"
#include "proto/runtime/build.h"
#include "server/job/jobs_table.h"
#include "server/job/live_view.h"

/* Views that may come while one is recorded, and so be lost when the coordinator dies: their
 * numbers must not come again for others. */
#define VIEWS_UNRECORDED 4096u

struct active_job *active_job_create(struct jobs *jobs, const char *id, const char *owner,
                                     int32_t priority, int64_t created_ms)
{
    struct active_job *job = calloc(1, sizeof *job);
    if (!job) return NULL;
    job->jobs = jobs;
    memcpy(job->id, id, JOB_ID_BYTES - 1);
    memcpy(job->owner, owner, strnlen(owner, JOB_OWNER_BYTES - 1));
    job->priority = priority;
    job->created_ms = created_ms;
    job->state = JOB_QUEUED;
    job->revision = (uint64_t)jobs_time_ms();
    return job;
}

static void destroy(struct active_job *job)
{
    if (job->counted) job_counts_give(&job->jobs->counts, job->owner);
    live_view_destroy(job);
    prepared_destroy(&job->prepared);
    json_decref(job->plan);
    json_decref(job->log);
    json_decref(job->error);
    json_decref(job->last_progress);
    active_job_free_frames(job);
    free(job);
}

void active_job_release(struct active_job *job)
{
    job->gone = true;
    if (job->holds == 0) destroy(job);
}

/* Notes that a store callback came. False when the job is no longer there (and maybe freed). */
static bool unhold(struct active_job *job)
{
    assert(job->holds > 0);
    job->holds--;
    if (!job->gone) return !job->jobs->stopping;
    if (job->holds == 0) destroy(job);
    return false;
}

void active_job_drop(struct active_job *job)
{
    preparation_cancel(&job->preparation);
    if (job->view) live_scene_give_up(job);
    if (job->view) live_view_hide(job);
    active_job_drop_frames(job);
}

static void go(struct active_job *job, enum job_state state)
{
    jobs_set_state(job->jobs, job, state);
    job->revision++;
}

/* {type, title, detail, pointer} (RFC 9457), for GET and for the event. */
/* Returns the fault as a problem document; NULL without memory. */
static json_t *problem_of(const struct fault *fault)
{
    char type[64] = "urn:shearwater:error:";
    size_t at = strlen(type);
    for (const char *c = error_name(fault->code); *c && at < sizeof type - 1; c++)
        type[at++] = (char)(*c == '_' ? '-' : *c >= 'A' && *c <= 'Z' ? *c - 'A' + 'a' : *c);
    type[at] = '\0';
    json_t *problem = json_pack("{s:s,s:s}", "type", type, "title", error_text(fault->code));
    int failed = !problem;
    if (fault->detail[0])
        failed |= json_object_set_new(problem, "detail", json_words(fault->detail));
    if (fault->pointer[0])
        failed |= json_object_set_new(problem, "pointer", json_words(fault->pointer));
    if (!failed) return problem;
    json_decref(problem);
    return NULL;
}

/* Answers the requests that cancelled the job, also with an error: the end is not durable yet,
 * though it will be. */
static void answer_cancellation(struct active_job *job, int error)
{
    if (job->cancelled) job->cancelled(job->cancelled_ctx, error);
    job->cancelled = NULL;
}

static void on_ended(void *ctx, int error)
{
    struct active_job *job = ctx;
    struct jobs *jobs = job->jobs;
    answer_cancellation(job, error);
    if (!unhold(job)) return;
    if (error && error != ERR_NOT_FOUND) {
        /* What could not be recorded stays in the table: GET must not fall back to the old state.
         */
        active_job_retry_end(job);
        return;
    }
    jobs_event_state(job);
    webhooks_soon(jobs->options.webhooks);
    jobs_remember_ended(jobs, job->id);
    if (jobs->options.spools) spools_remove(jobs->options.spools, job->id, -1);
    jobs_table_remove(jobs, job);
    active_job_release(job);
    jobs_advance_soon(jobs);
}

/* Stops the clocks, so that the report has the whole job. */
static void close_statistics(struct active_job *job)
{
    active_job_unshelve_frames(job);
    active_job_statistics(job, &job->statistics);
    job->work_started_us = 0;
}

void active_job_pause(struct active_job *job, bool paused)
{
    job->paused = paused;
    if (job->state == JOB_QUEUED) return; /* no clock runs yet */
    if (paused) {
        active_job_add_work(job, &job->statistics);
        job->work_started_us = 0;
        return;
    }
    job->work_started_us = jobs_clock_us();
    job->work_started_cpu_us = jobs_loop_cpu_us();
    if (job->pace.started_us != 0) active_job_pace_start(job);
}

static void end(struct active_job *job, enum job_state state)
{
    live_view_keep(job);
    job->last_progress = active_job_progress(job);
    go(job, state);
    active_job_take_log(job, NULL);
    active_job_log_state(job);
    active_job_drop(job);
    close_statistics(job);
    active_job_record_end(job);
}

/* Without memory for the texts it does the same as where the store fails. */
void active_job_record_end(struct active_job *job)
{
    const bool has_failed = job->state == JOB_FAILED;
    if (has_failed && !job->error) job->error = problem_of(&job->failure);
    json_t *report = active_job_report(job);
    char *report_text = json_text(report, JSON_COMPACT);
    char *problem_text = json_text(job->error, JSON_COMPACT);
    if (report_text && (problem_text || !has_failed)) {
        job->holds++;
        job_store_update(job->jobs->options.store, job->id, job_state_name(job->state),
                         problem_text, report_text, on_ended, job);
    } else {
        answer_cancellation(job, ERR_MEMORY);
        active_job_retry_end(job);
    }
    json_decref(report);
    free(report_text);
    free(problem_text);
}

void active_job_fail(struct active_job *job, const struct fault *fault)
{
    assert(!job_state_is_final(job->state));
    job->failure = *fault;
    job->error = problem_of(fault);
    jobs_event(job, "error", json_incref(job->error), false);
    end(job, JOB_FAILED);
}

void active_job_finish(struct active_job *job)
{
    end(job, JOB_FINISHED);
}

void active_job_cancel(struct active_job *job, job_store_done done, void *ctx)
{
    assert(!job_state_is_final(job->state) && !job->cancelled);
    job->cancelled = done;
    job->cancelled_ctx = ctx;
    end(job, JOB_CANCELLED);
}

/* Frames of an earlier run whose files are still there need not be made again. */
static int take_frames(struct active_job *job, const struct frame_row *rows, size_t count,
                       const struct job *document)
{
    const struct objects *objects = job->jobs->options.objects;
    job->frame_count = job_frame_count(document);
    job->frames = calloc(job->frame_count, sizeof *job->frames);
    if (!job->frames) return ERR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        const struct frame_row *row = &rows[i];
        enum frame_state state;
        uint32_t index;
        if (!job_frame_find(document, row->number, &index) || !row->state ||
            !frame_state_from_name(row->state, &state) || state != FRAME_FINISHED ||
            !objects_have(objects, &row->exr, NULL) || !objects_have(objects, &row->png, NULL))
            continue;
        struct active_frame *frame = &job->frames[index];
        *frame = (struct active_frame){.state = FRAME_FINISHED, .exr = row->exr, .png = row->png};
        job->frames_finished++;
    }
    return 0;
}

/* Its views go on from those of an earlier run. */
static int start_view(struct active_job *job)
{
    struct fault fault;
    const uint32_t before = job->view_before;
    int error = live_view_create(job, before > 0 ? before + VIEWS_UNRECORDED : 1, &fault);
    if (error) active_job_fail_or_retry(job, &fault);
    return error;
}

static void on_prepared(void *ctx, const struct fault *fault, struct prepared *prepared)
{
    struct active_job *job = ctx;
    job->preparation = NULL;
    if (fault) {
        active_job_fail_or_retry(job, fault);
        return;
    }
    job->prepared = prepared;
    job->statistics.import_cpu_us += prepared->import_cpu_us;
    job->jobs->past.import_cpu_us += prepared->import_cpu_us;
    job->plan = active_job_plan_json(prepared, &prepared->plan, &prepared->report);
    if (!job->plan || fingerprint_of(&prepared->job, job->fingerprint) != 0) {
        struct fault memory;
        fault_set(&memory, ERR_MEMORY, "", "no memory for the job's plan");
        active_job_fail_or_retry(job, &memory);
        return;
    }
    if (job->live && start_view(job) != 0) return;
    go(job, JOB_RUNNING);
    active_job_log_state(job);
    active_job_keep_report(job, job_state_name(job->state));
    jobs_event_state(job);
    active_job_recall(job);
    if (job->frames_finished == job->frame_count)
        active_job_finish(job);
    else
        active_job_prepare_ahead(job);
    jobs_advance_soon(job->jobs);
}

/* Numbers of an earlier run go on growing. */
static int take_report(struct active_job *job, const char *text, struct fault *fault)
{
    json_t *report = NULL;
    const int error = text ? json_read(text, strlen(text), SIZE_MAX, &report, fault) : 0;
    if (error == ERR_MEMORY) return error;
    statistics_read(json_object_get(report, "statistics"), &job->statistics);
    active_job_take_log(job, report);
    active_job_log_state(job);
    const json_t *number = json_object_get(json_object_get(report, "view"), "number");
    job->view_before = (uint32_t)json_integer_value(number);
    json_decref(report);
    return 0;
}

static int load(struct active_job *job, const struct job_row *row, const struct frame_row *frames,
                size_t frame_count, struct fault *fault)
{
    struct job document;
    struct jobs *jobs = job->jobs;
    if (!row || !row->document)
        return fault_set(fault, ERR_NOT_FOUND, "", "the job's document is not in the store");
    int error = job_read(row->document, strlen(row->document), &document, fault);
    if (error) return error;
    if ((error = take_report(job, row->report, fault)) != 0) {
        job_fini(&document);
        return error;
    }
    error = take_frames(job, frames, frame_count, &document);
    if (error) {
        job_fini(&document);
        return fault_set(fault, error, "", "no memory for the job's frames");
    }
    error = preparation_start(jobs->imports, jobs->options.pool, jobs->options.objects, &document,
                              job_frame_number(&document, 0), NULL, on_prepared, job,
                              &job->preparation);
    return error ? fault_set(fault, error, "", "no memory to import the scene") : 0;
}

static void on_loaded(void *ctx, int error, const struct job_row *row,
                      const struct frame_row *frames, size_t frame_count)
{
    struct active_job *job = ctx;
    struct fault fault;
    job->loading = false;
    if (!unhold(job) || job_state_is_final(job->state)) return;
    if (!job->paused) {
        job->work_started_us = jobs_clock_us();
        job->work_started_cpu_us = jobs_loop_cpu_us();
    }
    go(job, JOB_IMPORTING);
    if (error)
        fault_set(&fault, error, "", "the job could not be read from the store");
    else
        error = load(job, row, frames, frame_count, &fault);
    if (error) {
        active_job_fail_or_retry(job, &fault);
        return;
    }
    job_store_update(job->jobs->options.store, job->id, job_state_name(job->state), NULL, NULL,
                     NULL, NULL);
    jobs_event_state(job);
}

void active_job_begin(struct active_job *job)
{
    assert(job->state == JOB_QUEUED && !job->loading);
    job->loading = true;
    job->holds++;
    job_store_get(job->jobs->options.store, job->id, on_loaded, job);
}
