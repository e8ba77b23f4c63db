/* A job's frames in work: opened, drawn, stored, recorded. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/build.h"
#include "proto/samples.h"
#include "server/job/frame/picture_file.h"
#include "server/job/jobs_table.h"
#include "server/job/live_view.h"

/* Floats a pixel that wait for further passes, or for frames beside; without these a frame's
 * samples come and go. */
static uint64_t waiting_floats(const struct plan *plan)
{
    struct samples_layout layout;
    const int32_t side = LIMIT_TILE_SIDE_MIN_PX;
    if (plan_pass_count(plan) == 1 && !plan_has_rounds(plan) && plan->temporal == 0) return 0;
    if (samples_layout_init(&layout, plan, 0, side, side) != 0) return 0;
    return layout.total_bytes / (sizeof(float) * LIMIT_TILE_SIDE_MIN_PX * LIMIT_TILE_SIDE_MIN_PX);
}

uint64_t active_job_frame_floats(const struct active_job *job)
{
    const struct plan *plan = &job->prepared->plan;
    /* About three channels a layer. */
    uint64_t layers = (uint64_t)__builtin_popcount(job->prepared->job.layers);
    const uint64_t views = plan_views(plan), plate = job->prepared->plate ? 3 : 0;
    return (uint64_t)plan->width_px * (uint64_t)plan->height_px *
           (3 * layers + 1 + views * waiting_floats(plan) + (views - 1) * 4 + plate);
}

/* The pixel feed shows one frame of a job at a time: the first that is in work. Between two there
 * is no end of pictures: what readers lack of the first would be made for nothing. */
void active_job_show(struct active_job *job, struct active_frame *frame)
{
    if (frame || job->shown)
        stream_image(job->jobs->options.streams, job->id, frame ? frame_image(frame->work) : NULL);
    job->shown = frame;
}

static struct active_frame *first_in_work(const struct active_job *job)
{
    for (unsigned i = 0; i < job->jobs->open_count; i++)
        if (job->jobs->open[i].job == job) return job->jobs->open[i].frame;
    return NULL;
}

static bool is_alone(const struct active_job *job, const struct active_frame *frame)
{
    for (unsigned i = 0; i < job->jobs->open_count; i++)
        if (job->jobs->open[i].job == job && job->jobs->open[i].frame != frame) return false;
    return true;
}

/* The first that becomes a picture. */
static struct active_frame *first_drawn(const struct active_job *job)
{
    for (unsigned i = 0; i < job->jobs->open_count; i++)
        if (job->jobs->open[i].job == job && !job->jobs->open[i].frame->recalled)
            return job->jobs->open[i].frame;
    return NULL;
}

/* Adds a shelved frame's numbers to the job's. */
static void unshelve(struct active_job *job, struct active_frame *frame)
{
    if (!frame->shelved) return;
    statistics_add(&job->statistics, &frame->shelved->statistics);
    free(frame->shelved);
    frame->shelved = NULL;
}

/* Takes a frame out of work. */
static void leave_table(struct active_job *job, struct active_frame *frame)
{
    struct jobs *jobs = job->jobs;
    uint64_t id = frame_id(frame->work);
    statistics_add(&jobs->past, frame_statistics(frame->work));
    jobs_table_close(jobs, frame);
    frame->retry = 0; /* what was to be tried again was this work's */
    if (jobs->fleet) fleet_cancel(jobs->fleet, id);
}

/* Takes a frame out of work for good, and adds its numbers to the job's. */
static void leave_work(struct active_job *job, struct active_frame *frame)
{
    statistics_add(&job->statistics, frame_statistics(frame->work));
    unshelve(job, frame);
    leave_table(job, frame);
}

/* Its memory goes back. */
static void drop_work(struct active_job *job, struct active_frame *frame)
{
    if (job->view) live_view_hide(job);
    if (job->shown == frame) active_job_show(job, job->jobs->stopping ? NULL : first_drawn(job));
    frame_drop(&frame->work);
}

void active_job_close_work(struct active_job *job, struct active_frame *frame)
{
    leave_work(job, frame);
    drop_work(job, frame);
}

struct frame *active_job_take_work(struct active_job *job, struct active_frame *frame)
{
    struct frame *work = frame->work;
    leave_work(job, frame);
    frame->work = NULL;
    frame_state_go(&frame->state, FRAME_QUEUED);
    job->frames_opened--;
    return work;
}

static void queue_again(struct active_job *job, struct active_frame *frame)
{
    if (frame->recalled) {
        job->recalls++;
        return;
    }
    frame_state_go(&frame->state, FRAME_QUEUED);
    job->frames_opened--;
}

