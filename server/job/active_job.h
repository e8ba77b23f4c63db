#pragma once
/* An active job, which is one that has not ended: from its row in the store to its last file, one
 * small step a function.
 *
 * A queued job is only its name and rank. Document, plan and frames are loaded when its turn comes,
 * so that a long queue costs little. */
#include "server/job/fair_share.h"
#include "server/job/frame/fingerprint.h"
#include "server/job/frame/frame.h"
#include "server/job/frame/shelved_frame.h"
#include "server/job/frame/state.h"
#include "server/job/frame/statistics.h"
#include "server/job/jobs.h"
#include "server/job/pace.h"
#include "server/job/prepare/preparation.h"

/* The steps that failed because of the machine and are tried again (active_retry.c); of a job,
 * the union of some. */
enum retry {
    RETRY_BEGIN = 1,  /* the job, from its document */
    RETRY_FRAMES = 2, /* what its frames say of themselves: */
    RETRY_STORE = 4,  /* the files of a drawn picture */
    RETRY_RECORD = 8, /* the record of these files */
    RETRY_END = 16    /* the state in which the job has ended */
};

/* One of a job's frames. */
struct active_frame {
    enum frame_state state;
    struct digest exr, png;        /* zero until they are stored */
    struct frame *work;            /* NULL but while it renders and encodes */
    enum retry retry;              /* RETRY_STORE, RETRY_RECORD or 0 */
    struct shelved_frame *shelved; /* owned; NULL: none */
    struct prepared *prepared;     /* owned; its own scene and plan; NULL: the job's, or not yet */
    struct residual_history *history; /* held, when its work is over, for frames to be drawn */
    bool is_alone;                    /* it has no history that others could use */
    bool recalled;                    /* it is drawn, and traced again for the history alone */
};

struct active_job {
    struct jobs *jobs;
    char id[JOB_ID_BYTES], owner[JOB_OWNER_BYTES];
    int32_t priority;
    bool paused; /* gives no tiles out */
    struct tile_priority tile_priority;
    bool live; /* its camera may be moved */
    int64_t created_ms;
    struct trace_context trace; /* of the request that submitted it; zero: not known */
    enum job_state state;
    uint64_t revision; /* grows with all that GET shows; starts at the time in ms, so that it goes
                          on growing after a restart */
    struct active_job *before, *after; /* in order of service */
    struct fair_tenant
        *tenant;    /* whose turns it takes; NULL: it is live, paused, or not in the table */
    uint32_t holds; /* store callbacks that are still to come */
    bool counted;   /* in its tenant's quota, until it is freed */
    bool gone;      /* out of the table; freed with the last hold */

    unsigned retry;    /* of enum retry: due at retry_us */
    uint64_t retry_us; /* jobs_clock_us */
    unsigned pauses;   /* in a row, since a frame was done */
    unsigned tries;    /* of beginning it, since a frame was done */
    unsigned runs;     /* times that it began again, without the frames of before */

    bool loading;
    struct preparation *preparation;
    struct prepared *prepared; /* job, plan, report */
    json_t *plan;              /* its JSON */
    char fingerprint[FINGERPRINT_BYTES];
    struct active_frame *frames; /* frame_count, in order of their numbers */
    uint32_t frame_count, frames_opened, frames_finished;
    uint32_t recalls;           /* recalled frames that are not in work */
    uint64_t tiles_beyond;      /* passes of ended frames that their plan did not tell of */
    struct live_view *view;     /* owned; of a live job that is planned (live_view.h) */
    uint32_t view_before;       /* number of the last view of an earlier run; 0: none */
    struct active_frame *shown; /* its image is on the pixel feed */

    struct statistics statistics; /* of ended frames and of earlier runs, without shelved frames */
    uint64_t work_started_us;     /* clock; 0: not in work */
    uint64_t work_started_cpu_us; /* of the loop's thread */
    struct pace pace;             /* of tracing; not started before the first frame */
    bool progress_due;
    struct rect last_tile; /* landed since progress was published; empty: none */
    int32_t last_tile_frame;
    uint64_t last_tile_worker;
    json_t *last_progress; /* where it ended; NULL before */

