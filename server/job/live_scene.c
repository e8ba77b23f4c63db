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
    view->waiting = move->next;
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
    view->alone -= view->alone > 0;
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
    if (view->level > 0 || view->shown || job->state != JOB_RUNNING)
        live_scene_take(job);
    else
        jobs_retry_soon(job->jobs);
}

void live_scene_take(struct active_job *job)
{
    struct live_view *view = job->view;
    struct fault fault = {0};
    struct prepared *prepared = view->ready;
    const unsigned count = view->covered;
    if (!prepared) return;
    view->ready = NULL;
    int error = live_view_check(job, &fault);
    if (!error) error = live_view_take_scene(job, prepared, &fault);
    if (error) prepared_destroy(&prepared);
    if (job->view != view) return; /* it has begun again, and all were answered */
    if (error) refuse(job, count, &fault);
    for (unsigned i = 0; !error && i < count; i++) answer_first(job, NULL);
    go_on(job);
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

int live_scene_wait(struct active_job *job, const char *text, size_t size_bytes, jobs_moved done,
                    void *ctx)
{
    struct live_move **end = &job->view->waiting;
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
