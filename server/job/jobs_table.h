#pragma once
/* The inside of struct jobs, shared by the files of this room: who is there, in which order they
 * are served, which frames are open. */
#include "server/job/active_job.h"
#include "server/job/job_counts.h"
#include "server/job/job_id.h"
#include "server/job/live_view.h"

/* Frames in work: two keep workers busy while one is encoded; small images may have more. */
#define OPEN_MOST 4
#define OPEN_FLOATS_MOST                                                                           \
    (4u * 2u * 3840u * 2160u) /* of images beyond the second: two 4K beauties */
#define PARKED_MOST        12 /* of paused jobs, beside these */
#define PARKED_FLOATS_MOST OPEN_FLOATS_MOST
#define LIVE_FLOATS_MOST   (4u * OPEN_FLOATS_MOST) /* of live jobs' images: eight 4K beauties */
#define READY_AHEAD        3  /* jobs that are imported and planned before their turn */
#define READY_OF_EACH      2  /* of each tenant, where several wait */
#define READY_TENANTS      8  /* of whom only the next few are looked at */
#define ENDED_STREAMS      32 /* ended jobs whose late readers still find the last events */
#define PROGRESS_EVERY_MS  100
#define SCRATCH_MOST_BYTES ((size_t)256 << 20) /* that the next frame finds */
#define SCRATCH_UNUSED_MS  10000 /* without another frame, until it holds none that is not used */
#define ABANDONED_AFTER_MS                                                                         \
    10000 /* without a worker, after the last one was put into quarantine                          \
           */

struct open_frame {
    struct active_job *job;
    struct active_frame *frame;
};

struct dry_run {
    struct dry_run *next;
    struct jobs *jobs;
    struct job job;                  /* owned, until it is prepared */
    size_t missing;                  /* of its assets */
    struct preparation *preparation; /* NULL: its assets are looked up */
    jobs_planned done;
    void *ctx;
};

struct jobs {
    struct jobs_options options;
    struct fleet *fleet; /* NULL before it is set and after jobs_stop */
    struct imports *imports;
    struct scratch *scratch; /* of the pool's work on blocks, whichever frame they are of */
    uv_timer_t advance, progress, idle, retry;
    uv_timer_t unused; /* runs since a frame was last opened or closed */
    struct job_id_source ids;
    uint64_t next_frame_id;

    struct active_job **by_id; /* sorted; jobs that have not ended */
    size_t count, capacity;
    size_t coming;                      /* being stored, which have a place in by_id beforehand */
    struct active_job *first, *last;    /* in order of rank: priority, then age */
    struct job_counts counts;           /* of tenants, also of those that come */
    struct fair_share share;            /* who goes first among tenants of a priority */
    uint64_t in_state[JOB_STATE_COUNT]; /* of those in the table; ended ones since the start */
    uint64_t submitted;

    struct open_frame open[OPEN_MOST + PARKED_MOST + LIVE_MOST]; /* in order of service */
    unsigned open_count, open_live;                              /* of them, of live jobs */
    unsigned live_count;                                         /* of those in the table */
    unsigned live_coming;                                        /* being stored before that */
    struct dry_run *dry_runs;
    char ended[ENDED_STREAMS][JOB_ID_BYTES];
    unsigned ended_next;
    uv_timer_t abandoned;   /* runs since the last worker was sent away */
    struct fault refusal;   /* for what */
    struct statistics past; /* of frames that are no longer open, and of imports */
    bool stopping;
};

/* jobs_table.c */
int jobs_table_add(struct jobs *jobs,
                   struct active_job *job); /* ERR_MEMORY; the table owns it then */
/* Makes room for one more than those that come. ERR_MEMORY. */
int jobs_table_reserve(struct jobs *jobs);
void jobs_table_remove(struct jobs *jobs, struct active_job *job);
struct active_job *jobs_table_find(const struct jobs *jobs, const char *id);
/* Gives it another priority, and its place by it. */
void jobs_table_rank(struct jobs *jobs, struct active_job *job, int32_t priority);
/* Open frames whose tiles are given. */
unsigned jobs_table_working(const struct jobs *jobs);
/* Its frames count as work: neither live nor paused. */
bool jobs_table_is_working(const struct active_job *job);
/* Its pause has begun or is over: it gives up its tenant's turns, or takes part in them. */
void jobs_table_paused(struct jobs *jobs, struct active_job *job);
/* Whether a is served before b: priority, live ones first, the turn of their tenants, then age. */
bool jobs_table_before(const struct active_job *a, const struct active_job *b);
/* A tile of the job is given to a worker: that many samples. */
void jobs_table_charge(struct jobs *jobs, struct active_job *job, uint64_t samples);
void jobs_table_open(struct jobs *jobs, struct active_job *job, struct active_frame *frame);
void jobs_table_close(struct jobs *jobs, struct active_frame *frame);
struct open_frame *jobs_table_frame(struct jobs *jobs, uint64_t frame_id);

/* jobs_turn.c: imports and plans the first few jobs before their turn; opens the frame that is to
 * be given out next, false when that must wait. */
void jobs_begin_ahead(struct jobs *jobs);
bool jobs_open_next(struct jobs *jobs);

/* jobs_move.c */
/* Live jobs whose level is complete go on to the next, or rest. */
void jobs_complete_views(struct jobs *jobs);
/* Looks from now on for live jobs that have rested for too long. */
void jobs_watch_idle(struct jobs *jobs);

/* active_retry.c: what is due; true while something waits. */
bool jobs_retry(struct jobs *jobs);

/* jobs.c */
/* Has that called from time to time. */
void jobs_retry_soon(struct jobs *jobs);
/* A frame was opened or closed: the scratch holds what the next one may need, for a while. */
void jobs_mind_scratch(struct jobs *jobs);
/* Unless a worker joins within ABANDONED_AFTER_MS, fails the jobs whose results were refused and
 * takes back the workers that sent them. */
void jobs_fail_unless_joined(struct jobs *jobs, const struct fault *refusal);

/* Looks soon for what can be begun. */
void jobs_advance_soon(struct jobs *jobs);
void jobs_progress_soon(struct jobs *jobs, struct active_job *job);
void jobs_set_state(struct jobs *jobs, struct active_job *job, enum job_state state);
void jobs_event(struct active_job *job, const char *name, json_t *data,
                bool final); /* takes data */
void jobs_event_state(struct active_job *job);
/* Readers of an ended job find its last events for a while. */
void jobs_remember_ended(struct jobs *jobs, const char *id);
uint64_t jobs_clock_us(void);
uint64_t jobs_loop_cpu_us(void);
int64_t jobs_time_ms(void);