    json_t *log;              /* job_log.h; NULL before its first line */
    bool log_due;             /* it has lines that the store does not have */
    uint64_t log_kept_us;     /* when it was last sent to the store */
    struct fault failure;     /* of a failed job */
    json_t *error;            /* its problem document; NULL also while there is no memory for it */
    job_store_done cancelled; /* waits for the end; NULL: none */
    void *cancelled_ctx;
};

struct active_job *active_job_create(struct jobs *jobs, const char *id, const char *owner,
                                     int32_t priority, int64_t created_ms);
/* Drops what is in work, without telling the store or the streams. */
void active_job_drop(struct active_job *job);
/* Frees it, now or with its last hold. */
void active_job_release(struct active_job *job);

/* Loads the document and starts the import. */
void active_job_begin(struct active_job *job);

/* Ends the job: drops its work, records state and report. It leaves the table when that is
 * durable. */
void active_job_fail(struct active_job *job, const struct fault *fault);
void active_job_finish(struct active_job *job);
void active_job_cancel(struct active_job *job, job_store_done done, void *ctx);

/* Tries again what may pass by itself, and fails the job for anything else (active_retry.c). */
void active_job_fail_or_retry(struct active_job *job, const struct fault *fault);
/* Does the same for one step. */
void active_job_retry_store(struct active_job *job, struct active_frame *frame,
                            const struct fault *fault);
void active_job_retry_record(struct active_job *job, struct active_frame *frame);
void active_job_retry_end(struct active_job *job);
/* Records in the store that a job has ended, or that a frame's files are there (active_record.c).
 */
void active_job_record_end(struct active_job *job);
void active_job_record_frame(struct active_job *job, struct active_frame *frame);
/* Releases a frame's files, which are on record or never will be. */
void active_frame_release_pictures(const struct jobs *jobs, const struct digest *exr,
                                   const struct digest *png);
int32_t active_frame_number(const struct active_job *job, const struct active_frame *frame);
/* Publishes the frame's state. */
void active_frame_tell(const struct active_job *job, const struct active_frame *frame);

