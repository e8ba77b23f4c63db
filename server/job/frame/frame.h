#pragma once
/* One frame in work: its plan, tiles, film and image, from the first lease to the stored files.
 *
 * All functions here run on the loop's thread. The pool decodes, reconstructs and encodes. A frame
 * that is dropped sends its owner no more events, and is freed when the pool has let go of it. */
#include <jansson.h>
#include <stdbool.h>

#include "proto/plan.h"
#include "proto/runtime/thread_pool.h"
#include "server/fleet/fleet.h"
#include "server/image/exr.h"
#include "server/image/plate.h"
#include "server/image/png_shade.h"
#include "server/job/frame/foreseen.h"
#include "server/job/frame/state.h"
#include "server/job/frame/statistics.h"
#include "server/job/frame/tile_order.h"
#include "server/reconstruct/residual/residual_window.h"
#include "server/store/objects.h"
#include "server/store/spools.h"

struct frame;

/* Events for the owner, who may drop the frame from inside each of them. */
struct frame_events {
    void *ctx;
    /* Gives the verdict on a result that frame_result took over. */
    void (*judged)(void *ctx, struct frame *frame, uint64_t worker, const struct message_ack *ack);
    /* Pixels of `rect` are in the image. */
    void (*drawn)(void *ctx, struct frame *frame, struct rect rect);
    /* Tiles may wait again, because a round begins (proto/plan.h) or the frame was taken up. */
    void (*extended)(void *ctx, struct frame *frame);
    /* All tiles have landed with all their passes, so workers may forget the frame. */
    void (*traced)(void *ctx, struct frame *frame);
    /* The frame waits for its window (frame_history, frame_draw). NULL where plans have none. */
    void (*waits)(void *ctx, struct frame *frame);
    /* All pixels of a frame that is kept are final. */
    void (*completed)(void *ctx, struct frame *frame);
    /* The files are stored as objects. */
    void (*encoded)(void *ctx, struct frame *frame, const struct digest *exr,
                    const struct digest *png);
    /* They could not be stored for now, and frame_store tries again. NULL: the frame fails. */
    void (*unstored)(void *ctx, struct frame *frame, const struct fault *fault);
    void (*failed)(void *ctx, struct frame *frame, const struct fault *fault);
};

struct frame_options {
    uint64_t id; /* on the wire */
    int32_t number;
    uint32_t layers;
    struct exr_metadata metadata; /* its strings are borrowed for the frame's life; mattes held */
    struct png_options png;       /* of layers of light */
    const struct plan *plan;      /* copied */
    struct motion *motion;        /* held; NULL: nothing moves */
    struct plate *plate;          /* held; of a composite; NULL: none */
    bool adds;                    /* to the plate, instead of multiplying it (catcher.h) */
    struct thread_pool *pool;
    struct scratch *scratch; /* of the pool's work on blocks; borrowed until the frame's last task
                                is over; NULL: one of its own */
    const struct objects *objects;
    struct spools *spools;  /* where its tiles are kept until it has its files; NULL: nowhere */
    char job[JOB_ID_BYTES]; /* its name there, with the number */
    bool unwatched; /* nobody looks while it forms: blocks are drawn when they have all samples */
    bool kept;      /* its files are not made when it is complete, but by frame_store */
    /* How many passes of each tile count already when the spool has them (shelved_frame.h). It is
     * borrowed until the frame is dropped; NULL: none. */
    const uint32_t *counted;
    bool recalled; /* it is drawn already, and all that the spool has of it counted */
    struct frame_events events;
};

/* Creates a frame in state rendering. ERR_MEMORY, ERR_LIMIT. */
int frame_create(const struct frame_options *options, struct frame **out);

/* Drops a frame, which sends no more events. Nulls the pointer. */
void frame_drop(struct frame **frame);

uint64_t frame_id(const struct frame *f);
int32_t frame_number(const struct frame *f);
enum frame_state frame_state(const struct frame *f);
const struct image *frame_image(const struct frame *f);
const struct exr_metadata *frame_metadata(const struct frame *f);
const struct statistics *frame_statistics(const struct frame *f); /* tiles and CPU so far */
uint64_t frame_revision(const struct frame *f); /* blocks drawn, each time that they were, or all */
/* Returns the number of tiles, where every pass of a tile (proto/plan.h) counts as one: a worker is
 * given one at a time. */
