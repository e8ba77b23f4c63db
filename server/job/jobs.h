#pragma once
/* The jobs, from submission to the last file: accepted, stored, imported, planned, traced,
 * reconstructed, encoded, reported.
 *
 * All of it is owned by one thread, the loop's. Answers that need the disk or the importer come by
 * callback on the same thread. */
#include <jansson.h>
#include <stdbool.h>
#include <uv.h>

#include "proto/job/job.h"
#include "proto/log/log.h"
#include "proto/runtime/thread_pool.h"
#include "server/fleet/fleet.h"
#include "server/image/exr.h"
#include "server/image/png_shade.h"
#include "server/job/principal.h"
#include "server/job/steering.h"
#include "server/store/job_store.h"
#include "server/store/objects.h"
#include "server/store/spools.h"
#include "server/stream/stream.h"
#include "server/webhook/webhooks.h"

struct jobs;

/* Default of how long a live job rests until it ends. */
#define LIVE_IDLE_MS 1800000

struct jobs_options {
    uv_loop_t *loop;
    struct log *log; /* takes the outcomes of jobs; NULL: none */
    struct job_store *store;
    const struct objects *objects;
    struct spools *spools; /* tiles of frames in work; NULL: a restart begins frames anew */
    struct streams *streams;
    struct thread_pool *pool;   /* reconstruction and encoding */
    const char *import_program; /* path of shearwater-import */
    struct webhooks *webhooks;  /* tells of the ends of jobs; NULL: nobody */
    bool unwatched;             /* nobody looks at pictures in work (frame.h) */
    size_t tenant_jobs_max;     /* of active jobs, of each tenant; 0: no quota */
    uint64_t live_idle_ms;      /* without a move, until a resting live job ends */
};

int jobs_create(const struct jobs_options *options, struct jobs **out);

/* Returns the fleet's client. The fleet is set once both exist. */
struct fleet_client jobs_fleet_client(struct jobs *jobs);
void jobs_set_fleet(struct jobs *jobs, struct fleet *fleet);

/* Resumes the unfinished jobs of the store, and removes the spools of all others. Blocking; before
 * the loop runs. */
int jobs_resume(struct jobs *jobs);

/* Stops importers and drops frames in work, which stay unfinished in the store. Neither fleet nor
 * streams are called any more, and pool and store get no more work. Then pool, spools and store
 * must be destroyed, whose last callbacks still come here, the fleet closed, and the loop run once
 * more. */
void jobs_stop(struct jobs *jobs);

/* Frees the rest, after jobs_stop and what must follow it. */
void jobs_destroy(struct jobs **jobs);

/* Sets how tenants of one priority share the workers (fair_share.h). Weights are taken; NULL:
 * alike. */
struct fair_weights;
void jobs_set_weights(struct jobs *jobs, struct fair_weights *weights);

/* Whether a job asks for a library, which takes long to load; and loads it, on any thread, before
 * jobs_submit or jobs_dry_run says what was found. */
bool jobs_needs_library(const struct job *job);
void jobs_load_library(void);

/* All calls below answer for the jobs that the principal may see (principal.h). Any other job does
 * not exist for it (ERR_NOT_FOUND). The principal is copied.
 *
 * jobs_submit accepts a job. On success `id` names a durable job, and `existed` tells that the key
 * was known. On failure *fault says why: ERR_NOT_FOUND for a missing asset, ERR_MISMATCH for a
 * reused key, ERR_FULL, ERR_QUOTA. `job` is taken. The principal becomes the owner, and must have
 * uploaded what the job names. */
typedef void (*jobs_submitted)(void *ctx, const struct fault *fault, const char *id, bool existed);
void jobs_submit(struct jobs *jobs, const struct principal *principal, struct job *job,
                 const char *idempotency_key, const struct digest *body, jobs_submitted done,
                 void *ctx);

/* Imports (or finds the blob) and plans without submitting. report: the plan of jobs_get; plan: of
 * the first frame. Both are borrowed. */
typedef void (*jobs_planned)(void *ctx, const struct fault *fault, json_t *report,
                             const struct plan *plan);
void jobs_dry_run(struct jobs *jobs, const struct principal *principal, struct job *job,
                  jobs_planned done, void *ctx);

/* Gets a job: {id, state, name, labels, owner, created, document, progress {tiles_done,
 * tiles_total, fraction, eta_s, eta_range_s}, plan {integrator, effects, layers, planes,
 * skipped: [{what, why}], lights, environment, camera, warnings}, statistics {...}, warnings,
 * error, log (job_log.h), frames: [{number, state, exr, png}], priority, revision}. exr and png are
 * addresses, null until the file is there. For paused, region and near see steering.h. NULL: no
 * such job. Borrowed. */
typedef void (*jobs_answer)(void *ctx, int error, json_t *body);
void jobs_get(struct jobs *jobs, const struct principal *principal, const char *id,
              jobs_answer done, void *ctx);

