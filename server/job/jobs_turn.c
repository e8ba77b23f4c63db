/* Which jobs are prepared, and whose frame is opened next. */
#include "server/job/jobs_table.h"

/* How many jobs of one priority are imported and planned before their turn. */
struct ahead {
    int32_t priority;
    size_t tenants, satisfied;
    unsigned each, ready; /* of a tenant; of all, with those of higher priorities */
};

/* Where several tenants wait, each has some: the oldest of all may be one's alone. */
static void ahead_enter(const struct jobs *jobs, struct ahead *ahead, int32_t priority)
{
    ahead->priority = priority;
    ahead->satisfied = 0;
    ahead->tenants = fair_share_count(&jobs->share, priority);
    ahead->each = ahead->tenants > 1 ? READY_OF_EACH : READY_AHEAD;
}

/* Returns whether a job goes ahead of the queue. Live jobs have places of their own, so one that
 * waits for such a place holds up no other. */
static bool is_ahead(const struct active_job *job)
{
    return job->state == JOB_QUEUED || job->state == JOB_IMPORTING ||
           (active_job_has_unopened(job) && !job->live);
}

static bool is_its_turn(const struct jobs *jobs, const struct ahead *ahead,
                        const struct active_job *job)
{
    if (!job->tenant || ahead->tenants <= 1) return ahead->ready < READY_AHEAD;
    return job->tenant->ahead < ahead->each &&
           fair_share_rank(&jobs->share, job->tenant) < READY_TENANTS;
}

static void look_at(struct jobs *jobs, struct ahead *ahead, struct active_job *job)
{
    struct fair_tenant *tenant = job->tenant;
    const bool is_free = !job->retry && is_its_turn(jobs, ahead, job);
    if (is_free && job->state == JOB_QUEUED && !job->loading) active_job_begin(job);
    const bool counts = is_free && is_ahead(job);
    ahead->ready += counts;
    if (!tenant || tenant != job->tenant) return; /* it has ended at once */
    const bool before = tenant->seen == tenant->jobs || tenant->ahead == ahead->each;
    tenant->seen++;
    tenant->ahead += counts;
    const bool after = tenant->seen == tenant->jobs || tenant->ahead == ahead->each;
    ahead->satisfied += after && !before;
}

void jobs_begin_ahead(struct jobs *jobs)
{
    struct active_job *after;
    struct ahead ahead = {0};
    fair_share_look(&jobs->share);
    for (struct active_job *job = jobs->first; job; job = after) {
        after = job->after;
        if (job == jobs->first || job->priority != ahead.priority) {
            if (ahead.ready >= READY_AHEAD) break;
            ahead_enter(jobs, &ahead, job->priority);
        }
        if (!job->paused) look_at(jobs, &ahead, job);
        const bool enough = ahead.tenants <= 1 || ahead.satisfied >= ahead.tenants;
        if (enough && ahead.ready >= READY_AHEAD) break;
    }
}

static const struct active_job *first_with_tiles(const struct jobs *jobs)
{
    for (unsigned i = 0; i < jobs->open_count; i++)
        if (!jobs->open[i].job->paused && frame_tiles_waiting(jobs->open[i].frame->work) > 0)
            return jobs->open[i].job;
    return NULL;
}

static bool has_room(const struct jobs *jobs, const struct active_job *job)
{
    uint64_t floats = active_job_frame_floats(job);
    if (jobs_table_working(jobs) < 2) return true;
    for (unsigned i = 0; i < jobs->open_count; i++)
        if (jobs_table_is_working(jobs->open[i].job))
            floats += active_job_frame_floats(jobs->open[i].job);
    return floats <= OPEN_FLOATS_MAX;
}

/* Its pictures stay while it is open: the first has room, whatever its size. */
static bool has_live_room(const struct jobs *jobs, const struct active_job *job)
{
    uint64_t floats = active_job_frame_floats(job);
    if (jobs->open_live == 0) return true;
    for (unsigned i = 0; i < jobs->open_count; i++)
        if (jobs->open[i].job->live) floats += active_job_frame_floats(jobs->open[i].job);
    return jobs->open_live < LIVE_MAX && floats <= LIVE_FLOATS_MAX;
}

/* Live jobs have places of their own, as their frames stay. */
static bool may_open(const struct jobs *jobs, const struct active_job *job)
{
    if (job->paused || !active_job_may_open(job)) return false;
    if (job->live) return has_live_room(jobs, job);
    return jobs_table_working(jobs) < OPEN_MAX && jobs_table_has_window_room(jobs, job);
}

/* Only jobs that run have frames to open, and those are few of many. */
static struct active_job *next_to_open(const struct jobs *jobs)
{
    struct active_job *first = NULL;
    uint64_t running = jobs->in_state[JOB_RUNNING];
    for (struct active_job *job = jobs->first; job && running > 0; job = job->after) {
        if (first && (job->priority != first->priority || first->live)) break;
        running -= job->state == JOB_RUNNING;
        if (may_open(jobs, job) && (!first || jobs_table_before(job, first))) first = job;
    }
    return first;
}

/* The next frame is opened when no open one has tiles left to give, or when it goes before all that
 * have. A frame that goes before only by its tenant's turn waits for room. */
bool jobs_open_next(struct jobs *jobs)
{
    struct active_job *job = next_to_open(jobs);
    if (!job) return false;
    if (job->live) {
        active_job_open_frame(job);
        return true;
    }
    const struct active_job *giving = first_with_tiles(jobs);
    if (giving && !jobs_table_before(job, giving)) return false;
    if ((!giving || job->priority == giving->priority) && !has_room(jobs, job)) return false;
    active_job_open_frame(job);
    return true;
}

void jobs_set_weights(struct jobs *jobs, struct fair_weights *weights)
{
    fair_share_weigh(&jobs->share, weights);
}
