/* Taking jobs in, and trying them out. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/json.h"
#include "server/job/jobs_table.h"
#include "server/reconstruct/oidn/oidn_library.h"

/* Lists all that the job names: the scene, its files, the map, the backplate. The caller owns the
 * list. */
static struct digest *list_assets(const struct job *job, size_t *count)
{
    struct digest *list = calloc((size_t)job->file_count + 3, sizeof *list);
    if (!list) return NULL;
    list[0] = job->scene;
    for (uint32_t i = 0; i < job->file_count; i++) list[i + 1] = job->files[i].asset;
    *count = (size_t)job->file_count + 1;
    if (job->environment.kind == ENVIRONMENT_MAP) list[(*count)++] = job->environment.asset;
    if (job->composite.has_plate) list[(*count)++] = job->composite.plate;
    return list;
}

/* The one at that place of the list. */
static void set_missing(struct fault *fault, const struct job *job, size_t at)
{
    char hex[DIGEST_HEX_BYTES], pointer[LIMIT_POINTER_BYTES] = "/scene/asset";
    const struct digest *asset = &job->scene;
    const bool has_map = job->environment.kind == ENVIRONMENT_MAP;
    if (at > job->file_count + (has_map ? 1 : 0)) {
        asset = &job->composite.plate;
        strcpy(pointer, "/backplate/asset");
    } else if (at > job->file_count) {
        asset = &job->environment.asset;
        strcpy(pointer, "/environment/asset");
    } else if (at > 0) {
        asset = &job->files[at - 1].asset;
        snprintf(pointer, sizeof pointer, "/scene/files/%.200s", job->files[at - 1].path);
    }
    digest_to_hex(asset, hex);
    fault_set(fault, ERR_NOT_FOUND, pointer, "asset %s is not here; PUT it first", hex);
}

bool jobs_needs_library(const struct job *job)
{
    return job->residual == RESIDUAL_OIDN;
}

void jobs_load_library(void)
{
    struct fault fault;
    (void)oidn_library_get(&fault);
}

static int check_new(const struct jobs *jobs, const struct job *job, struct fault *fault)
{
    if (jobs->stopping) return fault_set(fault, ERR_STATE, "", "the server is shutting down");
    if (jobs->count >= LIMIT_JOBS_WAITING)
        return fault_set(fault, ERR_FULL, "", "%zu jobs are waiting already", jobs->count);
    const char *url = job->marks.webhook;
    if (url && webhooks_check(jobs->options.webhooks, url, fault) != 0) return fault->code;
    if (jobs_needs_library(job) && !oidn_library_get(fault)) return fault->code;
    const unsigned live = jobs->live_count + jobs->live_coming;
    if (job->live && live >= LIVE_MAX)
        return fault_set(fault, ERR_FULL, "", "%u live jobs are open already: cancel one first",
                         live);
    return 0;
}

/* Takes a place in the tenant's quota. Jobs without a tenant need none. */
static int take_place(struct jobs *jobs, const struct principal *principal, struct fault *fault)
{
    const size_t most = jobs->options.tenant_jobs_max;
    const int error =
        principal->owner[0] ? job_counts_take(&jobs->counts, principal->owner, most) : 0;
    if (error == ERR_QUOTA)
        fault_set(fault, error, "",
                  "the tenant has %zu jobs that have not ended, as many as it may", most);
    else if (error)
        fault_set(fault, error, "", "no memory for one more job");
    return error;
}

struct submission {
    struct jobs *jobs;
    struct active_job *job; /* made beforehand: a durable job must not fail for want of memory */
    struct job asked;       /* owned */
    size_t missing;         /* of its assets */
    jobs_submitted done;
    void *ctx;
};

static void free_submission(struct submission *s)
{
    job_fini(&s->asked);
    free(s);
}

static void take_in(struct submission *s)
{
    struct jobs *jobs = s->jobs;
    struct active_job *job = s->job;
    char id[JOB_ID_BYTES];
    memcpy(id, job->id, sizeof id);
    if (jobs->stopping) {
        active_job_release(job);
    } else {
        const int error = jobs_table_add(jobs, job);
        assert(!error); /* it has had its place */
        jobs->submitted++;
        active_job_log_accepted(job);
        jobs_event_state(job);
        jobs_advance_soon(jobs);
    }
    s->done(s->ctx, NULL, id, false);
}

