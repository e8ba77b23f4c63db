/* Frames that are sampled in rounds: the schedule's passes, and what is decided on when all of the
 * picture has been drawn with these; so what is decided depends on the samples alone and not on
 * when they came. */
#include <stdlib.h>

#include "server/job/frame/frame_work.h"

/* The greatest share of work that is reported before a frame is known to be done. */
#define SHARE_MAX 0.99

/* The expected ratio of all rays to those of the first set, before any second set is known. */
#define RATE_EXPECTED 3.0

int frame_rounds_create(struct frame *f)
{
    struct frame_rounds *r = &f->rounds;
    r->more_passes = calloc(tile_grid_count(&f->grid), sizeof *r->more_passes);
    r->statistics = calloc(film_block_count(f->film), sizeof *r->statistics);
    if (!r->more_passes || !r->statistics) return ERR_MEMORY;
    return f->plan.target_error > 0.0f ? frame_target_create(f) : frame_adaptive_create(f);
}

void frame_rounds_destroy(struct frame *f)
{
    frame_target_destroy(f);
    frame_adaptive_destroy(f);
    free(f->rounds.more_passes);
    free(f->rounds.statistics);
}

/* At least one a pixel. */
double frame_rounds_first(const struct frame *f)
{
    const double pixels = (double)f->plan.width_px * f->plan.height_px;
    const uint32_t l = f->plan.indirect_strata_per_axis;
    /* paths of the lens are its samples */
    const uint32_t lens = plan_lens_has_paths(&f->plan) ? 0 : f->plan.lens_strata_per_axis;
    return pixels * (f->plan.paths.spp + l * l + lens * lens);
}

double frame_rounds_expected(const struct frame *f)
{
    const struct frame_adaptive *a = &f->adaptive;
    const double pixels = (double)f->plan.width_px * f->plan.height_px;
    if (frame_has_target(f)) return rounds_report(f->target.rounds).expected[FORESEEN_LIKELY];
    const double first = frame_rounds_first(f);
    if (a->decided) return first + (double)a->rays;
    if (f->plan.lens_extra > 0) return first + pixels * f->plan.lens_extra;
    return a->seen_px > 0.0 ? first + pixels * a->seen_rays / a->seen_px : first * RATE_EXPECTED;
}

void frame_rounds_note(struct frame *f)
{
    const double share = (double)f->samples_landed / frame_rounds_expected(f);
    if (share > f->rounds.shown) f->rounds.shown = share < SHARE_MAX ? share : SHARE_MAX;
}

struct decide_task {
    struct pool_task task;
    struct frame *frame;
    int error;
    bool more;
};

/* Decides on the pool. No block and no tile is out, so no other task touches rounds or
 * measurements. */
static void decide_run(struct pool_task *task)
{
    struct decide_task *t = (struct decide_task *)task;
    struct frame *f = t->frame;
    if (atomic_load(&f->dropped)) return;
    t->more = frame_has_target(f) ? frame_target_decide(f, &t->error)
                                  : frame_adaptive_decide(f, &t->error);
}

static void end(struct frame *f)
{
    film_release(f->film);
    for (uint32_t i = 0; i < film_block_count(f->film); i++)
        statistics_add_block(&f->statistics, &f->rounds.statistics[i]);
    if (frame_has_target(f)) frame_target_end(f);
    f->rounds.shown = 1.0;
    f->tasks++; /* held: the owner may drop the frame */
    f->options.events.traced(f->options.events.ctx, f);
    if (frame_task_over(f)) frame_denoise_end(f);
}

static void go_on(struct frame *f)
{
    film_begin_round(f->film, f->rounds.more_passes);
    if (frame_has_target(f)) tile_queue_reorder(f->tiles, f->target.order);
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++)
        if (f->rounds.more_passes[i] > 0) tile_queue_extend(f->tiles, i, f->rounds.more_passes[i]);
    frame_spool_take(f);
    f->options.events.extended(f->options.events.ctx, f);
}

static void decided(struct frame *f, const struct decide_task *t)
{
    f->statistics.reconstruct_cpu_us += t->task.cpu_us;
    if (t->error) {
        frame_fail(f, t->error, "", "no memory to deal further samples");
        return;
    }
    if (frame_has_target(f))
        frame_target_count(f);
    else
        frame_adaptive_count(f);
    frame_rounds_note(f);
    if (t->more)
        go_on(f);
    else
        end(f);
}

static void decide_done(struct pool_task *task)
{
    struct decide_task *t = (struct decide_task *)task;
    if (frame_task_over(t->frame)) decided(t->frame, t);
    free(t);
}

void frame_rounds_decide(struct frame *f)
{
    struct decide_task *t = calloc(1, sizeof *t);
    if (!t) {
        frame_fail(f, ERR_MEMORY, "", "no memory to decide on further samples");
        return;
    }
    t->task = (struct pool_task){.run = decide_run, .done = decide_done};
    t->frame = f;
    frame_task_submit(f, &t->task);
}
