#pragma once
/* The inside of a frame, shared by the files that work on it. frame.c keeps the books,
 * frame_results.c turns results into blocks, and frame_spool.c reads results of an earlier run.
 * frame_neighbours.c waits for other frames. frame_denoise.c filters a frame as a whole.
 * frame_rounds.c decides when there are passes after the schedule, frame_target.c and
 * frame_adaptive.c which; frame_glance.c looks ahead of the former for the time left. frame_files.c
 * turns the image into files. */
#include <pthread.h>
#include <stdatomic.h>
#include <uv.h>

#include "server/film/film.h"
#include "server/job/frame/cost_map.h"
#include "server/job/frame/fingerprint.h"
#include "server/job/frame/frame.h"
#include "server/job/frame/picture_file.h"
#include "server/job/frame/rounds.h"
#include "server/job/frame/tile_queue.h"
#include "server/reconstruct/block.h"
#include "server/reconstruct/oidn/oidn.h"

/* The rounds of a frame that has some (proto/plan.h). */
struct frame_rounds {
    uint32_t *more_passes;               /* owned; of each tile */
    struct block_statistics *statistics; /* owned; of each block, as it was drawn last */
    double shown;                        /* share of the work that was reported */
};

/* What is measured in the picture of a frame with a target, for the next round. */
struct frame_target {
    struct rounds *rounds; /* owned */
    float *pixels;         /* owned; ERROR_SOURCE_COUNT variances and luminance, plane by plane */
    struct rounds_error *errors; /* owned; of each tile */
    double *squares;             /* owned; of each tile, the sum of its errors' variances */
    uint32_t *order;             /* owned; in which tiles are traced in the next round */
    uint32_t seen, seen_next;    /* blocks of this round; at so many it is foreseen anew */
    bool glancing;               /* a task is out */
    uint32_t glances;            /* in this round */
    double glances_all, glance_us;
    char warning[LIMIT_DETAIL_BYTES];
};

/* The second set of rays, or of paths through the lens, of a tile. */
struct frame_adaptive_tile {
    const uint8_t *strata_maps; /* of its pixels, row by row, map after map; in frame_adaptive */
    uint32_t most;              /* of these */
    size_t packed;              /* where its count maps begin in `packed` */
    uint32_t packed_bytes;
    uint64_t rays;
};

/* The second sets of a frame that has some. They are of bounce rays (plan_adaptive), with rays of
 * glossy lobes where the plan has a second map, or of paths through the lens. */
struct frame_adaptive {
    uint32_t maps;        /* plan_strata_maps */
    uint8_t *pixels;      /* owned; l of the second set, map by map of the whole image as blocks are
                             drawn; of lenses levels of lens_second_set.h until it is decided */
    uint8_t *strata_maps; /* owned; the same, tile by tile */
    uint32_t *measured;   /* owned; first sets of each block's pixels */
    struct frame_adaptive_tile *tiles; /* owned */
    struct bytes_writer packed;        /* count_map.h, tile by tile */
    double seen_px, seen_rays;         /* of the blocks that were drawn, before it is decided */
    uint64_t rays;                     /* of all second sets; once decided */
    bool decided;
};

/* The spool of a frame whose tiles are kept on disk. */
enum frame_spool_state { FRAME_SPOOL_CLOSED, FRAME_SPOOL_OPENING, FRAME_SPOOL_READY };
struct frame_spool {
    enum frame_spool_state state;
    struct spool *spool; /* owned; NULL: it has none */
    uint32_t *taken;     /* owned; received tiles whose pass is yet to be read, the last goes
                            first; NULL: nothing was there when the spool was opened */
    uint32_t taken_count;
    unsigned reading; /* tasks */
};

