#include "server/job/live_view.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job.h"
#include "proto/json.h"
#include "server/job/jobs_table.h"

/* Makes a plan for each level. *report is that of the last. */
static int plan_levels(const struct prepared *prepared, const struct job *document,
                       struct plan plans[VIEW_LEVELS_MAX], struct plan_report *report,
                       struct fault *fault)
{
    const struct plan_source source = prepared_source(prepared);
    const unsigned last = view_levels(document) - 1;
    struct job coarse;
    struct plan_report coarse_report;
    int error =
        plan_make(document, &source, job_frame_number(document, 0), &plans[last], report, fault);
    for (unsigned level = 0; !error && level < last; level++) {
        view_level_document(document, level, &coarse);
        error = plan_make(&coarse, &source, job_frame_number(document, 0), &plans[level],
                          &coarse_report, fault);
        plans[level].camera = plans[last].camera;
    }
    return error;
}

/* Makes a plate of each level's size, where there is a photograph. */
static int plate_levels(struct live_view *view, struct plate *full)
{
    const unsigned last = view->levels - 1;
    int error = 0;
    view->plates[last] = plate_hold(full);
    for (unsigned level = 0; full && level < last && !error; level++)
        error = plate_shrink(full, view->plans[level].width_px, view->plans[level].height_px,
                             &view->plates[level]);
    return error;
}

static void drop_plates(struct live_view *view)
{
    for (unsigned level = 0; level < VIEW_LEVELS_MAX; level++) plate_drop(&view->plates[level]);
}

int live_view_create(struct active_job *job, uint32_t number, struct fault *fault)
{
    struct live_view *view = calloc(1, sizeof *view);
    struct plan_report *report = malloc(sizeof *report);
    int error = ERR_MEMORY;
    if (view && report)
        error = plan_levels(job->prepared, &job->prepared->job, view->plans, report, fault);
    else
        fault_set(fault, error, "", "no memory for a live job");
    free(report);
    if (!error) {
        view->levels = view_levels(&job->prepared->job);
        error = plate_levels(view, job->prepared->plate);
        if (error) fault_set(fault, error, "/backplate", "no memory for the photograph");
    }
    if (error) {
        if (view) drop_plates(view);
        free(view);
        return error;
    }
    view->number = number;
    view->moved_us = jobs_clock_us();
    job->view = view;
    return 0;
}

static void drop_last(struct live_view *view)
{
    if (view->last) frame_drop(&view->last);
}

void live_view_hide(struct active_job *job)
{
    if (!job->jobs->stopping) stream_image(job->jobs->options.streams, job->id, NULL);
    job->view->shown = false;
    drop_last(job->view);
}

void live_view_destroy(struct active_job *job)
{
    if (!job->view) return;
    drop_last(job->view);
    drop_plates(job->view);
    live_scene_give_up(job);
    free(job->view);
    job->view = NULL;
}

int live_view_check(const struct active_job *job, struct fault *fault)
{
    if (!job->live)
        return fault_set(fault, ERR_STATE, "", "its camera cannot be moved: it is not a live job");
    if (!job->view || (job->state != JOB_RUNNING && job->state != JOB_RESTING))
        return fault_set(fault, ERR_STATE, "", "it is %s: its camera can be moved once it runs",
                         job_state_name(job->state));
    if (job->frames[0].state != FRAME_QUEUED && job->frames[0].state != FRAME_RENDERING)
        return fault_set(fault, ERR_STATE, "", "it is ending: its files are being made");
    return 0;
}

/* The document as it now is, for a restart. */
static void record(struct active_job *job, job_store_done done)
{
    struct job_store *store = job->jobs->options.store;
    json_t *document = job_write(&job->prepared->job), *report = active_job_report(job);
    char *report_text = json_text(report, JSON_COMPACT);
    char *text = json_text(document, JSON_COMPACT);
    if (text && report_text) {
        job_store_update_document(store, job->id, text, NULL, NULL);
        job_store_update(store, job->id, job_state_name(job->state), NULL, report_text, done, job);
    } else if (done) {
        done(job, ERR_MEMORY);
    }
    free(text);
    free(report_text);
    json_decref(document);
    json_decref(report);
}

static void record_newest(struct active_job *job);

static void on_recorded(void *ctx, int error)
{
    struct active_job *job = ctx;
    job->holds--;
    if (job->gone) {
        active_job_release(job);
        return;
    }
    if (!job->view) return; /* it begins again */
    job->view->recording = false;
    if (job->view->dirty)
        record_newest(job);
    else
        job->view->dirty = error != 0; /* the next one says it, or the end */
}

/* Records the newest view. Nothing waits for it, and the store has one recording at a time, so that
 * moves do not queue there. */
static void record_newest(struct active_job *job)
{
    struct live_view *view = job->view;
    view->dirty = view->recording;
    if (view->recording) return;
    view->recording = true;
    job->holds++;
    record(job, on_recorded);
}

void live_view_keep(struct active_job *job)
{
    if (!job->view || !job->view->dirty) return;
    job->view->dirty = false;
    record(job, NULL);
}

static void go(struct active_job *job, enum job_state state)
{
    if (job->state == state) return;
    jobs_set_state(job->jobs, job, state);
    job->revision++;
    jobs_event_state(job);
}

/* The frame of the first level, in the place of the one that was open; a job that had none waits on
 * for a place. */
static void begin(struct active_job *job)
{
    const bool has_place = job->frames_opened > 0;
    live_view_hide(job);
    active_job_drop_frames(job);
    job->view->level = 0;
    job->view->shown_us = 0;
    job->pace.started_us = 0;
    go(job, JOB_RUNNING);
    jobs_progress_soon(job->jobs, job);
    if (has_place && active_job_has_unopened(job)) active_job_open_frame(job);
}

