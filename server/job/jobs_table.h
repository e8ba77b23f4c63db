#pragma once
/* The inside of struct jobs, shared by the files of this room: the table of jobs that have not
 * ended, their order of service, and the open frames. */
#include "server/job/active_job.h"
#include "server/job/job_counts.h"
#include "server/job/job_id.h"
#include "server/job/live_view.h"

/* Frames in work: two keep workers busy while one is encoded; small images may have more. */
#define OPEN_MAX 4
#define OPEN_FLOATS_MAX                                                                            \
    (4u * 2u * 3840u * 2160u) /* of images beyond the second: two 4K pictures                      \
                               */
#define WAITING_MAX                                                                                \
    ((WINDOWS_MAX + 1) * (LIMIT_TEMPORAL_FRAMES + 2)) /* that are traced, and need others beside   \
                                                       */
#define WINDOWS_MAX       4  /* jobs with such frames, and one that comes before them all */
#define PARKED_MAX        12 /* of paused jobs, beside OPEN_MAX */
#define PARKED_FLOATS_MAX OPEN_FLOATS_MAX
#define LIVE_FLOATS_MAX   (4u * OPEN_FLOATS_MAX) /* of live jobs' images: eight 4K pictures */
#define READY_AHEAD       3  /* jobs that are imported and planned before their turn */
#define READY_OF_EACH     2  /* of each tenant, where several wait */
#define READY_TENANTS     8  /* only the jobs of this many tenants are looked at */
#define ENDED_STREAMS     32 /* whose late readers still find the last events */
#define PROGRESS_EVERY_MS 100
#define SCRATCH_MAX_BYTES ((size_t)256 << 20) /* kept for the next frame */
#define SCRATCH_UNUSED_MS 10000 /* without another frame, until unused scratch is freed */
#define ABANDONED_AFTER_MS                                                                         \
    10000 /* after the last worker was put into quarantine, until jobs fail */

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
    struct scratch *scratch; /* of the pool's work on blocks, for all frames */
    uv_timer_t advance, progress, idle, retry;
    uv_timer_t unused; /* runs since a frame was last opened or closed */
    struct job_id_source ids;
    uint64_t next_frame_id;

    struct active_job **by_id; /* sorted; jobs that have not ended */
    size_t count, capacity;
    size_t coming;                      /* being stored; by_id has room for them */
    struct active_job *first, *last;    /* in order of rank: priority, then age */
    struct job_counts counts;           /* of each tenant's jobs, also those being stored */
    struct fair_share share;            /* which tenant of a priority goes first */
    uint64_t in_state[JOB_STATE_COUNT]; /* of those in the table, and of those that ended since the
                                           start */
    uint64_t submitted;

    struct open_frame
        open[OPEN_MAX + WAITING_MAX + PARKED_MAX + LIVE_MAX]; /* in order of service */
    unsigned open_count, open_live;                           /* of these, frames of live jobs */
    unsigned live_count;                                      /* of those in the table */
    unsigned live_coming;                                     /* live jobs being stored */
    struct dry_run *dry_runs;
    char ended[ENDED_STREAMS][JOB_ID_BYTES];
    unsigned ended_next;
    uv_timer_t abandoned;   /* runs since the last worker went into quarantine */
    struct fault refusal;   /* why its results were refused */
    struct statistics past; /* of frames that are no longer open, and of imports */
    bool stopping;
};

/* jobs_table.c */
int jobs_table_add(struct jobs *jobs,
                   struct active_job *job); /* ERR_MEMORY; the table owns it then */
/* Makes room for one more than those being stored. ERR_MEMORY. */
int jobs_table_reserve(struct jobs *jobs);
void jobs_table_remove(struct jobs *jobs, struct active_job *job);
struct active_job *jobs_table_find(const struct jobs *jobs, const char *id);
/* Gives it another priority, and the place that follows from it. */
void jobs_table_rank(struct jobs *jobs, struct active_job *job, int32_t priority);
/* Returns how many open frames give tiles out, or are drawn. */
unsigned jobs_table_working(const struct jobs *jobs);
/* Returns whether a job may begin to keep frames that wait for others (active_window.c): a few jobs
 * do, as memory goes, unless it comes before them all. One that has open frames goes on. */
bool jobs_table_has_window_room(const struct jobs *jobs, const struct active_job *job);
/* Returns whether its frames count as work: it is neither live nor paused. */
bool jobs_table_is_working(const struct active_job *job);
/* Takes it out of its tenant's turns when its pause begins, or into them when it is over. */
void jobs_table_paused(struct jobs *jobs, struct active_job *job);
/* Returns whether a is served before b: by priority, live ones first, then the turn of their
 * tenants, then age. */
bool jobs_table_before(const struct active_job *a, const struct active_job *b);
/* Charges the job's tenant for samples of a tile that is given to a worker. */
void jobs_table_charge(struct jobs *jobs, struct active_job *job, uint64_t samples);
void jobs_table_open(struct jobs *jobs, struct active_job *job, struct active_frame *frame);
void jobs_table_close(struct jobs *jobs, struct active_frame *frame);
struct open_frame *jobs_table_frame(struct jobs *jobs, uint64_t frame_id);

/* Imports and plans the first few jobs before their turn (jobs_turn.c). jobs_open_next opens the
 * frame that is to be given out next; false: that must wait. */
void jobs_begin_ahead(struct jobs *jobs);
bool jobs_open_next(struct jobs *jobs);

/* jobs_move.c */
/* Moves live jobs whose level is complete on to the next level, or lets them rest. */
void jobs_complete_views(struct jobs *jobs);
/* Answers a move of a live job. fault NULL: it is as the move has it. */
void jobs_answer_move(const struct active_job *job, const struct fault *fault, jobs_moved done,
                      void *ctx);
/* Ends live jobs from now on that have rested for too long. */
void jobs_watch_idle(struct jobs *jobs);

/* Retries what is due (active_retry.c). Returns true while something waits. */
bool jobs_retry(struct jobs *jobs);

/* jobs.c */
/* Has jobs_retry called from time to time. */
void jobs_retry_soon(struct jobs *jobs);
/* Keeps the scratch that the next frame may need for a while. Called when a frame was opened or
 * closed. */
void jobs_mind_scratch(struct jobs *jobs);
/* Waits ABANDONED_AFTER_MS for a worker to join. If none does, fails the jobs whose results were
 * refused and takes back the workers that sent them. */
void jobs_fail_unless_joined(struct jobs *jobs, const struct fault *refusal);

/* Begins what can be begun, soon. */
void jobs_advance_soon(struct jobs *jobs);
void jobs_progress_soon(struct jobs *jobs, struct active_job *job);
void jobs_set_state(struct jobs *jobs, struct active_job *job, enum job_state state);
void jobs_event(struct active_job *job, const char *name, json_t *data,
                bool final); /* takes data */
/* Finds the image so far of a frame in work. False: there is none yet. */
bool jobs_picture_so_far(const struct active_job *active, const struct active_frame *frame,
                         struct jobs_picture *out);
/* Makes the address of a job's thumbnail, null while there is none. */
json_t *jobs_thumbnail_address(const struct active_job *active, const struct job_row *row);
void jobs_event_state(struct active_job *job);
/* Keeps an ended job's last events for late readers, for a while. */
void jobs_remember_ended(struct jobs *jobs, const char *id);
uint64_t jobs_clock_us(void);
uint64_t jobs_loop_cpu_us(void);
int64_t jobs_time_ms(void);
