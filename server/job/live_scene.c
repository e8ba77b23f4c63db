/* The scene of a live view whose nodes are moved: it is imported again, by a run that has the base
 * already, and only then takes the place of the one before. */
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

static void forget(struct live_view *view)
{
    if (view->coming) job_fini(view->coming);
    free(view->coming);
    view->coming = NULL;
    preparation_cancel(&view->preparation);
}

static void on_prepared(void *ctx, const struct fault *told, struct prepared *prepared)
{
    struct active_job *job = ctx;
    struct fault fault = {0};
    job->view->preparation = NULL;
    forget(job->view);
    if (told) {
        fault = *told;
        live_scene_point_into_body(&fault);
        jobs_answer_moves(job, &fault);
        return;
    }
    job->statistics.import_cpu_us += prepared->import_cpu_us;
    job->jobs->past.import_cpu_us += prepared->import_cpu_us;
    int error = live_view_check(job, &fault);
    if (!error) error = live_view_take_scene(job, prepared, &fault);
    if (error) prepared_destroy(&prepared);
    if (job->view) jobs_answer_moves(job, error ? &fault : NULL);
}

int live_scene_prepare(struct active_job *job, const struct job *document, struct fault *fault)
{
    struct live_view *view = job->view;
    struct jobs *jobs = job->jobs;
    struct preparation *next = NULL;
    struct job taken;
    struct job *coming = calloc(1, sizeof *coming);
    int error = coming ? job_copy(document, coming) : ERR_MEMORY;
    if (!error) {
        error = job_copy(document, &taken);
        if (!error)
            error = preparation_start(jobs->imports, jobs->options.pool, jobs->options.objects,
                                      &taken, job_frame_number(document, 0), job->prepared->base,
                                      on_prepared, job, &next);
        if (error) job_fini(coming);
    }
    if (error) {
        free(coming);
        return fault_set(fault, error, "", "no memory to move nodes");
    }
    forget(view); /* after the start, since both may wait for one import */
    view->coming = coming;
    view->preparation = next;
    return 0;
}

void live_scene_give_up(struct active_job *job)
{
    struct fault fault;
    forget(job->view);
    fault_set(&fault, ERR_STATE, "", "the job has ended, or begins again: nothing was moved");
    jobs_answer_moves(job, &fault);
}
