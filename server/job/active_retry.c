/* Retries what failed because of the machine and not of the job: a full or failing disk, exhausted
 * memory. No accepted job is lost by that. Each step is tried again until it succeeds, from where
 * it was. Drawn pictures wait in memory for their files, records are made later, and all else
 * begins again as after a restart, with what the spool has. */
#include <limits.h>
#include <stdlib.h>

#include "server/job/jobs_table.h"
#include "server/job/live_view.h"

/* Pauses double from the first to the last, so that recovery is noticed in time. */
#define PAUSE_FIRST_MS 500u
#define PAUSE_LAST_MS  4000u

/* Limits for what the job itself may have caused: a file that the importer has no memory for; a
 * frame that is too large for this machine, some minutes' worth of pauses. */
#define TRIES_OF_FILES  5u
#define TRIES_OF_MEMORY 60u

static bool is_of_the_machine(int code)
{
    return code == ERR_NO_SPACE || code == ERR_IO || code == ERR_MEMORY;
}

/* Returns how often a fault is tried again. A fault with a pointer belongs to the document, or to a
 * file that it names, as the importer saw it. */
static unsigned tries_of(const struct fault *fault)
{
    if (fault->code == ERR_NO_SPACE) return UINT_MAX;
    if (fault->pointer[0] != '\0') return TRIES_OF_FILES;
    return fault->code == ERR_MEMORY ? TRIES_OF_MEMORY : UINT_MAX;
}

static void wait_for(struct active_job *job, unsigned what)
{
    struct jobs *jobs = job->jobs;
    const unsigned doublings = job->pauses < 8 ? job->pauses : 8;
    uint64_t pause_ms = (uint64_t)PAUSE_FIRST_MS << doublings;
    if (pause_ms > PAUSE_LAST_MS) pause_ms = PAUSE_LAST_MS;
    job->pauses++;
    job->retry |= what;
    job->retry_us = jobs_clock_us() + pause_ms * 1000;
    jobs_retry_soon(jobs);
}

/* Resets the job to before its turn, but for its log. */
static void reset(struct active_job *job)
{
    active_job_drop(job);
    live_view_destroy(job);
    prepared_destroy(&job->prepared);
    json_decref(job->plan);
    active_job_free_frames(job);
    job->plan = NULL;
    job->tiles_beyond = 0;
    job->runs++;
    job->work_started_us = job->pace.started_us = 0;
    jobs_set_state(job->jobs, job, JOB_QUEUED);
    job->revision++;
}

void active_job_fail_or_retry(struct active_job *job, const struct fault *fault)
{
    if (!is_of_the_machine(fault->code) || ++job->tries >= tries_of(fault)) {
        active_job_fail(job, fault);
        return;
    }
    active_job_log(job, "error", "it begins again soon: %s%s%s", fault->pointer,
                   fault->pointer[0] ? ": " : "", fault->detail);
    reset(job);
    jobs_event_state(job);
    wait_for(job, RETRY_BEGIN);
}

void active_job_retry_store(struct active_job *job, struct active_frame *frame,
                            const struct fault *fault)
{
    active_job_log(job, "error", "tried again soon: %s", fault->detail);
    frame->retry = RETRY_STORE;
    wait_for(job, RETRY_FRAMES);
}

void active_job_retry_record(struct active_job *job, struct active_frame *frame)
{
    active_job_log(job, "error", "tried again soon: a frame could not be recorded");
    frame->retry = RETRY_RECORD;
    wait_for(job, RETRY_FRAMES);
}

void active_job_retry_end(struct active_job *job)
{
    wait_for(job, RETRY_END);
}

static void try_frames(struct active_job *job)
{
    for (uint32_t i = 0; i < job->frame_count && !job_state_is_final(job->state); i++) {
        struct active_frame *frame = &job->frames[i];
        const enum retry what = frame->retry;
        frame->retry = 0;
        if (what == RETRY_STORE && frame->work && frame_state(frame->work) == FRAME_ENCODING)
            frame_store(frame->work);
        if (what == RETRY_RECORD) active_job_record_frame(job, frame);
        if (!job->frames) return;
    }
}

static void retry(struct active_job *job)
{
    const unsigned what = job->retry;
    job->retry = 0;
    if (what & RETRY_END) active_job_record_end(job);
    if (job_state_is_final(job->state)) return;
    if (what & RETRY_FRAMES) try_frames(job);
    if (what & RETRY_BEGIN) jobs_advance_soon(job->jobs);
}

bool jobs_retry(struct jobs *jobs)
{
    const uint64_t now_us = jobs_clock_us();
    bool waits = false;
    /* Nothing is taken out of the table meanwhile: that waits for the store. */
    for (size_t i = 0; i < jobs->count; i++) {
        struct active_job *job = jobs->by_id[i];
        waits |= live_scene_take(job);
        if (!job->retry) continue;
        if (now_us >= job->retry_us) retry(job);
        waits |= job->retry != 0;
    }
    return waits;
}