static void on_inserted(void *ctx, int error, const char *existing)
{
    struct submission *s = ctx;
    struct fault fault;
    s->jobs->live_coming -= s->job->live;
    s->jobs->coming--;
    if (!error) {
        take_in(s);
        free_submission(s);
        return;
    }
    active_job_release(s->job);
    if (error == ERR_NOT_FOUND)
        set_missing(&fault, &s->asked, s->missing);
    else
        fault_set(&fault, error, "",
                  error == ERR_MISMATCH ? "this Idempotency-Key came with another body before"
                                        : "the job could not be stored");
    if (error == ERR_EXISTS)
        s->done(s->ctx, NULL, existing, true);
    else
        s->done(s->ctx, &fault, NULL, false);
    free_submission(s);
}

/* A submission that would be refused, whose key may still name an earlier job. */
struct refusal {
    jobs_submitted done;
    void *ctx;
    struct fault fault;
};

static void on_key_looked_up(void *ctx, int error, const char *existing)
{
    struct refusal *r = ctx;
    if (error == ERR_MISMATCH)
        fault_set(&r->fault, error, "", "this Idempotency-Key came with another body before");
    if (error == ERR_EXISTS)
        r->done(r->ctx, NULL, existing, true);
    else
        r->done(r->ctx, &r->fault, NULL, false);
    free(r);
}

/* False when there is no memory to look: then it is refused. */
static bool look_up_key(struct jobs *jobs, const struct principal *principal, const char *key,
                        const struct digest *body, const struct refusal *refusal)
{
    struct refusal *r = malloc(sizeof *r);
    if (!r) return false;
    *r = *refusal;
    job_store_find_key(jobs->options.store, principal->owner, key, body, on_key_looked_up, r);
    return true;
}

/* Returns the labels as a row has them, which the caller frees. */
static char *join_labels(const struct job_marks *marks)
{
    size_t size_bytes = 2;
    for (uint32_t i = 0; i < marks->label_count; i++) size_bytes += strlen(marks->labels[i]) + 1;
    char *text = malloc(size_bytes), *at = text;
    if (!text) return NULL;
    *at++ = '\n';
    for (uint32_t i = 0; i < marks->label_count; i++) at += sprintf(at, "%s\n", marks->labels[i]);
    *at = '\0';
    return text;
}

static int insert(struct jobs *jobs, const struct principal *principal, const char *key,
                  const struct digest *body, struct submission *s)
{
    const struct job *job = &s->asked;
    struct job_assets assets = {.sees_all = principal->sees_all, .missing = &s->missing};
    struct digest *list = list_assets(job, &assets.count);
    json_t *document = list ? job_write(job) : NULL;
    char *text = json_text(document, JSON_COMPACT);
    char *labels = join_labels(&job->marks);
    assets.items = list;
    json_decref(document);
    if (!text || !labels) {
        free(text);
        free(labels);
        free(list);
        return ERR_MEMORY;
    }
    struct job_row row = {.document = text,
                          .state = job_state_name(JOB_QUEUED),
                          .created_ms = s->job->created_ms,
                          .updated_ms = s->job->created_ms,
                          .priority = job->priority,
                          .name = job->marks.name,
                          .webhook = job->marks.webhook,
                          .labels = job->marks.label_count ? labels : NULL};
    memcpy(row.id, s->job->id, sizeof row.id);
    memcpy(row.owner, s->job->owner, sizeof row.owner);
    trace_context_keep(&s->job->trace, row.trace);
    jobs->live_coming += job->live;
    jobs->coming++;
    job_store_submit(jobs->options.store, &row, key, body, &assets, on_inserted, s);
    free(text);
    free(labels);
    free(list);
    return 0;
}

