#pragma once
/* The inside of a frame, shared by the files that work on it: frame.c (book-keeping),
 * frame_results.c (results to blocks), frame_files.c (image to files). */
#include <stdatomic.h>

#include "server/film/film.h"
#include "server/job/frame.h"
#include "server/job/rounds.h"
#include "server/job/tile_queue.h"
#include "server/reconstruct/block.h"

/* Of a frame with a target: what is measured of its picture, for the next round. */
struct frame_target {
    struct rounds *rounds;       /* owned */
    float *pixels;               /* owned; SOURCE_COUNT squares and luminance, plane by plane */
    uint32_t *more_passes;       /* owned; of each tile */
    struct rounds_error *errors; /* owned; of each tile */
    struct block_statistics *statistics; /* owned; of each block, as it was drawn last */
    char warning[LIMIT_DETAIL_BYTES];
    double shown; /* share of the work that was told of */
};

struct frame {
    struct fault refusal;         /* of the last result that did not fit the plan */
    struct frame_options options; /* options.plan points to `plan` */
    struct plan plan;
    struct bytes_writer plan_bytes;
    struct tile_grid grid;
    struct tile_queue *tiles;
    struct film *film;
    struct frame_target target; /* all NULL without one */
    struct scratch *scratch;    /* of the team's work on blocks */
    struct image *image;        /* written and read on the loop's thread, until it is encoded */
    enum frame_state state;
    struct statistics statistics;
    uint64_t samples_landed; /* a tile's pass counts as its samples a pixel, with a target of all
                                its pixels */
    uint64_t blocks_drawn;
    uint32_t blocks_out; /* on the team */
    uint32_t tasks;      /* on the team, of any kind */
    bool held;
    atomic_bool dropped; /* the team skips what is queued */
};

/* Hands a task to the team, which counts; frame_task_over takes the count back and frees a dropped
 * frame with its last task. True when the frame is still wanted. */
void frame_task_submit(struct frame *f, struct team_task *task);
bool frame_task_over(struct frame *f);

/* Samples a pixel of a pass, by which the work that is done is told: paths, and bounce rays, each
 * of which goes on as a path does; at least one. */
uint32_t frame_pass_samples(const struct plan_pass *pass);

/* What a pass of a tile traces. */
struct plan_pass frame_pass(const struct frame *f, uint32_t tile, uint32_t number);

/* -- frame_rounds.c: frames with a target -- */

int frame_target_create(struct frame *f);
void frame_target_destroy(struct frame *f);
static inline bool frame_has_target(const struct frame *f)
{
    return f->target.rounds != NULL;
}
/* Keeps what was measured of a block's pixels, in `measure` (block by block, not of the image). */
void frame_target_keep(struct frame *f, uint32_t block, struct rect rect,
                       const struct block_measure *measure,
                       const struct block_statistics *statistics);
/* All blocks are drawn: decides on the team whether there is another round, and begins it or ends
 * the frame. */
void frame_target_decide(struct frame *f);
/* Tells anew how much of the work is done, which never shrinks. */
void frame_target_note(struct frame *f);

/* Adds what a block's pixels count. */
void frame_count_pixels(struct statistics *sum, const struct block_statistics *block);

/* Tells the owner; the frame may be gone afterwards. */
void frame_fail(struct frame *f, int code, const char *pointer, const char *detail);

/* Writes EXR and PNG on the team, then `encoded` or `failed`. */
void frame_encode(struct frame *f);