void active_job_shelve_frame(struct active_job *job, struct active_frame *frame)
{
    struct shelved_frame *shelved = shelved_frame_create(frame->work, frame->shelved);
    if (!shelved) { /* counts as a frame of its own */
        active_job_close_work(job, frame);
    } else {
        frame->shelved = shelved;
        leave_table(job, frame);
        drop_work(job, frame);
    }
    queue_again(job, frame);
    active_job_recall(job);
    active_job_prepare_ahead(job); /* frames that are recalled gave their scenes back */
}

void active_job_unshelve_frames(struct active_job *job)
{
    for (uint32_t i = 0; i < job->frame_count; i++) unshelve(job, &job->frames[i]);
}

void active_job_free_frames(struct active_job *job)
{
    for (uint32_t i = 0; i < job->frame_count; i++) {
        const struct active_frame *frame = &job->frames[i];
        if (frame->retry == RETRY_RECORD)
            active_frame_release_pictures(job->jobs, &frame->exr, &frame->png);
        free(frame->shelved);
        residual_history_drop(&job->frames[i].history);
        prepared_destroy(&job->frames[i].prepared);
    }
    free(job->frames);
    job->frames = NULL;
    job->frame_count = job->frames_opened = job->frames_finished = 0;
    job->recalls = 0;
}

void active_job_drop_frames(struct active_job *job)
{
    struct active_frame *frame;
    while ((frame = first_in_work(job))) {
        active_job_close_work(job, frame);
        queue_again(job, frame);
    }
}

void active_job_prioritize(struct active_job *job, const struct tile_priority *priority)
{
    job->tile_priority = *priority;
    for (unsigned i = 0; i < job->jobs->open_count; i++)
        if (job->jobs->open[i].job == job && (!job->view || live_view_scale(job) == 1))
            frame_steer(job->jobs->open[i].frame->work, priority);
}

static struct active_job *job_of(struct jobs *jobs, const struct frame *work,
                                 struct active_frame **frame)
{
    struct open_frame *open = jobs_table_frame(jobs, frame_id(work));
    assert(open);
    *frame = open->frame;
    return open->job;
}

/* Counts a damaged result against its worker, which is in quarantine after the third. When no
 * worker is left then, waiting jobs must be told. */
static void count_corrupt(struct jobs *jobs, const struct frame *work, uint64_t worker)
{
    if (!fleet_strike(jobs->fleet, worker) || fleet_count(jobs->fleet) > 0) return;
    const struct fault *refusal = frame_refusal(work);
    struct fault fault;
    fault_set(
        &fault, ERR_CORRUPT, "",
        "no worker is left: each is in quarantine after %d results that do not fit the plan, the "
        "last one at \"%.100s\": %.200s",
        WORKER_HEALTH_STRIKES, refusal->pointer, refusal->detail);
    jobs_fail_unless_joined(jobs, &fault);
}

/* Returns a rect in pixels of the full picture, whatever the level in work. */
static struct rect place_of(const struct active_job *job, struct rect r)
{
    const struct plan *plan = &job->prepared->plan;
    const int32_t scale = job->view ? live_view_scale(job) : 1;
    const struct rect scaled = {r.x0 * scale, r.y0 * scale, r.x1 * scale, r.y1 * scale};
    return rect_intersect(scaled, (struct rect){0, 0, plan->width_px, plan->height_px});
}

/* Notes a tile, which is reported with the next progress. An event for each tile would cost more
 * than all other book-keeping of it. */
static void note_tile(struct active_job *job, const struct frame *work,
                      const struct message_ack *ack, uint64_t worker)
{
    job->last_tile = place_of(job, frame_tile_rect(work, ack->index));
    job->last_tile_frame = frame_number(work);
    job->last_tile_worker = worker;
}

static void log_corrupt(struct active_job *job, const struct frame *work, uint64_t worker)
{
    const char *name = fleet_worker_name(job->jobs->fleet, worker);
    const struct fault *refusal = frame_refusal(work);
    active_job_log(job, "tiles",
                   "a result of %s is refused, its tile given out again: %.100s: %.200s",
                   name ? name : "a worker that has left", refusal->pointer, refusal->detail);
}

