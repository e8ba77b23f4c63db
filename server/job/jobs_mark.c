/* Changing how people find a job: its name, comment and labels, also after it has ended. */
#include <stdlib.h>
#include <string.h>

#include "proto/json.h"
#include "server/job/jobs_table.h"

struct marking {
    struct jobs *jobs;
    char id[JOB_ID_BYTES];
    job_store_done done;
    void *ctx;
};

static void on_durable(void *ctx, int error)
{
    struct marking *m = ctx;
    struct active_job *job = jobs_table_find(m->jobs, m->id);
    if (!error && job && !m->jobs->stopping) {
        job->revision++;
        jobs_event_state(job);
    }
    m->done(m->ctx, error);
    free(m);
}

void jobs_mark(struct jobs *jobs, const struct principal *principal, const char *id,
               uint64_t seen_revision, const json_t *marks, job_store_done done, void *ctx)
{
    struct active_job *job = jobs_table_find(jobs, id);
    const bool stale = job && seen_revision && seen_revision != job->revision;
    struct marking *m = !stale && job_id_is_valid(id) ? malloc(sizeof *m) : NULL;
    char *text = m ? json_text(marks, JSON_COMPACT) : NULL;
    if (!text) {
        free(m);
        done(ctx, stale ? ERR_MISMATCH : job_id_is_valid(id) ? ERR_MEMORY : ERR_NOT_FOUND);
        return;
    }
    *m = (struct marking){.jobs = jobs, .done = done, .ctx = ctx};
    memcpy(m->id, id, sizeof m->id);
    if (job) job->revision++; /* others that saw this one come too late */
    job_store_mark(jobs->options.store, id, principal->sees_all ? NULL : principal->owner,
                   job ? 0 : seen_revision, text, on_durable, m);
    free(text);
}
