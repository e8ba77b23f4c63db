#include "server/job/jobs.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/clock.h"
#include "server/job/jobs_table.h"
#include "server/reconstruct/patch/scratch.h"

uint64_t jobs_clock_us(void)
{
    return clock_us(CLOCK_MONOTONIC);
}

uint64_t jobs_loop_cpu_us(void)
{
    return thread_cpu_us();
}

int64_t jobs_time_ms(void)
{
    return (int64_t)(clock_us(CLOCK_REALTIME) / 1000);
}

void jobs_set_state(struct jobs *jobs, struct active_job *job, enum job_state state)
{
    jobs->in_state[job->state]--;
    job_state_go(&job->state, state);
    jobs->in_state[state]++;
}

void jobs_event(struct active_job *job, const char *name, json_t *data, bool final)
{
    if (data && !job->jobs->stopping)
        stream_event(job->jobs->options.streams, job->id, name, data, final);
    json_decref(data);
}

void jobs_event_state(struct active_job *job)
{
    jobs_event(job, "state",
               json_pack("{s:s,s:b,s:i,s:I,s:o}", "state", job_state_name(job->state), "paused",
                         (int)active_job_is_paused(job), "priority", (int)job->priority, "revision",
                         (json_int_t)job->revision, "progress", active_job_progress(job)),
               job_state_is_final(job->state));
}

void jobs_remember_ended(struct jobs *jobs, const char *id)
{
    char *slot = jobs->ended[jobs->ended_next++ % ENDED_STREAMS];
    if (slot[0]) stream_forget(jobs->options.streams, slot);
    memcpy(slot, id, JOB_ID_BYTES);
}

/* Returns a job whose results were refused. */
static struct active_job *first_refused(const struct jobs *jobs)
{
    for (unsigned i = 0; i < jobs->open_count; i++)
        if (frame_refusal(jobs->open[i].frame->work)->code) return jobs->open[i].job;
    return NULL;
}

/* Fails a job after all workers were sent away for their results and none has come since. The job
 * would wait for ever. So many workers are seldom at fault at once, so the job goes and they come
 * back. Else one such job would end the service for all others. */
static void on_abandoned(uv_timer_t *timer)
{
    struct jobs *jobs = timer->data;
    struct active_job *job;
    if (jobs->stopping || !jobs->fleet || fleet_count(jobs->fleet) > 0) return;
    while ((job = first_refused(jobs))) active_job_fail(job, &jobs->refusal);
    fleet_forgive(jobs->fleet);
    jobs_advance_soon(jobs);
}

void jobs_fail_unless_joined(struct jobs *jobs, const struct fault *refusal)
{
    jobs->refusal = *refusal;
    if (!jobs->stopping) uv_timer_start(&jobs->abandoned, on_abandoned, ABANDONED_AFTER_MS, 0);
}

static void on_advance(uv_timer_t *timer)
{
    struct jobs *jobs = timer->data;
    if (jobs->stopping) return;
    jobs_complete_views(jobs);
    jobs_begin_ahead(jobs);
    while (jobs_open_next(jobs)) {
    }
}

/* Through the loop, so that nothing begins in the middle of something else. */
void jobs_advance_soon(struct jobs *jobs)
{
    if (!jobs->stopping) uv_timer_start(&jobs->advance, on_advance, 0, 0);
}

static void tell_tile(struct active_job *job)
{
    struct rect r = job->last_tile;
    job->last_tile = (struct rect){0};
    if (rect_is_empty(r)) return;
    jobs_event(job, "tile",
               json_pack("{s:i,s:i,s:i,s:i,s:i,s:I}", "frame", (int)job->last_tile_frame, "x", r.x0,
                         "y", r.y0, "w", rect_width(r), "h", rect_height(r), "worker",
                         (json_int_t)job->last_tile_worker),
               false);
}

static void tell_progress(struct active_job *job)
{
    job->progress_due = false;
    if (job_state_is_final(job->state)) return;
    tell_tile(job);
    active_job_keep_log(job);
    active_job_pace_note(job);
    json_t *progress = active_job_progress(job);
    if (progress)
        json_object_set_new(progress, "revision", json_integer((json_int_t)job->revision));
    jobs_event(job, "progress", progress, false);
}

#define RETRY_EVERY_MS 250

static void on_retry(uv_timer_t *timer)
{
    struct jobs *jobs = timer->data;
    if (!jobs->stopping && !jobs_retry(jobs)) uv_timer_stop(timer);
}