static void on_judged(void *ctx, struct frame *work, uint64_t worker, const struct message_ack *ack)
{
    struct jobs *jobs = ctx;
    struct active_frame *frame;
    struct active_job *job = job_of(jobs, work, &frame);
    fleet_ack(jobs->fleet, worker, ack);
    if (ack->verdict == VERDICT_ACCEPTED) {
        note_tile(job, work, ack, worker);
        jobs_progress_soon(jobs, job);
        const struct plan *plan = active_frame_plan(job, frame);
        /* A tile that has landed waits for its next pass. */
        if (plan_pass_count(plan) > 1 || plan_has_rounds(plan)) fleet_wake(jobs->fleet);
        return;
    }
    if (ack->verdict == VERDICT_CORRUPT) {
        log_corrupt(job, work, worker);
        count_corrupt(jobs, work, worker);
    }
    fleet_wake(jobs->fleet);
}

static void on_drawn(void *ctx, struct frame *work, struct rect rect)
{
    struct jobs *jobs = ctx;
    struct active_frame *frame;
    struct active_job *job = job_of(jobs, work, &frame);
    if (job->view) live_view_drawn(job, rect);
    if (job->shown == frame) stream_pixels(jobs->options.streams, job->id, rect);
    jobs_progress_soon(jobs, job);
    if (frame_was_held(work)) fleet_wake(jobs->fleet);
}

static void on_extended(void *ctx, struct frame *work)
{
    struct jobs *jobs = ctx;
    struct active_frame *frame;
    struct active_job *job = job_of(jobs, work, &frame);
    if (is_alone(job, frame)) {
        active_job_pace_note(job);
        pace_rest(&job->pace, jobs_clock_us());
    }
    jobs_progress_soon(jobs, job);
    fleet_wake(jobs->fleet);
}

static void on_traced(void *ctx, struct frame *work)
{
    struct jobs *jobs = ctx;
    fleet_cancel(jobs->fleet, frame_id(work));
    jobs_advance_soon(jobs);
}

/* Its owner may drop it now, in the middle of its own work: the jobs look at it soon. */
static void on_completed(void *ctx, struct frame *work)
{
    (void)work;
    jobs_advance_soon(ctx);
}

static void on_failed(void *ctx, struct frame *work, const struct fault *fault)
{
    struct active_frame *frame;
    struct active_job *job = job_of(ctx, work, &frame);
    if (frame_was_given_up(work))
        active_job_fail(job, fault);
    else
        active_job_fail_or_retry(job, fault);
    jobs_advance_soon(ctx);
}

static void on_unstored(void *ctx, struct frame *work, const struct fault *fault)
{
    struct active_frame *frame;
    struct active_job *job = job_of(ctx, work, &frame);
    active_job_retry_store(job, frame, fault);
}

/* Notes what a frame has got beyond its plan, and its warnings. */
static void note_end(struct active_job *job, const struct frame *work)
{
    json_t *warnings = json_object_get(job->plan, "warnings");
    job->tiles_beyond += frame_tiles_total(work) - frame_tiles_planned(work);
    if (frame_warning(work)[0] == '\0') return;
    active_job_log(job, "warning", "frame %d: %s", frame_number(work), frame_warning(work));
    if (json_array_size(warnings) < LIMIT_WARNINGS)
        json_array_append_new(warnings, json_string(frame_warning(work)));
}

static void on_encoded(void *ctx, struct frame *work, const struct digest *exr,
                       const struct digest *png)
{
    struct jobs *jobs = ctx;
    struct active_frame *frame;
    struct active_job *job = job_of(jobs, work, &frame);
    frame->exr = *exr;
    frame->png = *png;
    if (frame->state == FRAME_RENDERING) frame_state_go(&frame->state, FRAME_ENCODING);
    note_end(job, work);
    active_job_log(job, "frame", "frame %d is drawn and encoded", active_frame_number(job, frame));
    active_job_keep_history(job, frame);
    active_job_close_work(job, frame);
    prepared_destroy(&frame->prepared);
    active_job_record_frame(job, frame);
    jobs_advance_soon(jobs);
}

/* A drawn frame that was recalled has given all that it was recalled for. */
static void on_waits(void *ctx, struct frame *work)
{
    struct jobs *jobs = ctx;
    struct active_frame *frame;
    struct active_job *job = job_of(jobs, work, &frame);
    if (frame->recalled) {
        active_job_keep_history(job, frame);
        active_job_close_work(job, frame);
        prepared_destroy(&frame->prepared);
        frame->recalled = false;
    }
    active_job_draw_windows(job, frame);
    jobs_advance_soon(jobs);
}

struct frame_events active_job_frame_events(struct jobs *jobs)
{
    return (struct frame_events){.ctx = jobs,
                                 .judged = on_judged,
                                 .drawn = on_drawn,
                                 .extended = on_extended,
                                 .traced = on_traced,
                                 .waits = on_waits,
                                 .completed = on_completed,
                                 .encoded = on_encoded,
                                 .unstored = on_unstored,
                                 .failed = on_failed};
}