/* The frames beside a frame, where its plan asks for them. */
enum frame_wait { FRAME_TRACES, FRAME_CONDENSES, FRAME_WAITS, FRAME_DRAWS };
struct frame_neighbours {
    enum frame_wait state;
    struct residual_history *history;           /* held; NULL before it is traced */
    uint32_t condensing;                        /* tasks */
    int error;                                  /* of one of these; 0: none */
    struct frame_window held;                   /* its frames are held */
    struct residual_window windows[PLAN_VIEWS]; /* the same, as filters of a view read it */
};

/* A file that a frame leaves behind. One task works on each at a time. */
struct frame_file {
    struct pool_task task;
    struct frame *frame;
    struct picture_file picture;
    int32_t end;  /* rows that were given to it */
    bool is_out;  /* on the pool, which alone then touches what is here but `frame` */
    bool is_last; /* its last task: it was given all rows */
    bool is_stored;
    bool waits; /* for the end: it failed before */
    struct digest digest;
    struct fault fault;
    int error;
    bool is_held; /* stored and held, until `encoded` is told */
};
struct frame_files {
    struct frame_file of[PICTURE_FILE_COUNT];
    bool closing; /* the image is whole; `encoded` is not told yet */
};

/* What Open Image Denoise filters of a frame, where its plan asks for it, once all is drawn. */
struct frame_denoise {
    struct pool_task task;
    struct frame *frame;
    struct oidn_picture left; /* owned; all NULL without, and when it is filtered */
    const struct oidn_library *library;
    bool is_shown;
    pthread_t caller;
    uint64_t beside_us; /* CPU time of the library's own thread, where it has one */
    struct fault fault;
    int error;
};

/* What is traced for one view of a frame. */
struct frame_view {
    struct film *film;   /* owned */
    struct image *image; /* owned; on the loop's thread */
};

struct frame {
    struct fault refusal;         /* of the last result that did not fit the plan */
    struct frame_options options; /* options.plan points to `plan` */
    struct plan plan;
    struct motion *motion; /* held; NULL: nothing moves */
    struct bytes_writer plan_bytes;
    struct tile_grid grid;
    struct tile_queue *tiles;
    int32_t block_px;      /* side of the film's blocks */
    struct plan view_plan; /* of one view; the plan itself where there is one */
    struct frame_view views[PLAN_VIEWS];
    uint8_t *block_views;       /* owned; of each block: bits of the views that it was drawn of */
    struct film *film;          /* of the first view, as `image` */
    struct frame_rounds rounds; /* all NULL without rounds */
    struct frame_target target; /* all NULL without one */
    struct frame_adaptive adaptive; /* all NULL without */
    struct frame_neighbours neighbours;
    struct frame_denoise denoise;
    struct frame_spool spool;
    struct scratch *scratch, *own_scratch; /* of the pool's work on blocks; NULL: it is borrowed */
    struct image *image; /* on the loop's thread, but rows that are final: the pool reads them */
    struct frame_files files;
    uint64_t begun_us, arrived_us, drawn_us; /* when; `arrived`: its last result so far */
    enum frame_state state;
    struct statistics statistics;
    uint64_t samples_landed; /* a tile's pass counts as its samples a pixel; with rounds, as those
                                of all its pixels */
    struct cost_map costs;
    uint64_t blocks_drawn;
    uint32_t blocks_out; /* on the pool */
    uint32_t tasks;      /* on the pool, of any kind */
    bool held;
    bool complete; /* of a frame that is kept */
    bool given_up; /* by its workers */
    char fingerprint[FINGERPRINT_BYTES];
    atomic_bool dropped; /* the pool skips what is queued */
};

/* Counts a task and hands it to the pool. frame_task_over takes the count back and frees a dropped
 * frame with its last task. Returns whether the frame is still wanted. */
void frame_task_submit(struct frame *f, struct pool_task *task);
bool frame_task_over(struct frame *f);

/* Returns the samples per pixel of a pass, the measure of progress. Paths count, and bounce rays,
 * as each goes on as a path does. It is at least one. */
