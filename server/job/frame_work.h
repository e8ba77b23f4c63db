#pragma once
/* The inside of a frame, shared by the files that work on it: frame.c (book-keeping),
 * frame_results.c (results to blocks), frame_files.c (image to files). */
#include <stdatomic.h>

#include "server/film/film.h"
#include "server/job/frame.h"
#include "server/job/tile_queue.h"

struct frame {
    struct fault refusal;         /* of the last result that did not fit the plan */
    struct frame_options options; /* options.plan points to `plan` */
    struct plan plan;
    struct bytes_writer plan_bytes;
    struct tile_grid grid;
    struct tile_queue *tiles;
    struct film *film;
    struct scratch *scratch; /* of the team's work on blocks */
    struct image *image;     /* written and read on the loop's thread, until it is encoded */
    enum frame_state state;
    struct statistics statistics;
    uint64_t samples_landed; /* a tile's pass counts as its samples a pixel */
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

/* Samples a pixel of a pass, by which the work that is done is told: paths, and in the first pass
 * bounce rays, each of which goes on as a path does; at least one. */
uint32_t frame_pass_samples(const struct plan *plan, uint32_t pass);

/* Tells the owner; the frame may be gone afterwards. */
void frame_fail(struct frame *f, int code, const char *pointer, const char *detail);

/* Writes EXR and PNG on the team, then `encoded` or `failed`. */
void frame_encode(struct frame *f);