/* Takes the job, unless it is refused. */
static int submit(struct jobs *jobs, const struct principal *principal, struct job *job,
                  const char *key, const struct digest *body, jobs_submitted done, void *ctx,
                  struct fault *fault)
{
    char id[JOB_ID_BYTES];
    int64_t now_ms = jobs_time_ms();
    int error = check_new(jobs, job, fault);
    if (error) return error;
    if (job_id_next(&jobs->ids, (uint64_t)now_ms, id) != 0)
        return fault_set(fault, ERR_IO, "", "the system gives no random numbers");
    struct submission *s = calloc(1, sizeof *s);
    struct active_job *active =
        active_job_create(jobs, id, principal->owner, job->priority, now_ms);
    if (active) {
        active->live = job->live;
        active->trace = principal->trace;
    }
    if (active && (error = take_place(jobs, principal, fault))) {
        free(s);
        active_job_release(active);
        return error;
    }
    if (active) active->counted = principal->owner[0] != '\0';
    if (s && active && jobs_table_reserve(jobs) == 0) {
        *s = (struct submission){
            .jobs = jobs, .job = active, .asked = *job, .done = done, .ctx = ctx};
        *job = (struct job){0};
        if (insert(jobs, principal, key, body, s) == 0) return 0;
        job_fini(&s->asked);
    }
    free(s);
    if (active) active_job_release(active);
    return fault_set(fault, ERR_MEMORY, "", "no memory for one more job");
}

void jobs_submit(struct jobs *jobs, const struct principal *principal, struct job *job,
                 const char *idempotency_key, const struct digest *body, jobs_submitted done,
                 void *ctx)
{
    struct refusal refused = {.done = done, .ctx = ctx};
    int error = submit(jobs, principal, job, idempotency_key, body, done, ctx, &refused.fault);
    const bool passes = error == ERR_QUOTA || error == ERR_FULL;
    job_fini(job);
    if (passes && idempotency_key && look_up_key(jobs, principal, idempotency_key, body, &refused))
        return;
    if (error) done(ctx, &refused.fault, NULL, false);
}

static void unlink_dry_run(struct dry_run *run)
{
    struct dry_run **at = &run->jobs->dry_runs;
    while (*at != run) at = &(*at)->next;
    *at = run->next;
}

static void on_dry_prepared(void *ctx, const struct fault *fault, struct prepared *prepared)
{
    struct dry_run *run = ctx;
    struct fault memory;
    unlink_dry_run(run);
    json_t *report = prepared ? plan_report_json(&prepared->plan, &prepared->report) : NULL;
    if (!fault && !report) {
        fault_set(&memory, ERR_MEMORY, "", "no memory for the plan");
        fault = &memory;
    }
    run->done(run->ctx, fault, report, prepared ? &prepared->plan : NULL);
    json_decref(report);
    prepared_destroy(&prepared);
    free(run);
}

/* Refuses a dry run before any of its work has begun. */
static void refuse_dry_run(struct dry_run *run, const struct fault *fault)
{
    run->done(run->ctx, fault, NULL, NULL);
    job_fini(&run->job);
    free(run);
}

static void on_assets_found(void *ctx, int error)
{
    struct dry_run *run = ctx;
    struct jobs *jobs = run->jobs;
    struct fault fault;
    if (error == ERR_NOT_FOUND)
        set_missing(&fault, &run->job, run->missing);
    else if (error)
        fault_set(&fault, error, "", "its assets could not be looked up");
    else
        error = check_new(jobs, &run->job, &fault);
    if (error) {
        refuse_dry_run(run, &fault);
        return;
    }
    run->next = jobs->dry_runs;
    jobs->dry_runs = run;
    error = preparation_start(jobs->imports, jobs->options.pool, jobs->options.objects, &run->job,
                              job_frame_number(&run->job, 0), NULL, on_dry_prepared, run,
                              &run->preparation);
    if (!error) return;
    unlink_dry_run(run);
    fault_set(&fault, error, "", "no memory to plan");
    refuse_dry_run(run, &fault);
}

void jobs_dry_run(struct jobs *jobs, const struct principal *principal, struct job *job,
                  jobs_planned done, void *ctx)
{
    struct fault fault;
    struct job_assets assets = {.sees_all = principal->sees_all};
    int error = check_new(jobs, job, &fault);
    struct dry_run *run = error ? NULL : calloc(1, sizeof *run);
    struct digest *list = run ? list_assets(job, &assets.count) : NULL;
    if (!list) {
        job_fini(job);
        free(run);
        if (!error) fault_set(&fault, ERR_MEMORY, "", "no memory to plan");
        done(ctx, &fault, NULL, NULL);
        return;
    }
    *run = (struct dry_run){.jobs = jobs, .job = *job, .done = done, .ctx = ctx};
    *job = (struct job){0};
    assets.items = list;
    assets.missing = &run->missing;
    job_store_find_assets(jobs->options.store, principal->owner, &assets, on_assets_found, run);
    free(list);
}
