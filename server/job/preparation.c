#include "server/job/preparation.h"

#include <stdlib.h>
#include <string.h>

struct preparation {
    struct team_task task; /* first */
    struct team *team;
    const struct objects *objects;
    struct import_request *request;
    struct prepared *prepared; /* owned until told */
    struct digest blob;
    struct fault fault;
    bool planning; /* on the team */
    bool cancelled;
    preparation_done done;
    void *ctx;
};

static void destroy(struct preparation *p)
{
    prepared_destroy(&p->prepared);
    free(p);
}

static void plan_run(struct team_task *task)
{
    struct preparation *p = (struct preparation *)task;
    struct prepared *out = p->prepared;
    struct scene scene;
    char path[OBJECTS_PATH_BYTES];
    objects_path(p->objects, &p->blob, path);
    p->fault.code = scene_map(path, &scene, &p->fault);
    if (p->fault.code) return;
    p->fault.code = plan_make(&out->job, &scene, &p->blob, out->job.first_frame, &out->plan,
                              &out->report, &p->fault);
    scene_unmap(&scene);
}

static void tell(struct preparation *p)
{
    struct prepared *prepared = p->fault.code ? NULL : p->prepared;
    if (prepared) p->prepared = NULL;
    p->done(p->ctx, p->fault.code ? &p->fault : NULL, prepared);
    destroy(p);
}

static void plan_done(struct team_task *task)
{
    struct preparation *p = (struct preparation *)task;
    if (p->cancelled) {
        destroy(p);
        return;
    }
    p->prepared->plan_cpu_us = task->cpu_us;
    tell(p);
}

static void imported(void *ctx, const struct fault *fault, const struct digest *blob,
                     uint64_t cpu_us)
{
    struct preparation *p = ctx;
    p->request = NULL;
    if (fault) {
        p->fault = *fault;
        tell(p);
        return;
    }
    p->blob = *blob;
    p->prepared->import_cpu_us = cpu_us;
    p->planning = true;
    p->task = (struct team_task){.run = plan_run, .done = plan_done};
    team_submit(p->team, &p->task);
}

int preparation_start(struct imports *imports, struct team *team, const struct objects *objects,
                      struct job *job, preparation_done done, void *ctx, struct preparation **out)
{
    struct preparation *p = calloc(1, sizeof *p);
    struct prepared *prepared = calloc(1, sizeof *prepared);
    if (!p || !prepared) {
        free(p);
        free(prepared);
        job_fini(job);
        return ERR_MEMORY;
    }
    prepared->job = *job;
    memset(job, 0, sizeof *job);
    *p = (struct preparation){
        .team = team, .objects = objects, .prepared = prepared, .done = done, .ctx = ctx};
    int error = imports_request(imports, &prepared->job, imported, p, &p->request);
    if (error) {
        destroy(p);
        return error;
    }
    *out = p;
    return 0;
}

void preparation_cancel(struct preparation **preparation)
{
    struct preparation *p = *preparation;
    *preparation = NULL;
    if (!p) return;
    p->cancelled = true;
    if (p->request) imports_forget(&p->request);
    if (!p->planning) destroy(p);
}

void prepared_destroy(struct prepared **prepared)
{
    if (*prepared) job_fini(&(*prepared)->job);
    free(*prepared);
    *prepared = NULL;
}
