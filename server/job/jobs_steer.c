/* Changing how a job that has not ended is served: its rank, whether it goes on, what goes first.
 * Rank and pause are durable before they are in force; what goes first is a hint that a restart
 * forgets. */
#include <stdlib.h>
#include <string.h>

#include "server/job/jobs_table.h"

/* Frames of paused jobs keep what has landed, as far as memory for it goes: the last in order of
 * service are dropped beyond that, but for one, and taken from the spool, or traced anew, when
 * their job goes on. Frames that need others beside them are dropped at once: their windows must
 * find room again. */
static const struct open_frame *one_too_many(const struct jobs *jobs)
{
    unsigned parked = 0;
    uint64_t floats = 0;
    for (unsigned i = 0; i < jobs->open_count; i++) {
        const struct active_job *job = jobs->open[i].job;
        if (!job->paused || job->live) continue; /* live ones have places of their own */
        if (active_job_reach(job) > 0) return &jobs->open[i];
        floats += active_job_frame_floats(job);
        if (++parked > PARKED_MAX || (parked > 1 && floats > PARKED_FLOATS_MAX))
            return &jobs->open[i];
    }
    return NULL;
}

static void pause_job(struct jobs *jobs, struct active_job *job, bool paused)
{
    const struct open_frame *surplus;
    if (job->paused == paused) return;
    active_job_pause(job, paused);
    jobs_table_paused(jobs, job);
    while ((surplus = one_too_many(jobs))) {
        surplus->job->revision++;
        active_job_shelve_frame(surplus->job, surplus->frame);
    }
}

static void prioritize(struct active_job *job, const struct steering *s)
{
    struct tile_priority priority = job->tile_priority;
    if (s->given & STEERING_REGION) priority.region = s->region;
    if (s->given & STEERING_NEAR) {
        priority.has_near = s->has_near;
        priority.near_x = s->near_x;
        priority.near_y = s->near_y;
    }
    active_job_prioritize(job, &priority);
}

static void apply(struct jobs *jobs, struct active_job *job, const struct steering *s)
{
    if (s->given & STEERING_PRIORITY) jobs_table_rank(jobs, job, s->priority);
    if (s->given & STEERING_PAUSED) pause_job(jobs, job, s->paused);
    if (s->given & (STEERING_REGION | STEERING_NEAR)) prioritize(job, s);
    job->revision++;
    /* A point that follows one viewer's mouse is no event for the others. */
    if (s->given & ~(uint32_t)STEERING_NEAR) jobs_event_state(job);
    jobs_advance_soon(jobs);
    if (jobs->fleet) fleet_wake(jobs->fleet);
}

/* What is durable of a job that has ended since is its rank. */
static void settle(struct jobs *jobs, struct active_job *job, const struct steering *s)
{
    if (!job_state_is_final(job->state))
        apply(jobs, job, s);
    else if (s->given & STEERING_PRIORITY)
        jobs_table_rank(jobs, job, s->priority);
}

struct change {
    struct jobs *jobs;
    struct steering steering;
    char id[JOB_ID_BYTES];
    job_store_done done;
    void *ctx;
};

static void on_durable(void *ctx, int error)
{
    struct change *c = ctx;
    struct active_job *job = jobs_table_find(c->jobs, c->id);
    if (error == ERR_NOT_FOUND) error = ERR_STATE; /* it has just ended */
    if (!error && !c->jobs->stopping && job) settle(c->jobs, job, &c->steering);
    c->done(c->ctx, error);
    free(c);
}

/* Another change that was seen with this one's revision is refused from here on, though neither is
 * in force yet. */
static void store_change(struct jobs *jobs, struct active_job *job, const struct steering *steering,
                         job_store_done done, void *ctx)
{
    struct change *c = malloc(sizeof *c);
    if (!c) {
        done(ctx, ERR_MEMORY);
        return;
    }
    *c = (struct change){.jobs = jobs, .steering = *steering, .done = done, .ctx = ctx};
    memcpy(c->id, job->id, sizeof c->id);
    job->revision++;
    job_store_steer(jobs->options.store, job->id,
                    steering->given & STEERING_PRIORITY ? &steering->priority : NULL,
                    steering->given & STEERING_PAUSED ? &steering->paused : NULL, on_durable, c);
}

void jobs_steer(struct jobs *jobs, const struct principal *principal, const char *id,
                uint64_t seen_revision, const struct steering *steering, job_store_done done,
                void *ctx)
{
    struct active_job *job = jobs_table_find(jobs, id);
    if (job && !principal_sees(principal, job->owner)) {
        done(ctx, ERR_NOT_FOUND);
    } else if (!job || job_state_is_final(job->state) || jobs->stopping) {
        done(ctx, ERR_STATE);
    } else if (seen_revision && seen_revision != job->revision) {
        done(ctx, ERR_MISMATCH);
    } else if (steering->given & (STEERING_PRIORITY | STEERING_PAUSED)) {
        store_change(jobs, job, steering, done, ctx);
    } else {
        apply(jobs, job, steering);
        done(ctx, 0);
    }
}