/* Lists jobs: {jobs: [{id, state, name, labels, owner, created, priority, paused, progress,
 * revision, width, height}], next: cursor or null}. ERR_RANGE for an unknown state or an invalid
 * cursor; ERR_STATE (job_store.h). The listing's owner counts only for a principal that sees all.
 */
void jobs_list(struct jobs *jobs, const struct principal *principal,
               const struct job_listing *listing, jobs_answer done, void *ctx);

/* Cancels a job; with purge its row is removed, too. ERR_NOT_FOUND; ERR_STATE when it has ended
 * already (not an error for purge). */
void jobs_cancel(struct jobs *jobs, const struct principal *principal, const char *id, bool purge,
                 job_store_done done, void *ctx);

/* Finds the job and the number of a frame in work. False: it is over, there never was one, or the
 * principal may not see it. */
bool jobs_find_work(struct jobs *jobs, const struct principal *principal, uint64_t frame_id,
                    char id[JOB_ID_BYTES], int32_t *number);

/* Changes the name, comment and labels that `marks` gives (job_marks_read_change), of a job in any
 * state. ERR_MISMATCH as below. 0 when it is durable. */
void jobs_mark(struct jobs *jobs, const struct principal *principal, const char *id,
               uint64_t seen_revision, const json_t *marks, job_store_done done, void *ctx);

/* Applies what `steering` gives. ERR_STATE when the job is not active; ERR_MISMATCH when its
 * revision is not the one that was seen (0: any). 0 when it is in force and, but for region and
 * point, durable. */
void jobs_steer(struct jobs *jobs, const struct principal *principal, const char *id,
                uint64_t seen_revision, const struct steering *steering, job_store_done done,
                void *ctx);

/* Moves the camera of a live job. `text` is {camera, lens}, of which one may be absent
 * (job_view_read of proto/job/job.h). body: {id, view {number, scale, complete}, camera, lens};
 * borrowed. Faults of the document have a pointer. Without one, ERR_NOT_FOUND means that there is
 * no such job, ERR_STATE that it is not live, has not begun, or has ended. */
typedef void (*jobs_moved)(void *ctx, const struct fault *fault, json_t *body);
void jobs_move(struct jobs *jobs, const struct principal *principal, const char *id,
               const char *text, size_t size_bytes, jobs_moved done, void *ctx);

/* A frame's picture: the finished file, or the image so far. */
struct jobs_picture {
    bool finished;
    struct digest exr, png; /* finished: objects */
    struct image *image;    /* so far: borrowed for the call; NULL before the first tile */
    uint64_t revision;      /* another with every block, and with every view */
    const struct exr_metadata *metadata;
    struct png_options png_options; /* the job's, of layers of light */
    bool shows_composite;           /* its PNG does, else beauty */
};
typedef void (*jobs_pictured)(void *ctx, int error, const struct jobs_picture *picture);
void jobs_picture(struct jobs *jobs, const struct principal *principal, const char *id,
                  int32_t frame, jobs_pictured done, void *ctx);

/* The picture that stands for a job in lists: the small one that is kept, or what one can be made
 * of. */
struct jobs_thumbnail {
    const void *kept; /* a PNG, borrowed for the call; NULL: none yet */
    size_t kept_bytes;
    const struct image *image;      /* of the frame that forms, borrowed for the call; NULL: none */
    uint64_t revision;              /* of that image */
    struct png_options png_options; /* by which it is shown */
    struct digest png;              /* without these: of the last finished frame, an object */
    bool ended; /* this picture is the job's last: what is made of it may be kept */
};
/* ERR_NOT_FOUND: no such job; ERR_MISSING: it has no picture. */
typedef void (*jobs_thumbnailed)(void *ctx, int error, const struct jobs_thumbnail *thumbnail);
void jobs_thumbnail(struct jobs *jobs, const struct principal *principal, const char *id,
                    jobs_thumbnailed done, void *ctx);

/* Counts for metrics and readiness. */
struct jobs_totals {
    uint64_t queued, importing, running, resting, finished, failed, cancelled, submitted;
    uint64_t tiles_done, tiles_reissued, tiles_copied, tiles_resumed;
    uint64_t results_dropped, samples_rejected;
    struct counters counters;
    uint64_t import_cpu_us, reconstruct_cpu_us, shadow_cpu_us, indirect_cpu_us, glossy_cpu_us,
        lens_cpu_us, lens_relight_cpu_us, residual_cpu_us, oidn_cpu_us, decode_cpu_us,
        encode_cpu_us, coordinate_cpu_us;
};
void jobs_totals(const struct jobs *jobs, struct jobs_totals *out);

/* Returns how many jobs wait for their turn or are imported, and are not paused. */
uint64_t jobs_waiting(const struct jobs *jobs);

/* Returns about how many tiles could be given out now: of frames in work that are not paused. */
uint64_t jobs_tiles_waiting(const struct jobs *jobs);
