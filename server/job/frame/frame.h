#pragma once
/* One frame in work: its plan, tiles, film and image, from the first lease to the stored files.
 *
 * Everything here runs on the loop's thread; decoding, reconstruction and encoding are handed to
 * the pool and come back. A frame that is dropped tells its owner nothing more, and is freed when
 * the pool has let go of it. */
#include <jansson.h>
#include <stdbool.h>

#include "proto/plan.h"
#include "proto/runtime/thread_pool.h"
#include "server/fleet/fleet.h"
#include "server/image/exr.h"
#include "server/job/frame/state.h"
#include "server/job/frame/statistics.h"
#include "server/job/frame/tile_order.h"
#include "server/store/objects.h"
#include "server/store/spools.h"

struct frame;

/* What the owner is told; the frame may be dropped from inside each of these. */
struct frame_events {
    void *ctx;
    /* The verdict on a result that frame_result took over. */
    void (*judged)(void *ctx, struct frame *frame, uint64_t worker, const struct message_ack *ack);
    /* Pixels of `rect` are in the image. */
    void (*drawn)(void *ctx, struct frame *frame, struct rect rect);
    /* Tiles may wait again: of the next round of a frame that has some (proto/plan.h), or after the
     * frame was taken up. */
    void (*extended)(void *ctx, struct frame *frame);
    /* All tiles have landed with all their passes: workers may forget the frame. */
    void (*traced)(void *ctx, struct frame *frame);
    /* Of a frame that is kept: all of its pixels are there as they will stay. */
    void (*completed)(void *ctx, struct frame *frame);
    /* The files are stored as objects. */
    void (*encoded)(void *ctx, struct frame *frame, const struct digest *exr,
                    const struct digest *png);
    /* They could not be, for now: frame_store tries again. NULL: the frame fails. */
    void (*unstored)(void *ctx, struct frame *frame, const struct fault *fault);
    void (*failed)(void *ctx, struct frame *frame, const struct fault *fault);
};

struct frame_options {
    uint64_t id; /* on the wire */
    int32_t number;
    uint32_t layers;
    struct exr_metadata metadata; /* its strings are borrowed for the frame's life */
    const struct plan *plan;      /* copied */
    struct thread_pool *pool;
    struct scratch *scratch; /* of the pool's work on blocks; borrowed until the frame's last task
                                is over; NULL: one of its own */
    const struct objects *objects;
    struct spools *spools;  /* where its tiles are kept until it has its files; NULL: nowhere */
    char job[JOB_ID_BYTES]; /* its name there, with the number */
    bool kept;              /* its files are not made when it is complete, but by frame_store */
    /* Of each tile, passes that count already when the spool has them (shelved_frame.h); borrowed
     * until it is dropped; NULL: none. */
    const uint32_t *counted;
    struct frame_events events;
};

/* ERR_MEMORY, ERR_LIMIT. The frame starts in state rendering. */
int frame_create(const struct frame_options *options, struct frame **out);

/* No more events. Nulls the pointer. */
void frame_drop(struct frame **frame);

uint64_t frame_id(const struct frame *f);
int32_t frame_number(const struct frame *f);
enum frame_state frame_state(const struct frame *f);
const struct image *frame_image(const struct frame *f);
const struct exr_metadata *frame_metadata(const struct frame *f);
const struct statistics *frame_statistics(const struct frame *f); /* tiles and CPU so far */
uint64_t frame_revision(const struct frame *f); /* blocks drawn, each time that they were */
/* Every pass of a tile (proto/plan.h) counts as a tile: a worker is given one at a time. */
uint32_t frame_tiles_total(const struct frame *f);
struct rect frame_tile_rect(const struct frame *f, uint32_t index); /* of one that it gives out */
uint32_t frame_tile_count(const struct frame *f);                   /* each once */
uint32_t frame_tile_passes(const struct frame *f, uint32_t index);  /* of one, that have landed */
uint32_t frame_tiles_planned(const struct frame *f); /* of these, those that the plan tells of */
uint32_t frame_tiles_landed(const struct frame *f);
uint32_t frame_tiles_waiting(const struct frame *f); /* that can be leased now */
/* Samples that have landed, of all: passes differ in length. 1 only when all have. */
double frame_traced_share(const struct frame *f);
const uint8_t *frame_plan_bytes(const struct frame *f, uint32_t *size_bytes);

/* From now on tiles are given in that order: with a region, those that its pixels need. */
void frame_steer(struct frame *f, const struct tile_priority *priority);

/* Of a frame that is kept: `completed` was told; makes its files, once, after that; of any after
 * `unstored`. */
bool frame_is_complete(const struct frame *f);
void frame_store(struct frame *f);

/* What there is to warn of when the frame is encoded: a sentence, "" for nothing. */
const char *frame_warning(const struct frame *f);

/* Whether it failed by what workers did or said of a tile, which begins again with it. */
bool frame_was_given_up(const struct frame *f);

/* Why the last result that did not fit the plan was refused. Borrowed. */
const struct fault *frame_refusal(const struct frame *f);

/* Takes up what an earlier run had of the frame, before the first tile is given: false while that
 * is looked for (`extended` comes then). Workers trace with this version of Embree. */
bool frame_take_up(struct frame *f, const char *embree);

/* The next tile and pass for a worker. False when none waits, or when reconstruction is so far
 * behind that more samples would only fill memory; frame_was_held then says once that it goes on.
 */
bool frame_lease(struct frame *f, const struct worker_request *request, struct fleet_tile *out);
/* What it asks of a worker: of each pixel its layers (as one), paths and bounce rays. */
uint64_t frame_tile_samples(const struct frame *f, const struct fleet_tile *tile);
/* The next tile has seen a worker die: this one should first be done with what it holds. */
bool frame_waits_for_free(const struct frame *f, const struct worker_request *request);
/* A copy of a leased tile, as it is leased. */
bool frame_copy(struct frame *f, uint64_t worker, uint32_t capabilities,
                const struct fleet_tile *of, struct fleet_tile *out);
bool frame_was_held(struct frame *f);

/* A verdict, or 0 when *bytes was taken over and `judged` follows. */
uint32_t frame_result(struct frame *f, uint64_t worker, const struct message_result *result,
                      uint8_t **bytes, uint32_t size_bytes);

/* A lease that came back; the frame may fail by it (event). True when the tile waits again: false
 * after a failure, and for a tile that landed by a copy or that another worker has. */
bool frame_returned(struct frame *f, uint64_t worker, const struct fleet_tile *tile,
                    enum fleet_return why);
/* A worker did not die of the tiles that came back from it so. */
void frame_survived(struct frame *f, uint64_t worker);
void frame_faulted(struct frame *f, uint64_t worker, const struct message_tile_fault *fault);