/* Takes a view of a scene, the job's or a new one. */
static int take(struct active_job *job, struct prepared *prepared, const struct job *moved,
                const struct plan *plans, const struct plan_report *report, struct fault *fault)
{
    struct live_view *view = job->view;
    char fingerprint[FINGERPRINT_BYTES];
    json_t *plan = active_job_plan_json(prepared, &plans[view->levels - 1], report);
    if (!plan || fingerprint_of(moved, fingerprint) != 0) {
        json_decref(plan);
        return fault_set(fault, ERR_MEMORY, "", "no memory to plan this view");
    }
    json_decref(job->plan);
    job->plan = plan;
    job->prepared = prepared;
    memcpy(job->fingerprint, fingerprint, sizeof job->fingerprint);
    if (moved != &prepared->job) prepared->job = *moved;
    prepared->report = *report;
    prepared->plan = plans[view->levels - 1];
    memcpy(view->plans, plans, sizeof view->plans);
    view->number++;
    return 0;
}

/* Plans a view and takes it. */
static int plan_and_take(struct active_job *job, struct prepared *prepared, const struct job *moved,
                         struct fault *fault)
{
    struct plan_report *report = malloc(sizeof *report);
    struct plan *plans = calloc(VIEW_LEVELS_MAX, sizeof *plans);
    int error = ERR_MEMORY;
    if (report && plans) {
        error = plan_levels(prepared, moved, plans, report, fault);
        if (error) live_scene_point_into_body(fault);
    } else {
        fault_set(fault, error, "", "no memory to plan this view");
    }
    if (!error) error = take(job, prepared, moved, plans, report, fault);
    free(report);
    free(plans);
    return error;
}

int live_view_move(struct active_job *job, const char *text, size_t size_bytes, bool *waits,
                   struct fault *fault)
{
    struct live_view *view = job->view;
    struct job moved;
    live_scene_coming(job, &moved);
    int error = job_view_read(text, size_bytes, &moved, fault);
    if (error) return error;
    view->moved_us = jobs_clock_us();
    *waits = view->waiting || !job_moves_equal(&moved.moves, &job->prepared->job.moves);
    if (*waits) return 0;
    error = plan_and_take(job, job->prepared, &moved, fault);
    if (error) return error;
    begin(job);
    if (!job->view)
        return fault_set(fault, ERR_MEMORY, "", "no memory for this view: it begins again");
    if (!job_state_is_final(job->state)) record_newest(job);
    return 0;
}

int live_view_take_scene(struct active_job *job, struct prepared *prepared, struct fault *fault)
{
    struct prepared *before = job->prepared;
    int error = plan_and_take(job, prepared, &prepared->job, fault);
    if (error) return error;
    plate_drop(&prepared->plate); /* that of the view's levels is the same */
    prepared->plate = plate_hold(before->plate);
    begin(job);
    prepared_destroy(&before);
    if (job->view && !job_state_is_final(job->state)) record_newest(job);
    return 0;
}

struct plate *live_view_plate(const struct active_job *job)
{
    return job->view->plates[job->view->level];
}

const struct plan *live_view_plan(const struct active_job *job)
{
    return &job->view->plans[job->view->level];
}

int32_t live_view_scale(const struct active_job *job)
{
    return view_level_scale(&job->prepared->job, job->view->level);
}

static bool is_last(const struct live_view *view)
{
    return view->level + 1 == view->levels;
}

/* Puts the level in work on the feed, in place of what was there. */
static void show(struct active_job *job)
{
    struct live_view *view = job->view;
    const struct job *document = &job->prepared->job;
    const struct stream_view told = {
        .number = view->number, .width_px = document->width_px, .height_px = document->height_px};
    if (view->shown) return;
    stream_view(job->jobs->options.streams, job->id, frame_image(job->frames[0].work), &told);
    view->shown = true;
    if (view->shown_us == 0) view->shown_us = jobs_clock_us();
    drop_last(view);
}

void live_view_drawn(struct active_job *job, struct rect rect)
{
    if (!is_last(job->view)) return;
    show(job);
    stream_pixels(job->jobs->options.streams, job->id, rect);
}

static void show_whole(struct active_job *job)
{
    const struct plan *plan = live_view_plan(job);
    show(job);
    stream_pixels(job->jobs->options.streams, job->id,
                  (struct rect){0, 0, plan->width_px, plan->height_px});
}

static void next_level(struct active_job *job)
{
    struct live_view *view = job->view;
    show_whole(job);
    view->last = active_job_take_work(job, &job->frames[0]);
    view->shown = false;
    view->level++;
    job->pace.started_us = 0;
    active_job_open_frame(job);
}

void live_view_completed(struct active_job *job)
{
    if (!is_last(job->view)) {
        next_level(job);
        live_scene_take(job);
        return;
    }
    if (!job->view->shown) show_whole(job);
    if (job->state != JOB_RUNNING) return;
    go(job, JOB_RESTING);
    jobs_watch_idle(job->jobs);
    record_newest(job);
    live_scene_take(job);
}

void live_view_end(struct active_job *job)
{
    assert(job->state == JOB_RESTING);
    frame_store(job->frames[0].work);
}

json_t *live_view_json(const struct active_job *job)
{
    return json_pack("{s:I,s:i,s:b}", "number", (json_int_t)job->view->number, "scale",
                     (int)live_view_scale(job), "complete", (int)(job->state != JOB_RUNNING));
}