/* Adds a line to its log, with the time (active_log.c). */
void active_job_log(struct active_job *job, const char *what, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Sends new lines of the log to the store with the report, now and then between states. */
void active_job_keep_log(struct active_job *job);
/* Logs in the server's log that the job was accepted. */
void active_job_log_accepted(const struct active_job *job);
/* Continues the log of an earlier run: {report} as the store has it. */
void active_job_take_log(struct active_job *job, const json_t *report);
/* Logs the state that it reached, the warnings of its plan, why it failed. */
void active_job_log_state(struct active_job *job);

/* Takes it out of work, or back. Its clocks stand still meanwhile; its frames stay as they are. */
void active_job_pause(struct active_job *job, bool paused);
/* Returns whether it is paused. An ended job is not: there is nothing left to pause. */
static inline bool active_job_is_paused(const struct active_job *job)
{
    return job->paused && !job_state_is_final(job->state);
}
/* Sets the tile priority of its open frames and of those to come. */
void active_job_prioritize(struct active_job *job, const struct tile_priority *priority);

/* Prepares the scenes of the next frames of a job that moves (active_scenes.c). */
void active_job_prepare_ahead(struct active_job *job);
/* Returns whether a frame has its scene, and what is traced for it. */
bool active_frame_is_prepared(const struct active_job *job, const struct active_frame *frame);
const struct plan *active_frame_plan(const struct active_job *job,
                                     const struct active_frame *frame);

/* Returns how a frame moves; NULL: nothing does, or no layer shows it. */
struct motion *active_frame_motion(const struct active_job *job, const struct active_frame *frame);
/* Returns the photograph that a frame is composed with; NULL: none. */
struct plate *active_frame_plate(const struct active_job *job, const struct active_frame *frame);

/* Returns the blob that a frame's scene stands on; NULL: none. */
const struct digest *active_frame_base(const struct active_job *job,
                                       const struct active_frame *frame);

/* -- active_window.c: frames that are drawn with samples of those beside them -- */

/* Returns how many frames on each side may lend samples. */
uint32_t active_job_reach(const struct active_job *job);
/* Draws what waited for the history of a frame, or for the news that it has none. */
void active_job_draw_windows(struct active_job *job, const struct active_frame *frame);
/* Holds the history of a frame whose work ends, if others need it; lets go of all that none needs.
 */
void active_job_keep_history(struct active_job *job, struct active_frame *frame);
/* Recalls drawn frames whose histories others lack. */
void active_job_recall(struct active_job *job);
/* Removes the spools of a finished frame, and of those beside it, that no frame needs any more. */
void active_job_forget_spools(struct active_job *job, const struct active_frame *frame);
/* Returns whether a frame may be opened without holding up those before it. */
bool active_job_is_in_reach(const struct active_job *job, const struct active_frame *frame);

/* -- active_open.c: frames go into work -- */

/* Returns whether it is a running job with a frame that is not yet opened. active_job_open_frame
 * opens the next, once it is prepared. */
bool active_job_has_unopened(const struct active_job *job);
bool active_job_may_open(const struct active_job *job);
void active_job_open_frame(struct active_job *job);
void active_job_drop_frames(struct active_job *job);
/* Takes a frame out of work and drops it. It is not counted as opened any more by the caller. */
void active_job_close_work(struct active_job *job, struct active_frame *frame);
/* Shows a frame in work on the pixel feed. */
void active_job_show(struct active_job *job, struct active_frame *frame);
/* Returns what tells a job of its frames' work. */
struct frame_events active_job_frame_events(struct jobs *jobs);
/* Shelves a frame in work: it waits to be opened again, and then takes up what its spool has. */
void active_job_shelve_frame(struct active_job *job, struct active_frame *frame);
/* Counts shelved frames for good. What they have is not taken up any more. */
void active_job_unshelve_frames(struct active_job *job);
/* Frees the frames, none of which is in work. */
void active_job_free_frames(struct active_job *job);
/* Takes a frame out of work and hands it over. It waits to be opened again. */
struct frame *active_job_take_work(struct active_job *job, struct active_frame *frame);
/* Returns the cost of opening a frame: floats of its image and of samples that wait for their next
 * pass. */
uint64_t active_job_frame_floats(const struct active_job *job);

/* Returns what GET shows and what is kept: {progress, plan, statistics, warnings, revision, log}
 * (active_report.c). The functions below return new references. */
json_t *active_job_report(const struct active_job *job);
/* Sends the report to the store, with the state unless that is NULL: what is durable of a job that
 * goes on. Work on frames that are not drawn is left out: after a restart these begin again, or
 * count what they take up. (Drawn frames that could not be recorded are in it: they count twice if
 * the coordinator is killed before they are.) */
void active_job_keep_report(struct active_job *job, const char *state);
/* Returns the report's text, which the caller frees; NULL without memory. */
char *active_job_kept_report(const struct active_job *job);
/* Returns a plan of the prepared scene, and which of its nodes may be moved. */
json_t *active_job_plan_json(const struct prepared *prepared, const struct plan *plan,
                             const struct plan_report *report);
json_t *active_job_progress(const struct active_job *job);
json_t *active_job_frames(const struct active_job *job);
void active_job_statistics(const struct active_job *job, struct statistics *out);
/* Adds those statistics that stand still while the job is not in work: clocks, and peaks of memory,
 * to which other jobs' work adds. */
void active_job_add_work(const struct active_job *job, struct statistics *sum);
/* Starts the pace anew, for its time left; notes what has been spent meanwhile. */
void active_job_pace_start(struct active_job *job);
void active_job_pace_note(struct active_job *job);

/* Writes the address of a frame's picture: kind "exr" or "png". */
void active_job_picture_path(const char *id, int32_t number, const char *kind, char out[96]);
json_t *active_job_frame_json(const char *id, int32_t number, enum frame_state state);