void jobs_retry_soon(struct jobs *jobs)
{
    if (!jobs->stopping && !uv_is_active((uv_handle_t *)&jobs->retry))
        uv_timer_start(&jobs->retry, on_retry, RETRY_EVERY_MS, RETRY_EVERY_MS);
}

static void on_progress(uv_timer_t *timer)
{
    struct jobs *jobs = timer->data;
    unsigned quiet = 0;
    /* A job that was lowered while it ran may stand behind many that wait. */
    for (unsigned i = 0; i < jobs->open_count; i++)
        if (jobs->open[i].job->progress_due) tell_progress(jobs->open[i].job);
    /* Of the others only the first few in order have been begun. */
    for (struct active_job *job = jobs->first; job && quiet < 4 * OPEN_MAX; job = job->after) {
        if (job->progress_due)
            tell_progress(job);
        else if (!job->paused)
            quiet++;
    }
}

void jobs_progress_soon(struct jobs *jobs, struct active_job *job)
{
    job->revision++;
    job->progress_due = true;
    if (!jobs->stopping && !uv_is_active((uv_handle_t *)&jobs->progress))
        uv_timer_start(&jobs->progress, on_progress, PROGRESS_EVERY_MS, 0);
}

/* Frees unused scratch, also during a long frame, which takes back what it needs once. */
static void on_unused(uv_timer_t *timer)
{
    struct jobs *jobs = timer->data;
    scratch_trim(jobs->scratch, 0);
}

void jobs_mind_scratch(struct jobs *jobs)
{
    if (jobs->stopping) return;
    uv_timer_start(&jobs->unused, on_unused, SCRATCH_UNUSED_MS, 0);
    scratch_trim(jobs->scratch, SCRATCH_MAX_BYTES);
}

int jobs_create(const struct jobs_options *options, struct jobs **out)
{
    struct jobs *jobs = calloc(1, sizeof *jobs);
    if (!jobs) return ERR_MEMORY;
    struct import_options import = {.loop = options->loop,
                                    .pool = options->pool,
                                    .objects = options->objects,
                                    .program = options->import_program,
                                    .limit_ms = LIMIT_IMPORT_MS};
    jobs->options = *options;
    if (scratch_create(&jobs->scratch) != 0 ||
        imports_create(&import, options->store, &jobs->imports) != 0) {
        scratch_destroy(&jobs->scratch);
        free(jobs);
        return ERR_MEMORY;
    }
    uv_timer_init(options->loop, &jobs->advance);
    uv_timer_init(options->loop, &jobs->progress);
    uv_timer_init(options->loop, &jobs->abandoned);
    uv_timer_init(options->loop, &jobs->idle);
    uv_timer_init(options->loop, &jobs->retry);
    uv_timer_init(options->loop, &jobs->unused);
    jobs->unused.data = jobs->retry.data = jobs->idle.data = jobs->advance.data =
        jobs->progress.data = jobs->abandoned.data = jobs;
    *out = jobs;
    return 0;
}

void jobs_set_fleet(struct jobs *jobs, struct fleet *fleet)
{
    jobs->fleet = fleet;
}

struct resumption {
    struct jobs *jobs;
    int error;
};

/* The document is as job_write wrote it: in its texts a quote is escaped, so that this stands for
 * nothing else. */
static bool is_live(const struct job_row *row)
{
    return row->document && strstr(row->document, "\"live\":true");
}

/* Whatever it was doing, it waits for its turn again; what is on disk is found when that comes. */
static void resume_one(void *ctx, const struct job_row *row, const struct frame_row *frames,
                       size_t frame_count)
{
    struct resumption *resumption = ctx;
    (void)frames, (void)frame_count;
    if (resumption->error) return;
    struct active_job *job =
        active_job_create(resumption->jobs, row->id, row->owner, row->priority, row->created_ms);
    if (job) {
        job->live = is_live(row);
        job->paused = row->paused;
        (void)trace_context_kept(row->trace, &job->trace);
    }
    struct job_counts *counts = &resumption->jobs->counts;
    if (job && row->owner[0]) job->counted = job_counts_take(counts, row->owner, 0) == 0;
    if (!job || jobs_table_add(resumption->jobs, job) != 0) {
        if (job) active_job_release(job);
        resumption->error = ERR_MEMORY;
    }
}

static bool is_unfinished(void *ctx, const char *job)
{
    return jobs_table_find(ctx, job) != NULL;
}

