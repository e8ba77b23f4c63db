/* The scenes of a live view whose nodes are moved: the scene is imported again, by a run that has
 * the base already, and only then takes the place of the one before. Moves that come meanwhile wait
 * together for the next, and a scene waits until something of the view before is seen, so that
 * steady moves show where they go. If a scene of several moves cannot be made, each of these gets
 * one of its own, so that only what is wrong is refused. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/jobs_table.h"
#include "server/job/live_view.h"

void live_scene_point_into_body(struct fault *fault)
{
    static const char *const members[] = {"/scene/camera", "/scene/moves"};
    const size_t scene = strlen("/scene");
    for (size_t i = 0; i < sizeof members / sizeof *members; i++)
        if (strncmp(fault->pointer, members[i], strlen(members[i])) == 0) {
            memmove(fault->pointer, fault->pointer + scene, strlen(fault->pointer) - scene + 1);
            return;
        }
}

/* A move that waits, in the order in which they came. */
struct live_move {
    struct live_move *next;
    char *text;
    size_t size_bytes;
    jobs_moved done;
    void *ctx;
};

static void answer_first(struct active_job *job, const struct fault *fault)
{
    struct live_view *view = job->view;
    struct live_move *move = view->waiting;
    if (!move) return; /* all were given up meanwhile */
    view->waiting = move->next;
    view->alone -= view->alone > 0;
    jobs_answer_move(job, fault, move->done, move->ctx);
    free(move->text);
    free(move);
}

/* What the first `count` moves make of the document; it borrows the files. Returns how many. */
static unsigned apply(const struct active_job *job, unsigned count, struct job *document)
{
    struct fault ignored;
    unsigned applied = 0;
    *document = job->prepared->job;
    for (const struct live_move *m = job->view->waiting; m && applied < count; m = m->next) {
        struct job moved = *document;
        if (job_view_read(m->text, m->size_bytes, &moved, &ignored) == 0) *document = moved;
        applied++;
    }
    return applied;
}

void live_scene_coming(const struct active_job *job, struct job *document)
{
    apply(job, UINT_MAX, document);
}

/* So long a scene waits at most. */
#define SHOW_US 500000u

/* So long the view before is on the feed at least: readers get what is there now and then. */
#define SEEN_US 100000u

static void go_on(struct active_job *job);

/* Refuses the only move of the scene, or has each of several try alone. */
static void refuse(struct active_job *job, unsigned count, const struct fault *fault)
{
    if (count > 1)
        job->view->alone = count;
    else
        answer_first(job, fault);
}

static void on_prepared(void *ctx, const struct fault *told, struct prepared *prepared)
{
    struct active_job *job = ctx;
    struct live_view *view = job->view;
    struct fault fault = {0};
    const unsigned count = view->covered;
    view->preparation = NULL;
    if (told) {
        fault = *told;
        live_scene_point_into_body(&fault);
        refuse(job, count, &fault);
        go_on(job);
        return;
    }
    job->statistics.import_cpu_us += prepared->import_cpu_us;
    job->jobs->past.import_cpu_us += prepared->import_cpu_us;
    view->ready = prepared;
    view->ready_us = jobs_clock_us() + SHOW_US;
    if (live_scene_take(job)) jobs_retry_soon(job->jobs);
}

static bool is_time(const struct live_view *view)
{
    const uint64_t now_us = jobs_clock_us();
    return now_us >= view->ready_us || (view->shown_us > 0 && now_us >= view->shown_us + SEEN_US);
}

static void take(struct active_job *job)
{
    struct live_view *view = job->view;
    struct fault fault = {0};
    struct prepared *prepared = view->ready;
    const unsigned count = view->covered;
    view->ready = NULL;
    int error = live_view_check(job, &fault);
    if (!error) error = live_view_take_scene(job, prepared, &fault);
    if (error) prepared_destroy(&prepared);
    if (job->view != view) return; /* it has begun again, and all were answered */
    if (error) refuse(job, count, &fault);
    for (unsigned i = 0; !error && i < count; i++) answer_first(job, NULL);
    go_on(job);
}

bool live_scene_take(struct active_job *job)
{
    const struct live_view *view = job->view;
    if (!view || !view->ready) return false;
    if (!is_time(view)) return true;
    take(job);
    return job->view && job->view->ready;
}

static int prepare(struct active_job *job, const struct job *document)
{
    struct jobs *jobs = job->jobs;
    struct job taken;
    const int error = job_copy(document, &taken);
    if (error) return error;
    return preparation_start(jobs->imports, jobs->options.pool, jobs->options.objects, &taken,
                             job_frame_number(document, 0), job->prepared->base, on_prepared, job,
                             &job->view->preparation);
}

/* Prepares the scene of what waits, unless one is being prepared. */
static void go_on(struct active_job *job)
{
    struct live_view *view = job->view;
    struct fault fault;
    struct job document;
    while (view->waiting && !view->preparation && !view->ready) {
        view->covered = apply(job, view->alone > 0 ? 1 : UINT_MAX, &document);
        const int error = prepare(job, &document);
        if (!error) return;
        fault_set(&fault, error, "", "no memory to move nodes");
        for (unsigned i = 0; i < view->covered; i++) answer_first(job, &fault);
    }
}

/* Returns whether one more may wait, since each that comes reads all before it. */
static bool has_room(const struct live_view *view, size_t size_bytes)
{
    unsigned count = 0;
    for (const struct live_move *m = view->waiting; m; m = m->next, count++)
        size_bytes += m->size_bytes;
    return count < LIMIT_WAITING_MOVES && size_bytes <= LIMIT_WAITING_MOVES_BYTES;
}

int live_scene_wait(struct active_job *job, const char *text, size_t size_bytes, jobs_moved done,
                    void *ctx)
{
    struct live_move **end = &job->view->waiting;
    if (!has_room(job->view, size_bytes)) return ERR_FULL;
    struct live_move *move = malloc(sizeof *move);
    char *copy = malloc(size_bytes + 1);
    if (!move || !copy) {
        free(move);
        free(copy);
        return ERR_MEMORY;
    }
    memcpy(copy, text, size_bytes);
    *move = (struct live_move){.text = copy, .size_bytes = size_bytes, .done = done, .ctx = ctx};
    while (*end) end = &(*end)->next;
    *end = move;
    go_on(job);
    return 0;
}

void live_scene_give_up(struct active_job *job)
{
    struct fault fault;
    preparation_cancel(&job->view->preparation);
    prepared_destroy(&job->view->ready);
    job->view->alone = 0;
    fault_set(&fault, ERR_STATE, "", "the job has ended, or begins again: nothing was moved");
    while (job->view->waiting) answer_first(job, &fault);
}