uint32_t frame_tiles_total(const struct frame *f);
struct rect frame_tile_rect(const struct frame *f, uint32_t index); /* of one that it gives out */
uint32_t frame_tile_count(const struct frame *f);                   /* each once */
uint32_t frame_tile_passes(const struct frame *f, uint32_t index);  /* of one, that have landed */
uint32_t frame_tiles_planned(const struct frame *f); /* of these, those that the plan tells of */
uint32_t frame_tiles_landed(const struct frame *f);
uint32_t frame_tiles_waiting(const struct frame *f); /* that can be leased now */
/* Returns the share of all samples that have landed, as passes differ in length. It is 1 only when
 * all have. */
double frame_traced_share(const struct frame *f);
/* Estimate the CPU time that workers will still spend on it, and filters on blocks that wait for
 * them, in us. */
double frame_left_us(const struct frame *f, enum foreseen which);
double frame_done_us(const struct frame *f); /* what they have spent since it was opened */
double frame_filters_left_us(const struct frame *f, enum foreseen which);
const uint8_t *frame_plan_bytes(const struct frame *f, uint32_t *size_bytes);

/* Changes the order in which tiles are given. A region stands for the tiles that its pixels need.
 */
void frame_steer(struct frame *f, const struct tile_priority *priority);

/* frame_is_complete returns whether `completed` was sent for a frame that is kept. frame_store
 * makes the files of such a frame, once, and those of any frame again after `unstored`. */
bool frame_is_complete(const struct frame *f);
void frame_store(struct frame *f);

/* Under a plan with temporal filtering a frame is drawn with samples of the frames beside it. Once
 * it is traced, it `waits`. Others read its history, borrowed here; NULL before. frame_draw goes on
 * with as many frames of each side, the nearest first, as `window` has; they are held. */
struct residual_history *frame_history(const struct frame *f);
struct frame_window {
    uint32_t count[MOTION_SIDES];
    struct residual_history *frames[MOTION_SIDES][LIMIT_TEMPORAL_FRAMES];
};
void frame_draw(struct frame *f, const struct frame_window *window);
/* Returns whether it has its window, or needs none. */
bool frame_has_window(const struct frame *f);
/* Returns whether it is traced and waits for that. */
bool frame_is_waiting(const struct frame *f);

/* Returns a warning for when the frame is encoded: a sentence, "" for none. */
const char *frame_warning(const struct frame *f);

/* Returns whether what workers did at a tile, or said of it, made the frame fail. */
bool frame_was_given_up(const struct frame *f);

/* Returns why the last result that did not fit the plan was refused. Borrowed. */
const struct fault *frame_refusal(const struct frame *f);

/* Takes up what an earlier run had of the frame, before the first tile is given. Returns false
 * while the spool is read; `extended` comes then. Workers trace with this version of Embree. */
bool frame_take_up(struct frame *f, const char *embree);

/* Leases the next tile and pass to a worker. Returns false when none waits, or when reconstruction
 * is so far behind that more samples would only fill memory. frame_was_held then returns true once,
 * when it goes on. */
bool frame_lease(struct frame *f, const struct worker_request *request, struct fleet_tile *out);
/* Returns the samples that a tile asks of a worker: for each pixel its layers, counted as one, its
 * paths and its bounce rays. */
uint64_t frame_tile_samples(const struct frame *f, const struct fleet_tile *tile);
/* Returns whether this worker should first be done with what it holds, because a worker has died at
 * the next tile. */
bool frame_waits_for_free(const struct frame *f, const struct worker_request *request);
/* Leases a copy of a leased tile. */
bool frame_copy(struct frame *f, uint64_t worker, uint32_t capabilities,
                const struct fleet_tile *of, struct fleet_tile *out);
bool frame_was_held(struct frame *f);

/* Takes a result. Returns a verdict, or 0 when *bytes was taken over and `judged` follows. */
uint32_t frame_result(struct frame *f, uint64_t worker, const struct message_result *result,
                      uint8_t **bytes, uint32_t size_bytes);

/* Takes a lease back; the frame may fail by it, with an event. Returns whether the tile waits
 * again. It does not after a failure, after it landed by a copy, and while another worker has it.
 */
bool frame_returned(struct frame *f, uint64_t worker, const struct fleet_tile *tile,
                    enum fleet_return why);
/* Notes that a worker did not die of the tiles that came back from it as if it had. */
void frame_survived(struct frame *f, uint64_t worker);
void frame_faulted(struct frame *f, uint64_t worker, const struct message_tile_fault *fault);