int jobs_resume(struct jobs *jobs)
{
    struct resumption resumption = {.jobs = jobs};
    char newest[JOB_ID_BYTES];
    int error = job_store_newest(jobs->options.store, newest);
    if (!error && job_id_is_valid(newest)) job_id_follow(&jobs->ids, newest);
    if (!error) error = job_store_unfinished(jobs->options.store, resume_one, &resumption);
    if (!error && !resumption.error && jobs->options.spools)
        spools_sweep(jobs->options.spools, is_unfinished, jobs);
    jobs_advance_soon(jobs);
    return error ? error : resumption.error;
}

static void stop_dry_runs(struct jobs *jobs)
{
    struct fault fault;
    struct dry_run *run;
    fault_set(&fault, ERR_STATE, "", "the server is shutting down");
    while ((run = jobs->dry_runs)) {
        jobs->dry_runs = run->next;
        preparation_cancel(&run->preparation);
        run->done(run->ctx, &fault, NULL, NULL);
        free(run);
    }
}

void jobs_stop(struct jobs *jobs)
{
    if (jobs->stopping) return;
    jobs->stopping = true;
    jobs->fleet = NULL;
    uv_close((uv_handle_t *)&jobs->advance, NULL);
    uv_close((uv_handle_t *)&jobs->progress, NULL);
    uv_close((uv_handle_t *)&jobs->abandoned, NULL);
    uv_close((uv_handle_t *)&jobs->idle, NULL);
    uv_close((uv_handle_t *)&jobs->retry, NULL);
    uv_close((uv_handle_t *)&jobs->unused, NULL);
    for (size_t i = 0; i < jobs->count; i++) {
        live_view_keep(jobs->by_id[i]);
        active_job_drop(jobs->by_id[i]);
    }
    stop_dry_runs(jobs);
    imports_stop(jobs->imports);
}

void jobs_destroy(struct jobs **jobs_)
{
    struct jobs *jobs = *jobs_;
    *jobs_ = NULL;
    if (!jobs) return;
    assert(jobs->stopping && jobs->open_count == 0);
    for (size_t i = 0; i < jobs->count; i++) {
        assert(jobs->by_id[i]->holds == 0);
        active_job_release(jobs->by_id[i]);
    }
    imports_destroy(&jobs->imports);
    fair_share_fini(&jobs->share);
    job_counts_fini(&jobs->counts);
    free(jobs->by_id);
    scratch_destroy(&jobs->scratch);
    free(jobs);
}

uint64_t jobs_waiting(const struct jobs *jobs)
{
    uint64_t count = 0;
    for (const struct active_job *job = jobs->first; job; job = job->after)
        count += !job->paused && (job->state == JOB_QUEUED || job->state == JOB_IMPORTING);
    return count;
}

void jobs_totals(const struct jobs *jobs, struct jobs_totals *out)
{
    struct statistics sum = jobs->past;
    for (unsigned i = 0; i < jobs->open_count; i++)
        statistics_add(&sum, frame_statistics(jobs->open[i].frame->work));
    /* What was traced in an earlier run was told of then. */
    for (int i = 0; i < COUNTER_COUNT; i++) sum.counters.value[i] -= sum.counters_resumed.value[i];
    *out = (struct jobs_totals){.queued = jobs->in_state[JOB_QUEUED],
                                .importing = jobs->in_state[JOB_IMPORTING],
                                .running = jobs->in_state[JOB_RUNNING],
                                .resting = jobs->in_state[JOB_RESTING],
                                .finished = jobs->in_state[JOB_FINISHED],
                                .failed = jobs->in_state[JOB_FAILED],
                                .cancelled = jobs->in_state[JOB_CANCELLED],
                                .submitted = jobs->submitted,
                                .tiles_done = sum.tiles_done,
                                .tiles_reissued = sum.tiles_reissued,
                                .tiles_copied = sum.tiles_copied,
                                .tiles_resumed = sum.tiles_resumed,
                                .results_dropped = sum.results_dropped,
                                .samples_rejected = sum.results_corrupt,
                                .counters = sum.counters,
                                .import_cpu_us = sum.import_cpu_us,
                                .reconstruct_cpu_us = sum.reconstruct_cpu_us,
                                .shadow_cpu_us = sum.shadow_cpu_us,
                                .indirect_cpu_us = sum.indirect_cpu_us,
                                .glossy_cpu_us = sum.glossy_cpu_us,
                                .lens_cpu_us = sum.lens_cpu_us,
                                .lens_relight_cpu_us = sum.lens_relight_cpu_us,
                                .residual_cpu_us = sum.residual_cpu_us,
                                .oidn_cpu_us = sum.oidn_cpu_us,
                                .coordinate_cpu_us = sum.coordinate_cpu_us,
                                .decode_cpu_us = sum.decode_cpu_us,
                                .encode_cpu_us = sum.encode_cpu_us};
}
