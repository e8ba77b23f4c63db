/* Glances at tiles of a frame with a target, for the time left. A block is drawn when all that its
 * filter reads has landed; in a small picture that is the end of a round, and errors would be known
 * no earlier. So tiles are filtered alone as they land, with few pixels around them. Their errors
 * tell enough of the round; no pixel and no decision depends on them. */
#include <math.h>
#include <stdlib.h>

#include "server/job/frame/frame_work.h"
#include "server/reconstruct/block.h"
#include "server/reconstruct/patch/scratch.h"

#define AROUND_PX   16   /* what filters weigh most */
#define GLANCES_MAX 8u   /* in a round */
#define SHARE_MAX   0.02 /* of the time that tracing takes up to the end of the round */
#define BLOCKS_FEW  64u  /* in a picture of more some are drawn early */

struct glance_task {
    struct pool_task task;
    struct frame *frame;
    uint32_t tile, round;
    struct patch *patch; /* owned */
    struct image *image; /* owned; of the tile */
    struct rounds_error error;
    bool failed;
};

/* Makes the image's planes begin at the tile, as they would in the whole picture. */
static struct image image_of_tile(const struct frame *f, const struct image *image,
                                  struct rect rect)
{
    struct image view = *image;
    view.width_px = f->plan.width_px;
    view.height_px = f->plan.height_px;
    for (uint32_t c = 0; c < view.channel_count; c++) {
        struct plane *plane = &view.channels[c].plane;
        const ptrdiff_t corner = rect.y0 * plane->stride + rect.x0;
        plane->data = (float *)((uintptr_t)plane->data - (uintptr_t)corner * sizeof *plane->data);
    }
    return view;
}

static void glance_run(struct pool_task *task)
{
    struct glance_task *t = (struct glance_task *)task;
    struct frame *f = t->frame;
    const struct rect rect = tile_grid_rect(&f->grid, t->tile);
    const size_t area = (size_t)rect_area(rect);
    struct block_statistics statistics = {0};
    struct block_measure measure;
    float *planes = NULL;
    t->failed = true;
    if (atomic_load(&f->dropped)) return;
    planes = calloc(area * (ERROR_SOURCE_COUNT + 1), sizeof *planes);
    if (!planes) return;
    for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++) measure.variance[k] = planes + area * k;
    measure.luminance = planes + area * ERROR_SOURCE_COUNT;
    struct image view = image_of_tile(f, t->image, rect);
    t->failed = block_reconstruct_measured(&f->view_plan, t->patch, rect, &view, &measure,
                                           &statistics) != 0;
    for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++)
        for (size_t i = 0; i < area; i++) t->error.variance[k] += (double)measure.variance[k][i];
    for (size_t i = 0; i < area; i++) t->error.luminance += (double)measure.luminance[i];
    free(planes);
}

static void destroy(struct glance_task *t)
{
    patch_destroy(&t->patch);
    image_destroy(&t->image);
    free(t);
}

/* While a round is decided on, and after it, what was seen in it is of no use. */
static void glance_done(struct pool_task *task)
{
    struct glance_task *t = (struct glance_task *)task;
    struct frame *f = t->frame;
    f->tasks++; /* held until its scratch has the patch back */
    if (frame_task_over(f)) {
        struct frame_target *target = &f->target;
        target->glancing = false;
        target->glance_us += (double)t->task.cpu_us;
        f->statistics.reconstruct_cpu_us += t->task.cpu_us;
        if (!t->failed && t->round == f->statistics.target_rounds && !frame_films_complete(f))
            frame_target_glanced(f, t->tile, &t->error);
    }
    destroy(t);
    (void)frame_task_over(f);
}

static bool has_all(const struct frame *f, uint32_t tile)
{
    return tile_queue_pass(f->tiles, tile) == tile_queue_passes(f->tiles, tile);
}

static bool is_worth_it(const struct frame *f, uint32_t tile)
{
    const struct frame_target *t = &f->target;
    const double each_us = t->glance_us / fmax(1.0, t->glances_all);
    const struct rounds_report round = rounds_report(t->rounds);
    const double traced_us = frame_done_us(f) * (double)(round.paths + round.bounces) /
                             fmax(1.0, (double)f->samples_landed);
    return !t->glancing && t->glances < GLANCES_MAX && plan_views(&f->plan) == 1 &&
           block_halo_px(&f->plan) > 0 && film_block_count(f->film) <= BLOCKS_FEW &&
           has_all(f, tile) && t->glance_us + each_us <= SHARE_MAX * traced_us;
}

void frame_glance(struct frame *f, uint32_t tile)
{
    if (!is_worth_it(f, tile)) return;
    struct frame_target *target = &f->target;
    const struct rect rect = tile_grid_rect(&f->grid, tile);
    const struct rect all = {0, 0, f->plan.width_px, f->plan.height_px};
    /* In the first round those around it may not have landed. */
    const int32_t around = f->statistics.target_rounds > 0 ? AROUND_PX : 0;
    struct glance_task *t = calloc(1, sizeof *t);
    if (!t) return;
    *t = (struct glance_task){.task = {.run = glance_run, .done = glance_done},
                              .frame = f,
                              .tile = tile,
                              .round = (uint32_t)f->statistics.target_rounds};
    if (image_create(LAYER_BEAUTY, rect_width(rect), rect_height(rect), &t->image) != 0 ||
        film_gather_rect(f->film, rect_intersect(rect_grow(rect, around), all), &t->patch) != 0) {
        destroy(t);
        return;
    }
    target->glancing = true;
    target->glances++;
    target->glances_all += 1.0;
    frame_task_submit(f, &t->task);
}
