/* Calling jobs off, and removing those that have ended. */
#include <stdlib.h>
#include <string.h>

#include "server/job/jobs_table.h"

/* A cancellation that ends in a removal, or of a job that is not in the table. */
struct cancellation {
    struct jobs *jobs;
    struct principal principal;
    char id[JOB_ID_BYTES];
    bool purge;
    job_store_done done;
    void *ctx;
};

static void on_removed(void *ctx, int error)
{
    struct cancellation *c = ctx;
    if (!c->jobs->stopping) stream_forget(c->jobs->options.streams, c->id);
    c->done(c->ctx, error);
    free(c);
}

static void on_cancelled(void *ctx, int error)
{
    struct cancellation *c = ctx;
    if (!error && c->purge) {
        job_store_remove(c->jobs->options.store, c->id, on_removed, c);
        return;
    }
    c->done(c->ctx, error);
    free(c);
}

static void on_found_ended(void *ctx, int error, const struct job_row *row,
                           const struct frame_row *frames, size_t frame_count)
{
    struct cancellation *c = ctx;
    (void)frames, (void)frame_count;
    if (!error && (!row || !principal_sees(&c->principal, row->owner))) error = ERR_NOT_FOUND;
    if (!error && !c->purge) error = ERR_STATE;
    on_cancelled(c, error);
}

void jobs_cancel(struct jobs *jobs, const struct principal *principal, const char *id, bool purge,
                 job_store_done done, void *ctx)
{
    struct cancellation *c = job_id_is_valid(id) ? calloc(1, sizeof *c) : NULL;
    if (!c) {
        done(ctx, job_id_is_valid(id) ? ERR_MEMORY : ERR_NOT_FOUND);
        return;
    }
    *c = (struct cancellation){
        .jobs = jobs, .principal = *principal, .purge = purge, .done = done, .ctx = ctx};
    memcpy(c->id, id, sizeof c->id);
    struct active_job *job = jobs_table_find(jobs, id);
    if (job && principal_sees(principal, job->owner) && !job_state_is_final(job->state) &&
        !jobs->stopping)
        active_job_cancel(job, on_cancelled, c);
    else
        job_store_get(jobs->options.store, id, on_found_ended, c);
}
