/* Frames that are sampled until a target error is reached: round by round, with all of the picture
 * drawn in between, so that what is decided depends on the samples alone and not on when they came.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/frame_work.h"

/* What a frame is said to have done at most before it is known to be done. */
#define SHARE_MOST 0.99

int frame_target_create(struct frame *f)
{
    struct frame_target *t = &f->target;
    const size_t area = (size_t)f->plan.width_px * (size_t)f->plan.height_px;
    const uint32_t tiles = tile_grid_count(&f->grid);
    t->pixels = calloc(area * (SOURCE_COUNT + 1), sizeof *t->pixels);
    t->more_passes = calloc(tiles, sizeof *t->more_passes);
    t->errors = calloc(tiles, sizeof *t->errors);
    t->statistics = calloc(film_block_count(f->film), sizeof *t->statistics);
    if (!t->pixels || !t->more_passes || !t->errors || !t->statistics) return ERR_MEMORY;
    return rounds_create(&f->plan, &t->rounds);
}

void frame_target_destroy(struct frame *f)
{
    struct frame_target *t = &f->target;
    rounds_destroy(&t->rounds);
    free(t->pixels);
    free(t->more_passes);
    free(t->errors);
    free(t->statistics);
}

static float *plane_of(const struct frame *f, uint32_t k)
{
    return f->target.pixels + (size_t)k * (size_t)f->plan.width_px * (size_t)f->plan.height_px;
}

void frame_target_keep(struct frame *f, uint32_t block, struct rect rect,
                       const struct block_measure *measure,
                       const struct block_statistics *statistics)
{
    const size_t width = (size_t)rect_width(rect), stride = (size_t)f->plan.width_px;
    for (uint32_t k = 0; k <= SOURCE_COUNT; k++) {
        const float *from = k < SOURCE_COUNT ? measure->square[k] : measure->luminance;
        float *to = plane_of(f, k) + (size_t)rect.y0 * stride + (size_t)rect.x0;
        for (int32_t y = rect.y0; y < rect.y1; y++, from += width, to += stride)
            memcpy(to, from, width * sizeof *from);
    }
    f->target.statistics[block] = *statistics;
}

/* Pixel by pixel and row by row, whatever the blocks were. */
static double sum_over(const struct frame *f, uint32_t k, struct rect rect)
{
    double sum = 0.0;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const float *row = plane_of(f, k) + (size_t)y * (size_t)f->plan.width_px;
        for (int32_t x = rect.x0; x < rect.x1; x++) sum += (double)row[x];
    }
    return sum;
}

void frame_target_note(struct frame *f)
{
    const double expected = rounds_report(f->target.rounds).expected;
    const double share = (double)f->samples_landed / expected; /* at least a sample a pixel */
    if (share > f->target.shown) f->target.shown = share < SHARE_MOST ? share : SHARE_MOST;
}

struct decide_task {
    struct team_task task;
    struct frame *frame;
    bool more;
};

/* Nothing else touches rounds or what was measured meanwhile: no block is out, and no tile is. */
static void decide_run(struct team_task *task)
{
    struct decide_task *t = (struct decide_task *)task;
    struct frame *f = t->frame;
    if (atomic_load(&f->dropped)) return;
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++) {
        const struct rect rect = tile_grid_rect(&f->grid, i);
        for (uint32_t k = 0; k < SOURCE_COUNT; k++)
            f->target.errors[i].square[k] = sum_over(f, k, rect);
        f->target.errors[i].luminance = sum_over(f, SOURCE_COUNT, rect);
    }
    t->more = rounds_decide(f->target.rounds, f->target.errors, f->target.more_passes);
}

static uint64_t millionths(double v)
{
    return v < 1e9 ? (uint64_t)(1e6 * v + 0.5) : UINT64_C(1000000000000000);
}

static void count(struct frame *f, const struct rounds_report *report)
{
    struct statistics *s = &f->statistics;
    for (uint32_t i = 0; i < film_block_count(f->film); i++)
        frame_count_pixels(s, &f->target.statistics[i]);
    s->target_error = millionths(report->reached);
    s->target_threshold = millionths(report->threshold);
}

static void warn(struct frame *f, const struct rounds_report *report)
{
    const double target = (double)f->plan.target_error;
    if (report->met) return;
    if (report->fixed > target)
        snprintf(
            f->target.warning, sizeof f->target.warning,
            "frame %d: sampling ended at an estimated error of %.3g, above the target of %.3g: "
            "%.3g of it lies in edges within pixels, which more samples do not change",
            f->options.number, report->reached, target, report->fixed);
    else
        snprintf(
            f->target.warning, sizeof f->target.warning,
            "frame %d: sampling ended at an estimated error of %.3g, above the target of %.3g: "
            "%s",
            f->options.number, report->reached, target,
            "pixels have the most samples that sampling.max_spp allows");
}

static void end(struct frame *f, const struct rounds_report *report)
{
    film_release(f->film);
    count(f, report);
    warn(f, report);
    f->target.shown = 1.0;
    f->tasks++; /* held: the owner may drop the frame */
    f->options.events.traced(f->options.events.ctx, f);
    if (frame_task_over(f)) frame_encode(f);
}

static void go_on(struct frame *f)
{
    film_begin_round(f->film, f->target.more_passes);
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++)
        if (f->target.more_passes[i] > 0) tile_queue_extend(f->tiles, i, f->target.more_passes[i]);
    f->options.events.extended(f->options.events.ctx, f);
}

static void decide_done(struct team_task *task)
{
    struct decide_task *t = (struct decide_task *)task;
    struct frame *f = t->frame;
    if (frame_task_over(f)) {
        const struct rounds_report report = rounds_report(f->target.rounds);
        f->statistics.reconstruct_cpu_us += t->task.cpu_us;
        f->statistics.target_rounds = report.rounds;
        f->statistics.target_paths = report.paths;
        f->statistics.target_bounces = report.bounces;
        frame_target_note(f);
        if (t->more)
            go_on(f);
        else
            end(f, &report);
    }
    free(t);
}

void frame_target_decide(struct frame *f)
{
    struct decide_task *t = calloc(1, sizeof *t);
    if (!t) {
        frame_fail(f, ERR_MEMORY, "", "no memory to decide on further samples");
        return;
    }
    t->task = (struct team_task){.run = decide_run, .done = decide_done};
    t->frame = f;
    frame_task_submit(f, &t->task);
}
