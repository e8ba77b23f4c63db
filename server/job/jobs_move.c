/* Moves the camera and the nodes of live jobs, and ends live jobs that are not moved any more. */
#include <limits.h>
#include <stdlib.h>

#include "proto/job/job.h"
#include "server/job/jobs_table.h"
#include "server/job/live_view.h"

#define IDLE_CHECKS 8 /* within the time after which a job that rests ends */

struct move {
    struct principal principal;
    jobs_moved done;
    void *ctx;
};

/* {id, view, camera, lens, moves}: what the job has now. */
static json_t *answer_of(const struct active_job *job)
{
    const struct job *document = &job->prepared->job;
    return json_pack("{s:s,s:o,s:o,s:o,s:o}", "id", job->id, "view", live_view_json(job), "camera",
                     job_camera_write(&document->camera), "lens", job_lens_write(document), "moves",
                     job_moves_write(&document->moves));
}

/* A job that is not in the table has ended, or never was. */
static void on_row(void *ctx, int error, const struct job_row *row, const struct frame_row *frames,
                   size_t frame_count)
{
    struct move *move = ctx;
    struct fault fault;
    (void)frames, (void)frame_count;
    if (!error && (!row || !principal_sees(&move->principal, row->owner)))
        fault_set(&fault, ERR_NOT_FOUND, "", "there is no such job");
    else if (!error)
        fault_set(&fault, ERR_STATE, "", "it has ended: its camera cannot be moved any more");
    else
        fault_set(&fault, error, "", "the job could not be read from the store");
    move->done(move->ctx, &fault, NULL);
    free(move);
}

static void look_up(struct jobs *jobs, const struct principal *principal, const char *id,
                    jobs_moved done, void *ctx)
{
    struct move *move = malloc(sizeof *move);
    struct fault fault;
    if (!move) {
        fault_set(&fault, ERR_MEMORY, "", "memory is exhausted");
        done(ctx, &fault, NULL);
        return;
    }
    *move = (struct move){.principal = *principal, .done = done, .ctx = ctx};
    job_store_get(jobs->options.store, id, on_row, move);
}

void jobs_answer_move(const struct active_job *job, const struct fault *fault, jobs_moved done,
                      void *ctx)
{
    struct fault memory;
    json_t *body = fault ? NULL : answer_of(job);
    if (!fault && !body) fault_set(&memory, ERR_MEMORY, "", "memory is exhausted");
    done(ctx, body ? NULL : fault ? fault : &memory, body);
    json_decref(body);
}

void jobs_move(struct jobs *jobs, const struct principal *principal, const char *id,
               const char *text, size_t size_bytes, jobs_moved done, void *ctx)
{
    struct fault fault = {0};
    struct active_job *job = jobs_table_find(jobs, id);
    if (!job || !principal_sees(principal, job->owner) || jobs->stopping) {
        look_up(jobs, principal, id, done, ctx);
        return;
    }
    bool waits = false;
    int error = live_view_check(job, &fault);
    if (!error) error = live_view_move(job, text, size_bytes, &waits, &fault);
    if (!error && waits) {
        error = live_scene_wait(job, text, size_bytes, done, ctx);
        if (!error) return;
        fault_set(&fault, error, "",
                  error == ERR_FULL ? "%d moves of the job wait already: wait for an answer"
                                    : "memory is exhausted",
                  LIMIT_WAITING_MOVES);
    }
    jobs_answer_move(job, error ? &fault : NULL, done, ctx);
}

/* Ends those that have rested for too long. */
static void on_idle(uv_timer_t *timer)
{
    struct jobs *jobs = timer->data;
    const uint64_t now_us = jobs_clock_us();
    for (unsigned i = 0; i < jobs->open_count; i++) {
        struct active_job *job = jobs->open[i].job;
        if (!job->view || job->view->preparation || job->state != JOB_RESTING) continue;
        if (jobs->open[i].frame->state != FRAME_RENDERING ||
            frame_state(jobs->open[i].frame->work) != FRAME_RENDERING)
            continue; /* it ends already */
        if (now_us - job->view->moved_us >= jobs->options.live_idle_ms * 1000) live_view_end(job);
    }
}

void jobs_watch_idle(struct jobs *jobs)
{
    const uint64_t limit_ms = jobs->options.live_idle_ms, each_ms = limit_ms / IDLE_CHECKS + 1;
    if (!jobs->stopping && !uv_is_active((uv_handle_t *)&jobs->idle))
        uv_timer_start(&jobs->idle, on_idle, each_ms, each_ms);
}

void jobs_complete_views(struct jobs *jobs)
{
    for (unsigned i = 0; i < jobs->open_count; i++) {
        struct active_job *job = jobs->open[i].job;
        struct frame *work = jobs->open[i].frame->work;
        if (!job->view || job->state != JOB_RUNNING || !frame_is_complete(work)) continue;
        live_view_completed(job);
        i = UINT_MAX; /* the list may be another: from its beginning */
    }
}