uint32_t frame_pass_samples(const struct plan_pass *pass);
/* Returns the samples of all pixels of a tile, which may differ, with those of the lens. */
uint64_t frame_pass_work(const struct plan *plan, const struct plan_pass *pass, uint32_t area);

/* Returns what a pass of a tile traces. */
struct plan_pass frame_pass(const struct frame *f, uint32_t tile, uint32_t number);

/* Returns how many blocks at a time are in the pool before tiles are held back. */
uint32_t frame_blocks_out_max(const struct frame *f);

/* Returns whether reconstruction is so far behind that more samples would only fill memory. */
bool frame_is_behind(const struct frame *f);

/* -- frame_results.c -- */

/* Lands a received tile's pass, and counts it, unless it counts already (counters NULL). Blocks
 * that are ready go to the pool. On failure the frame has failed, and may be gone. */
int frame_land(struct frame *f, uint32_t tile, const struct plan_pass *pass,
               struct samples **samples, const struct counters *counters);

/* Hands blocks that are ready to the pool. */
int frame_submit_ready(struct frame *f);

/* -- frame_views.c -- */

int frame_views_create(struct frame *f);
void frame_views_destroy(struct frame *f);
/* Returns a pass of the frame's as its view counts it. */
struct plan_pass frame_view_pass(const struct frame *f, const struct plan_pass *pass);
/* Return what films do of one view (film.h), of all. */
uint64_t frame_pending(const struct frame *f);
int32_t frame_rows_done(const struct frame *f);
bool frame_films_complete(const struct frame *f);
/* Returns whether of a view only pixels that show surfaces are wanted: of others it is nothing. */
bool frame_view_is_of_surfaces(const struct frame *f, uint32_t view);
/* Composes what the views show (catcher.h). */
void frame_views_compose(struct frame *f, struct rect rect);
/* Notes that a block was drawn of a view, and composes it. Then the block rests, as its task took
 * cpu_us. */
void frame_views_drawn(struct frame *f, uint32_t view, uint32_t block, uint64_t cpu_us);

/* -- frame_neighbours.c: frames that are drawn with samples of others -- */

static inline bool frame_has_neighbours(const struct frame *f)
{
    return f->plan.temporal > 0;
}
/* Holds blocks back from the start. */
void frame_neighbours_begin(struct frame *f);
void frame_neighbours_destroy(struct frame *f);
/* Makes the frame's history once all its tiles have landed. On failure the frame has failed, and
 * may be gone. */
int frame_neighbours_note(struct frame *f);

/* -- frame_denoise.c: frames that Open Image Denoise filters -- */

int frame_denoise_create(struct frame *f);
void frame_denoise_destroy(struct frame *f);
/* Returns whether pixels change once more when all are drawn. */
static inline bool frame_has_denoiser(const struct frame *f)
{
    return f->denoise.left.light != NULL;
}
/* Keeps what paths bring to a block, on a thread of the pool. */
void frame_denoise_keep(struct frame *f, const struct patch *patch, struct rect rect);
/* Filters a frame of which all is drawn, and encodes it. Without such a filter it is encoded at
 * once. */
void frame_denoise_end(struct frame *f);

/* -- frame_spool.c: what an earlier run of the coordinator had -- */

void frame_spool_destroy(struct frame *f);
/* Takes tiles whose next pass the spool has out of those that wait. */
void frame_spool_take(struct frame *f);
/* Reads on, as far as reconstruction keeps up. */
void frame_spool_feed(struct frame *f);
/* Returns whether the spool has the pass after the one that a tile is received for. It is read once
 * that one has landed. */
bool frame_spool_has_next(const struct frame *f, uint32_t tile);
void frame_spool_push(struct frame *f, uint32_t tile);
/* Keeps a landed pass as a worker sent it. Takes the bytes if there is a spool. */
void frame_spool_keep(struct frame *f, uint32_t tile, const struct plan_pass *pass,
                      const struct counters *counters, uint8_t **bytes, uint32_t size_bytes);

