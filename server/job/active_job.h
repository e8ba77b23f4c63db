#pragma once
/* A job that has not ended: from its row in the store to its last file, one small step a function.
 *
 * A queued job is only its name and rank; document, plan and frames are loaded when its turn comes,
 * so that a long queue costs little. */
#include "server/job/fair_share.h"
#include "server/job/frame/fingerprint.h"
#include "server/job/frame/frame.h"
#include "server/job/frame/shelved_frame.h"
#include "server/job/frame/state.h"
#include "server/job/frame/statistics.h"
#include "server/job/jobs.h"
#include "server/job/prepare/preparation.h"

/* What failed for the machine's sake and is tried again (active_retry.c); of a job, the sum of
 * some.
 */
enum retry {
    RETRY_BEGIN = 1,  /* the job, from its document */
    RETRY_FRAMES = 2, /* what its frames say: */
    RETRY_STORE = 4,  /* files of a picture that is drawn */
    RETRY_RECORD = 8, /* that they are there */
    RETRY_END = 16    /* the state in which the job has ended */
};

/* One of a job's frames. */
struct active_frame {
    enum frame_state state;
    struct digest exr, png;        /* zero until stored */
    struct frame *work;            /* while rendering and encoding */
    enum retry retry;              /* RETRY_STORE, RETRY_RECORD or 0 */
    struct shelved_frame *shelved; /* owned; NULL: it is not */
};

struct active_job {
    struct jobs *jobs;
    char id[JOB_ID_BYTES], owner[JOB_OWNER_BYTES];
    int32_t priority;
    bool paused; /* its tiles are not given */
    struct tile_priority tile_priority;
    bool live; /* its camera may be moved */
    int64_t created_ms;
    struct trace trace; /* of the request that submitted it; zero: not known */
    enum job_state state;
    uint64_t revision; /* grows with everything that GET shows; starts at the time in ms, so that it
                          goes on growing after a restart */
    struct active_job *before, *after; /* in order of service */
    struct fair_tenant *tenant; /* in whose turns it is served; NULL: it is live, paused, or not in
                                   the table */
    uint32_t holds;             /* store callbacks that will come */
    bool counted;               /* in its tenant's quota, until it is freed */
    bool gone;                  /* out of the table; freed with the last hold */

    unsigned retry;    /* of enum retry: waits for retry_us */
    uint64_t retry_us; /* jobs_clock_us */
    unsigned pauses;   /* in a row, since a frame was done */
    unsigned tries;    /* to begin it, since a frame was done */
    unsigned runs;     /* times that it began again: frames of before are gone */

    bool loading;
    struct preparation *preparation;
    struct prepared *prepared; /* job, plan, report */
    json_t *plan;              /* its JSON */
    char fingerprint[FINGERPRINT_BYTES];
    struct active_frame *frames; /* frame_count, in order of their numbers */
    uint32_t frame_count, frames_opened, frames_finished;
    uint64_t tiles_beyond;  /* passes of frames that are over which their plan did not tell of */
    struct live_view *view; /* owned; of a live job that was planned (live_view.h) */
    uint32_t view_before;   /* number of the last view of an earlier run; 0: none */
    struct active_frame *shown; /* whose image the pixel feed shows */

    struct statistics statistics; /* of frames that are no longer in work, but for shelved ones, and
                                     of earlier runs */
    uint64_t work_started_us;     /* clock; 0: not in work */
    uint64_t work_started_cpu_us; /* of the loop's thread */
    uint64_t trace_started_us;
    double trace_started_fraction;
    bool progress_due;
    struct rect last_tile; /* landed since progress was told; empty: none */
    int32_t last_tile_frame;
    uint64_t last_tile_worker;
    json_t *last_progress; /* where it stood when it ended; NULL before */

    json_t *log;          /* job_log.h; NULL before its first line */
    bool log_due;         /* it has lines that the store does not have */
    uint64_t log_kept_us; /* when it was last sent there */
    struct fault failure; /* of a failed job */
    json_t *error;        /* its problem document; NULL also where there is no memory for it yet */
    job_store_done cancelled; /* who waits for the end; NULL: nobody */
    void *cancelled_ctx;
};

struct active_job *active_job_create(struct jobs *jobs, const char *id, const char *owner,
                                     int32_t priority, int64_t created_ms);
/* Drops what is in work without a word to the store or the streams. */
void active_job_drop(struct active_job *job);
/* Frees it, now or with its last hold. */
void active_job_release(struct active_job *job);

