#pragma once
/* The view of a live job, which is a camera, a lens and where nodes are, shown at growing
 * resolution (view_levels.h).
 *
 * Views are numbered from 1. A move begins the next view at once. The frame in work is dropped with
 * all its leases, so results that workers still send belong to no frame, and the pixel feed gets
 * nothing more of it. A coarse picture is shown when it is whole; the last one replaces it block by
 * block. When the last is complete the job rests: its frame stays, without files, until the camera
 * moves, or until it has rested so long that the job ends with its files. */
#include <uv.h>

#include "server/job/active_job.h"
#include "server/job/view_levels.h"

/* The most live jobs that may be open at once, since each holds a picture. */
#define LIVE_MAX 8

struct live_view {
    uint32_t number;
    unsigned level, levels;
    struct plan plans[VIEW_LEVELS_MAX];
    struct plate *plates[VIEW_LEVELS_MAX]; /* held; NULL: there is no photograph */
    struct preparation *preparation;       /* of moved nodes (live_scene.c); NULL: none */
    struct live_move *waiting;             /* owned; moves that wait for their scene */
    struct prepared *ready; /* owned; that scene, until the view before is seen; NULL */
    uint64_t ready_us;      /* or until then */
    uint64_t shown_us;      /* when something of the view was first on the feed; 0: nothing was */
    unsigned covered;       /* of these, those whose scene is prepared */
    unsigned alone;         /* and those that get scenes of their own */
    bool shown;             /* the level in work is on the feed */
    struct frame
        *last; /* the coarser frame that is on the feed until then; complete, and not in work */
    uint64_t moved_us;
    bool recording; /* the store has not answered the last recording */
    bool dirty;     /* a newer state waits to be recorded */
};

/* Plans the first view of a job that was just prepared. ERR_MEMORY, or what plan_make refuses. */
int live_view_create(struct active_job *job, uint32_t number, struct fault *fault);
void live_view_destroy(struct active_job *job);

/* Begins the next view, from a body that job_view_read takes. Where nodes are moved, or moves wait,
 * it begins none, but sets *waits (live_scene_wait). A fault's pointer leads into the body, and
 * leaves the job as it was. */
int live_view_move(struct active_job *job, const char *text, size_t size_bytes, bool *waits,
                   struct fault *fault);
/* Begins the next view with a scene of its own, which is taken if it returns 0. */
int live_view_take_scene(struct active_job *job, struct prepared *prepared, struct fault *fault);

/* -- live_scene.c -- */

/* Has a move that live_view_move has read wait for its scene. `done` comes once it is shown or
 * refused. ERR_MEMORY, ERR_FULL: too many wait. */
int live_scene_wait(struct active_job *job, const char *text, size_t size_bytes, jobs_moved done,
                    void *ctx);
/* Finds what all moves that wait make of the document; it borrows the job's files. */
void live_scene_coming(const struct active_job *job, struct job *document);
/* Takes the scene that is ready, if one is and it is time. Returns whether one still waits. */
bool live_scene_take(struct active_job *job);
/* Gives up what is prepared, and tells those that wait for it. */
void live_scene_give_up(struct active_job *job);
/* Makes a fault of the document one of the body that moves the view. */
void live_scene_point_into_body(struct fault *fault);

/* Returns 0 if it may be moved; else ERR_STATE with a sentence: it has not begun, is ending, or is
 * not live. */
int live_view_check(const struct active_job *job, struct fault *fault);

/* Return the plan and the photograph of the level in work; NULL: there is none. */
const struct plan *live_view_plan(const struct active_job *job);
struct plate *live_view_plate(const struct active_job *job);
int32_t live_view_scale(const struct active_job *job);

/* Notes that pixels of the frame in work have changed; live_view_completed, that it is complete. */
void live_view_drawn(struct active_job *job, struct rect rect);
void live_view_completed(struct active_job *job);
/* Takes the frame in work off the feed, since it is dropped. */
void live_view_hide(struct active_job *job);

/* Sends to the store what it lacks, at the end of the coordinator's run. */
void live_view_keep(struct active_job *job);

/* Ends a resting job, with its files. */
void live_view_end(struct active_job *job);

/* Describes the view, for GET and events: {number, scale, complete}. New reference. */
json_t *live_view_json(const struct active_job *job);
