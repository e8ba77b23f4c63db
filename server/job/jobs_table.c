#include "server/job/jobs_table.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* Returns the first place in by_id whose job is not before `id`. */
static size_t place_of(const struct jobs *jobs, const char *id)
{
    size_t low = 0, high = jobs->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (strcmp(jobs->by_id[middle]->id, id) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Compares ranks without the tenants' turns: the order of the list, which does not change by
 * itself. */
static bool ranks_before(const struct active_job *a, const struct active_job *b)
{
    if (a->priority != b->priority) return a->priority > b->priority;
    if (a->live != b->live) return a->live; /* a user waits for it */
    return strcmp(a->id, b->id) < 0;
}

bool jobs_table_before(const struct active_job *a, const struct active_job *b)
{
    if (a->priority == b->priority && a->tenant && b->tenant) {
        if (fair_tenant_before(a->tenant, b->tenant)) return true;
        if (fair_tenant_before(b->tenant, a->tenant)) return false;
    }
    return ranks_before(a, b);
}

/* Without memory for its tenant's account it is served by its age alone. */
static void join_turns(struct jobs *jobs, struct active_job *job)
{
    if (jobs_table_is_working(job))
        job->tenant = fair_share_join(&jobs->share, job->owner, job->priority);
}

static void leave_turns(struct jobs *jobs, struct active_job *job)
{
    if (job->tenant) fair_share_leave(&jobs->share, job->tenant);
    job->tenant = NULL;
}

/* New jobs are mostly the last of their rank: looked for from the end. */
static void link_in_order(struct jobs *jobs, struct active_job *job)
{
    struct active_job *before = jobs->last;
    while (before && ranks_before(job, before)) before = before->before;
    job->before = before;
    job->after = before ? before->after : jobs->first;
    *(before ? &before->after : &jobs->first) = job;
    *(job->after ? &job->after->before : &jobs->last) = job;
}

static void unlink_job(struct jobs *jobs, struct active_job *job)
{
    *(job->before ? &job->before->after : &jobs->first) = job->after;
    *(job->after ? &job->after->before : &jobs->last) = job->before;
    job->before = job->after = NULL;
}

int jobs_table_reserve(struct jobs *jobs)
{
    if (jobs->count + jobs->coming < jobs->capacity) return 0;
    const size_t capacity = jobs->capacity ? 2 * jobs->capacity : 64;
    struct active_job **by_id = realloc(jobs->by_id, capacity * sizeof(struct active_job *));
    if (!by_id) return ERR_MEMORY;
    jobs->by_id = by_id;
    jobs->capacity = capacity;
    return 0;
}

int jobs_table_add(struct jobs *jobs, struct active_job *job)
{
    if (jobs_table_reserve(jobs) != 0) return ERR_MEMORY;
    size_t at = place_of(jobs, job->id);
    memmove(jobs->by_id + at + 1, jobs->by_id + at,
            (jobs->count - at) * sizeof(struct active_job *));
    jobs->by_id[at] = job;
    jobs->count++;
    jobs->in_state[job->state]++;
    jobs->live_count += job->live;
    link_in_order(jobs, job);
    join_turns(jobs, job);
    return 0;
}

void jobs_table_remove(struct jobs *jobs, struct active_job *job)
{
    jobs->live_count -= job->live;
    size_t at = place_of(jobs, job->id);
    assert(at < jobs->count && jobs->by_id[at] == job);
    memmove(jobs->by_id + at, jobs->by_id + at + 1,
            (--jobs->count - at) * sizeof(struct active_job *));
    unlink_job(jobs, job);
    leave_turns(jobs, job);
}

struct active_job *jobs_table_find(const struct jobs *jobs, const char *id)
{
    size_t at = place_of(jobs, id);
    return at < jobs->count && !strcmp(jobs->by_id[at]->id, id) ? jobs->by_id[at] : NULL;
}

static bool open_before(const struct active_job *job, const struct active_frame *frame,
                        const struct open_frame *other)
{
    return job == other->job ? frame < other->frame : jobs_table_before(job, other->job);
}

/* Puts it among the first `count`, which are in order. */
static void insert_open(struct jobs *jobs, unsigned count, struct open_frame one)
{
    unsigned at = count;
    for (; at > 0 && open_before(one.job, one.frame, &jobs->open[at - 1]); at--)
        jobs->open[at] = jobs->open[at - 1];
    jobs->open[at] = one;
}

void jobs_table_open(struct jobs *jobs, struct active_job *job, struct active_frame *frame)
{
    assert(job->live ? jobs->open_live < LIVE_MAX
                     : jobs->open_count - jobs->open_live < OPEN_MAX + PARKED_MAX + WAITING_MAX);
    jobs->open_live += job->live;
    insert_open(jobs, jobs->open_count++, (struct open_frame){.job = job, .frame = frame});
    jobs_mind_scratch(jobs);
}

static void sort_open(struct jobs *jobs)
{
    for (unsigned i = 1; i < jobs->open_count; i++) insert_open(jobs, i, jobs->open[i]);
}

void jobs_table_rank(struct jobs *jobs, struct active_job *job, int32_t priority)
{
    unlink_job(jobs, job);
    leave_turns(jobs, job);
    job->priority = priority;
    link_in_order(jobs, job);
    join_turns(jobs, job);
    sort_open(jobs);
}

void jobs_table_paused(struct jobs *jobs, struct active_job *job)
{
    leave_turns(jobs, job);
    join_turns(jobs, job);
    sort_open(jobs);
}

static bool has_tiles(const struct jobs *jobs, const struct fair_tenant *tenant)
{
    for (unsigned i = 0; i < jobs->open_count; i++)
        if (jobs->open[i].job->tenant == tenant &&
            frame_tiles_waiting(jobs->open[i].frame->work) > 0)
            return true;
    return false;
}

void jobs_table_charge(struct jobs *jobs, struct active_job *job, uint64_t samples)
{
    if (!job->tenant) return;
    fair_share_charge(&jobs->share, job->tenant, samples);
    sort_open(jobs);
    /* The tenant whose turn it is may have a frame that is not open yet. */
    const struct fair_tenant *next = fair_share_next(&jobs->share, job->priority);
    if (next != job->tenant && !has_tiles(jobs, next)) jobs_advance_soon(jobs);
}

bool jobs_table_is_working(const struct active_job *job)
{
    return !job->live && !job->paused;
}

unsigned jobs_table_working(const struct jobs *jobs)
{
    unsigned count = 0;
    for (unsigned i = 0; i < jobs->open_count; i++)
        count += jobs_table_is_working(jobs->open[i].job) &&
                 !frame_is_waiting(jobs->open[i].frame->work);
    return count;
}

bool jobs_table_has_window_room(const struct jobs *jobs, const struct active_job *job)
{
    unsigned windows = 0;
    uint64_t bytes = plan_window_bytes(&job->prepared->plan);
    bool is_first = true;
    if (active_job_reach(job) == 0) return true;
    for (unsigned i = 0; i < jobs->open_count; i++) {
        const struct active_job *other = jobs->open[i].job;
        if (other == job) return true;
        /* Frames of a job are neighbours here. */
        const bool is_seen = i > 0 && jobs->open[i - 1].job == other;
        if (is_seen || !jobs_table_is_working(other) || active_job_reach(other) == 0) continue;
        windows++;
        bytes += plan_window_bytes(&other->prepared->plan);
        is_first = is_first && job->priority > other->priority;
    }
    if (is_first) return windows <= WINDOWS_MAX;
    return windows < WINDOWS_MAX && bytes <= LIMIT_WINDOW_BYTES;
}

void jobs_table_close(struct jobs *jobs, struct active_frame *frame)
{
    unsigned at = 0;
    while (at < jobs->open_count && jobs->open[at].frame != frame) at++;
    assert(at < jobs->open_count);
    jobs->open_live -= jobs->open[at].job->live;
    jobs->open_count--;
    for (; at < jobs->open_count; at++) jobs->open[at] = jobs->open[at + 1];
    jobs_mind_scratch(jobs);
}

struct open_frame *jobs_table_frame(struct jobs *jobs, uint64_t id)
{
    for (unsigned i = 0; i < jobs->open_count; i++)
        if (frame_id(jobs->open[i].frame->work) == id) return &jobs->open[i];
    return NULL;
}