/* Loads the document and starts the import. */
void active_job_begin(struct active_job *job);

/* Ends it: drops its work, records state and report; leaves the table when that is durable. */
void active_job_fail(struct active_job *job, const struct fault *fault);
void active_job_finish(struct active_job *job);
void active_job_cancel(struct active_job *job, job_store_done done, void *ctx);

/* active_retry.c: what may pass by itself is tried again, anything else fails the job. */
void active_job_fail_or_retry(struct active_job *job, const struct fault *fault);
/* The same of one step. */
void active_job_retry_store(struct active_job *job, struct active_frame *frame,
                            const struct fault *fault);
void active_job_retry_record(struct active_job *job, struct active_frame *frame);
void active_job_retry_end(struct active_job *job);
/* Sends to the store what is to be recorded: that a job has ended; that a frame's files are there
 * (active_record.c). */
void active_job_record_end(struct active_job *job);
void active_job_record_frame(struct active_job *job, struct active_frame *frame);
/* Its files are on record, or never will be: nothing of the frame's holds them any more. */
void active_frame_release_pictures(const struct jobs *jobs, const struct digest *exr,
                                   const struct digest *png);
int32_t active_frame_number(const struct active_job *job, const struct active_frame *frame);
/* Tells the streams of its state. */
void active_frame_tell(const struct active_job *job, const struct active_frame *frame);

/* active_log.c: a line in its log, with the time. */
void active_job_log(struct active_job *job, const char *what, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Between states, now and then: lines that are not in the store yet go there with the report. */
void active_job_keep_log(struct active_job *job);
/* Tells the server's log that it was taken in. */
void active_job_log_accepted(const struct active_job *job);
/* Goes on with the log of an earlier run: {report} as the store has it. */
void active_job_take_log(struct active_job *job, const json_t *report);
/* The state that it came to, the warnings of its plan, why it failed. */
void active_job_log_state(struct active_job *job);

/* Takes it out of work, or back: clocks stand still meanwhile. Its frames stay as they are. */
void active_job_pause(struct active_job *job, bool paused);
/* An ended job is not: there is nothing left to pause. */
static inline bool active_job_is_paused(const struct active_job *job)
{
    return job->paused && !job_state_is_final(job->state);
}
/* For its open frames, and those that come. */
void active_job_prioritize(struct active_job *job, const struct tile_priority *priority);

/* active_frames.c: a running job with a frame that is not yet opened; opening the next. */
bool active_job_has_unopened(const struct active_job *job);
void active_job_open_frame(struct active_job *job);
void active_job_drop_frames(struct active_job *job);
/* One that is in work: it waits to be opened again, and takes up what its spool has. */
void active_job_shelve_frame(struct active_job *job, struct active_frame *frame);
/* Counts shelved frames for good: what they have is not taken up any more. */
void active_job_unshelve_frames(struct active_job *job);
/* None is in work. */
void active_job_free_frames(struct active_job *job);
/* Takes a frame out of work and hands it over: it waits to be opened again. */
struct frame *active_job_take_work(struct active_job *job, struct active_frame *frame);
/* Floats of an image and of samples that wait for their next pass: what opening a frame costs. */
uint64_t active_job_frame_floats(const struct active_job *job);

/* active_report.c: what GET shows and what is kept: {progress, plan, statistics, warnings,
 * revision, log}. New references. */
json_t *active_job_report(const struct active_job *job);
/* Sends the report to the store, with the state unless that is NULL: what is durable of a job that
 * goes on. Work on frames that are not drawn is not in it: these begin again after a restart, or
 * count what they take up then. (What is drawn and could not be recorded is: it counts twice where
 * the coordinator is killed before it can be.) */
void active_job_keep_report(struct active_job *job, const char *state);
/* The text of it, to be freed; NULL without memory. */
char *active_job_kept_report(const struct active_job *job);
json_t *active_job_progress(const struct active_job *job);
json_t *active_job_frames(const struct active_job *job);
void active_job_statistics(const struct active_job *job, struct statistics *out);
/* Of them what stands still while the job is not in work: clocks, and peaks of memory, to which
 * others' work adds. */
void active_job_add_work(const struct active_job *job, struct statistics *sum);
double active_job_fraction(const struct active_job *job);

/* The address of a frame's picture: kind "exr" or "png". */
void active_job_picture_path(const char *id, int32_t number, const char *kind, char out[96]);
json_t *active_job_frame_json(const char *id, int32_t number, enum frame_state state);
