#pragma once
/* What a live job shows: one view, which is a camera and a lens, at growing resolution
 * (view_levels.h).
 *
 * Views are numbered from 1. A move begins the next one at once: the frame in work is dropped with
 * all its leases, so that what workers still send of it belongs to no frame, and the pixel feed is
 * told nothing more of it. A coarse picture is shown when it is whole, the last one block by block,
 * over the coarser one. When the last is complete the job rests: its frame stays, without files,
 * until the camera moves, or has not for so long that the job ends with its files. */
#include <uv.h>

#include "server/job/active_job.h"
#include "server/job/view_levels.h"

/* Live jobs that may be open at once: each holds a picture. */
#define LIVE_MOST 8

struct live_view {
    uint32_t number;
    unsigned level, levels;
    struct plan plans[VIEW_LEVELS_MOST];
    bool shown;         /* the level in work is on the feed */
    struct frame *last; /* the coarser one that is, until then; complete, and not in work */
    uint64_t moved_us;
    bool recording; /* the store has not answered the last recording */
    bool dirty;     /* and there is something newer to record */
};

/* Of a job that was just prepared: plans its first view. ERR_MEMORY, or what plan_make refuses. */
int live_view_create(struct active_job *job, uint32_t number, struct fault *fault);
void live_view_destroy(struct active_job *job);

/* The next view, from a body that job_view_read takes. The pointer of a fault is into that. The job
 * is as it was then. */
int live_view_move(struct active_job *job, const char *text, size_t size_bytes,
                   struct fault *fault);

/* May it be moved? ERR_STATE with a sentence: it has not begun, is ending, or is not live. */
int live_view_check(const struct active_job *job, struct fault *fault);

/* The plan of the level in work. */
const struct plan *live_view_plan(const struct active_job *job);
int32_t live_view_scale(const struct active_job *job);

/* Pixels of the frame in work have changed; it is complete. */
void live_view_drawn(struct active_job *job, struct rect rect);
void live_view_completed(struct active_job *job);
/* The frame in work is dropped: the feed must not look at it. */
void live_view_hide(struct active_job *job);

/* What the store does not have goes there now, for nobody comes back to it. */
void live_view_keep(struct active_job *job);

/* Ends a job that rests, with its files. */
void live_view_end(struct active_job *job);

/* {number, scale, complete}: for GET and events. New reference. */
json_t *live_view_json(const struct active_job *job);