/* -- frame_rounds.c: frames with passes after the schedule -- */

int frame_rounds_create(struct frame *f);
void frame_rounds_destroy(struct frame *f);
static inline bool frame_has_rounds(const struct frame *f)
{
    return f->rounds.more_passes != NULL;
}
/* Decides on the pool, once all blocks are drawn, whether there is another round. Begins it or ends
 * the frame. */
void frame_rounds_decide(struct frame *f);
/* Updates the share of the work that is done, which never shrinks. */
void frame_rounds_note(struct frame *f);

/* -- frame_target.c: sampling until a target error is reached -- */

int frame_target_create(struct frame *f);
void frame_target_destroy(struct frame *f);
static inline bool frame_has_target(const struct frame *f)
{
    return f->target.rounds != NULL;
}
/* Keeps what was measured in a block's pixels. `measure` is of the block, not of the image. */
void frame_target_keep(struct frame *f, struct rect rect, const struct block_measure *measure);
/* Foresees anew, now and then, from a block that has all samples of the round. */
void frame_target_see(struct frame *f, struct rect rect);
/* Does so from a tile that was looked at alone. */
void frame_target_glanced(struct frame *f, uint32_t tile, const struct rounds_error *error);
/* Looks at a tile that has landed, if that is worth its time. */
void frame_glance(struct frame *f, uint32_t tile);
/* Decides whether any tile gets more passes. It runs on the pool, when no other task touches the
 * frame's rounds. */
bool frame_target_decide(struct frame *f, int *error);
/* Counts what was decided, on the loop's thread. */
void frame_target_count(struct frame *f);
/* Warns, after the last round, if the target was not reached. */
void frame_target_end(struct frame *f);

/* -- frame_adaptive.c: second sets -- */

int frame_adaptive_create(struct frame *f);
void frame_adaptive_destroy(struct frame *f);
static inline bool frame_is_adaptive(const struct frame *f)
{
    return f->adaptive.pixels != NULL;
}
/* Returns whether a block that is drawn now has to choose its pixels' second sets. */
static inline bool frame_wants_strata_maps(const struct frame *f)
{
    return frame_is_adaptive(f) && !f->adaptive.decided;
}
/* Keeps a block's second sets, map by map, row by row. */
void frame_adaptive_keep(struct frame *f, uint32_t block, const uint8_t *strata_maps,
                         uint32_t measured);
/* Decides as frame_target_decide does. *error: ERR_MEMORY. */
bool frame_adaptive_decide(struct frame *f, int *error);
void frame_adaptive_count(struct frame *f);
struct plan_pass frame_adaptive_pass(const struct frame *f, uint32_t tile, uint32_t number);

/* Fails the frame and tells its owner. The frame may be gone afterwards. */
void frame_fail(struct frame *f, int code, const char *pointer, const char *detail);

/* -- frame_files.c -- */

void frame_files_init(struct frame *f);
void frame_files_drop(struct frame *f);
/* Gives rows that have become final to the pool, to be encoded. */
void frame_files_feed(struct frame *f);

/* Returns the loop's monotonic time. */
static inline uint64_t frame_clock_us(void)
{
    return uv_hrtime() / 1000;
}

/* Ends a frame whose image is whole. The pool writes what is left of EXR and PNG, and `encoded` or
 * `failed` follows. For a frame that is kept, `completed` does. */
void frame_encode(struct frame *f);

/* Return the samples of all pixels of the first set, and those that a frame with rounds is thought
 * to take in all. */
double frame_rounds_first(const struct frame *f);
double frame_rounds_expected(const struct frame *f);

/* Note what is due, at the start and with each round, and what has landed with the CPU time that it
 * took (frame_left.c). */
void frame_costs_create(struct frame *f);
void frame_costs_foresee(struct frame *f);
void frame_costs_foresee_anew(struct frame *f); /* within a round */
void frame_costs_land(struct frame *f, uint32_t tile, double samples,
                      const struct counters *counters);
