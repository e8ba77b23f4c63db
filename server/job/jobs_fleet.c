/* What the fleet asks of the jobs. */
#include <stdio.h>
#include <string.h>

#include "server/job/jobs_table.h"

static struct frame *work_of(struct jobs *jobs, uint64_t id)
{
    struct open_frame *open = jobs_table_frame(jobs, id);
    return open ? open->frame->work : NULL;
}

bool jobs_find_work(struct jobs *jobs, const struct principal *principal, uint64_t frame_id,
                    char id[JOB_ID_BYTES], int32_t *number)
{
    const struct open_frame *open = jobs_table_frame(jobs, frame_id);
    if (!open || !principal_sees(principal, open->job->owner)) return false;
    memcpy(id, open->job->id, JOB_ID_BYTES);
    *number = frame_number(open->frame->work);
    return true;
}

static bool next_tile(void *ctx, const struct worker_request *request, struct fleet_tile *out)
{
    struct jobs *jobs = ctx;
    for (unsigned i = 0; i < jobs->open_count; i++) {
        struct frame *work = jobs->open[i].frame->work;
        if (jobs->open[i].job->paused) continue;
        if (!frame_take_up(work, fleet_embree(jobs->fleet))) continue;
        if (frame_waits_for_free(work, request)) return false;
        if (!frame_lease(work, request, out)) continue;
        if (frame_tiles_waiting(work) == 0) jobs_advance_soon(jobs);
        jobs_table_charge(jobs, jobs->open[i].job, frame_tile_samples(work, out));
        return true;
    }
    return false;
}

static bool copy_tile(void *ctx, uint64_t worker, uint32_t capabilities,
                      const struct fleet_tile *of, struct fleet_tile *out)
{
    const struct open_frame *open = jobs_table_frame(ctx, of->frame_id);
    if (!open || open->job->paused) return false;
    return frame_copy(open->frame->work, worker, capabilities, of, out);
}

static bool plan(void *ctx, uint64_t id, struct message_frame_plan *out)
{
    const struct open_frame *open = jobs_table_frame(ctx, id);
    if (!open) return false;
    *out = (struct message_frame_plan){.frame_id = id};
    memcpy(out->job, open->job->id, sizeof open->job->id);
    trace_context_keep(&open->job->trace, out->trace);
    out->plan = frame_plan_bytes(open->frame->work, &out->plan_bytes);
    return out->plan != NULL;
}

static uint32_t result(void *ctx, uint64_t worker, const struct message_result *message,
                       uint8_t **bytes, uint32_t size_bytes)
{
    struct jobs *jobs = ctx;
    struct frame *work = work_of(jobs, message->frame_id);
    if (work) return frame_result(work, worker, message, bytes, size_bytes);
    jobs->past.results_dropped++;
    return VERDICT_FOREIGN;
}

static const char *worker_name(const struct jobs *jobs, uint64_t worker)
{
    const char *name = jobs->fleet ? fleet_worker_name(jobs->fleet, worker) : NULL;
    return name && name[0] ? name : "a worker";
}

/* A line counts all tiles that come back at once. */
static void log_returned(struct active_job *job, uint64_t worker)
{
    const struct jobs *jobs = job->jobs;
    const char *name = worker_name(jobs, worker);
    if (jobs->fleet && fleet_worker_is_here(jobs->fleet, worker))
        active_job_log(job, "tiles", "%s did not do a tile that it held: it is given out again",
                       name);
    else
        active_job_log(job, "worker", "%s has left: a tile that it held is given out again", name);
}

static void returned(void *ctx, uint64_t worker, const struct fleet_tile *tile,
                     enum fleet_return why)
{
    struct jobs *jobs = ctx;
    struct open_frame *open = jobs_table_frame(jobs, tile->frame_id);
    if (!open) return;
    struct active_job *job = open->job;
    if (frame_returned(open->frame->work, worker, tile, why)) log_returned(job, worker);
    if (jobs->fleet) fleet_wake(jobs->fleet);
}

static void survived(void *ctx, uint64_t worker)
{
    struct jobs *jobs = ctx;
    for (unsigned i = 0; i < jobs->open_count; i++)
        frame_survived(jobs->open[i].frame->work, worker);
}

static void faulted(void *ctx, uint64_t worker, const struct message_tile_fault *fault)
{
    struct jobs *jobs = ctx;
    struct open_frame *open = jobs_table_frame(jobs, fault->frame_id);
    if (!open) return;
    struct frame *work = open->frame->work;
    active_job_log(open->job, "tiles", "%s cannot trace a tile: %.200s", worker_name(jobs, worker),
                   fault->text);
    frame_faulted(work, worker, fault);
    if (jobs->fleet) fleet_wake(jobs->fleet);
}

static bool needs_blob(const struct plan *p, const struct digest *digest)
{
    return digest_equal(&p->scene, digest) ||
           (p->environment.kind == ENVIRONMENT_MAP && digest_equal(&p->environment.map, digest)) ||
           (p->photograph.fit != PHOTOGRAPH_NONE && digest_equal(&p->photograph.blob, digest));
}

/* Workers may have the blobs of open frames, and nothing else of the store. */
static bool blob_path(void *ctx, const struct digest *digest, char *out, size_t capacity)
{
    struct jobs *jobs = ctx;
    char path[OBJECTS_PATH_BYTES];
    for (unsigned i = 0; i < jobs->open_count; i++) {
        const struct open_frame *open = &jobs->open[i];
        const struct digest *base = active_frame_base(open->job, open->frame);
        if (!needs_blob(active_frame_plan(open->job, open->frame), digest) &&
            !(base && digest_equal(base, digest)))
            continue;
        objects_path(jobs->options.objects, digest, path);
        return (size_t)snprintf(out, capacity, "%s", path) < capacity;
    }
    return false;
}

uint64_t jobs_tiles_waiting(const struct jobs *jobs)
{
    uint64_t sum = 0;
    for (unsigned i = 0; i < jobs->open_count; i++)
        if (!jobs->open[i].job->paused) sum += frame_tiles_waiting(jobs->open[i].frame->work);
    return sum;
}

static uint64_t tiles_left(void *ctx)
{
    return jobs_tiles_waiting(ctx);
}

struct fleet_client jobs_fleet_client(struct jobs *jobs)
{
    return (struct fleet_client){.ctx = jobs,
                                 .next_tile = next_tile,
                                 .plan = plan,
                                 .result = result,
                                 .returned = returned,
                                 .survived = survived,
                                 .faulted = faulted,
                                 .blob_path = blob_path,
                                 .tiles_left = tiles_left,
                                 .copy_tile = copy_tile};
}
