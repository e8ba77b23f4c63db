/* From a result's bytes to pixels: decode on the pool, land on the film, reconstruct on the pool.
 */
#include <stdlib.h>
#include <string.h>

#include "server/job/frame/frame_work.h"
#include "server/reconstruct/block.h"
#include "server/reconstruct/indirect/indirect_adaptive.h"
#include "server/reconstruct/motion/motion.h"
#include "server/reconstruct/patch/scratch.h"
#include "server/reconstruct/residual/residual_field.h"

/* A block's work. Its pixels are written beside the image and copied in on the loop's thread, so
 * that a reader of the forming picture sees no half-written numbers. */
struct block_task {
    struct pool_task task;
    struct frame *frame;
    uint32_t view, block;
    struct rect rect;
    float *pixels;                /* of the frame's scratch; channel by channel, and what is
                                     measured of them; before it runs those drawn before where
                                     these are added to, or NULL */
    bool drawn;                   /* the former */
    struct block_measure measure; /* of a frame with a target */
    uint8_t *strata_maps;         /* owned; of a frame that wants them, map by map */
    uint32_t measured;            /* with them: pixels that bounce rays left, and lobes' rays */
    struct block_statistics statistics;
    int error;
};

/* The frame's channels with memory for one block: plane_at(x0, y0) is the block's first pixel. The
 * address of the image's corner is never read; it is made as a number, since it may lie before the
 * allocation. */
static void make_view(const struct image *image, struct rect rect, float *pixels,
                      struct image *view)
{
    ptrdiff_t stride = rect_width(rect), area = stride * rect_height(rect);
    *view = *image;
    view->data = pixels;
    for (uint32_t c = 0; c < image->channel_count; c++) {
        ptrdiff_t corner = (ptrdiff_t)c * area - rect.y0 * stride - rect.x0;
        struct plane *plane = &view->channels[c].plane;
        plane->data = (float *)((uintptr_t)pixels + (uintptr_t)corner * sizeof(float));
        plane->stride = stride;
    }
}

static int find_strata_maps(struct block_task *t, const struct patch *patch)
{
    const struct plan *plan = &t->frame->plan;
    const int error = indirect_adaptive_find(plan, patch, t->rect, t->strata_maps);
    t->measured = (uint32_t)patch_count_measured(patch, t->rect);
    if (error || t->frame->adaptive.maps < 2) return error;
    t->measured += (uint32_t)patch_count_glossy(patch, t->rect);
    return indirect_adaptive_find_lobes(plan, patch, t->rect, t->strata_maps + rect_area(t->rect));
}

/* A view of a composite's surfaces is nothing beside them: there the block keeps its zeros, and
 * *patch is NULL where it shows none. */
static int gather(const struct block_task *t, struct rect *shown, struct patch **patch)
{
    const struct film *film = t->frame->views[t->view].film;
    if (frame_view_is_of_surfaces(t->frame, t->view))
        return film_gather_shown(film, t->block, RESIDUAL_PAD_PX, shown, patch);
    *shown = t->rect;
    return film_gather(film, t->block, patch);
}

/* Returns how many pixels of the block are none of the patch's, and show no surface. */
static uint64_t count_beside(const struct block_task *t, const struct rect *shown,
                             const struct patch *patch)
{
    return (uint64_t)(rect_area(t->rect) - (patch ? rect_area(*shown) : 0));
}

static int reconstruct(struct block_task *t)
{
    struct frame *f = t->frame;
    struct patch *patch = NULL;
    struct image view;
    const bool measured = frame_has_target(f);
    const struct image *image = f->views[t->view].image;
    const size_t area = (size_t)rect_area(t->rect), channels = image->channel_count;
    if (!t->pixels) {
        const size_t planes = channels + (measured ? ERROR_SOURCE_COUNT + 1 : 0);
        t->pixels = scratch_take(f->scratch, area * planes * sizeof *t->pixels);
        if (!t->pixels) return ERR_MEMORY;
        memset(t->pixels, 0, area * planes * sizeof *t->pixels);
    }
    make_view(image, t->rect, t->pixels, &view);
    for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++)
        t->measure.variance[k] = t->pixels + area * (measured ? channels + k : 0);
    t->measure.luminance = t->pixels + area * (measured ? channels + ERROR_SOURCE_COUNT : 0);
    struct rect shown;
    int error = gather(t, &shown, &patch);
    if (!error) t->statistics.pixels_background += count_beside(t, &shown, patch);
    if (error || !patch) return error;
    if (f->plan.lens_extra > 0) patch->lens_levels = t->strata_maps;
    patch->lens_drawn = t->drawn;
    if (frame_has_neighbours(f)) patch->window = &f->neighbours.windows[t->view];
    if (measured)
        error = block_reconstruct_measured(&f->view_plan, patch, t->rect, &view, &t->measure,
                                           &t->statistics);
    else
        error = block_reconstruct(&f->view_plan, patch, shown, &view, &t->statistics);
    if (!error && !frame_view_is_of_surfaces(f, t->view))
        motion_compose(f->motion, &f->plan, patch, t->rect, &view);
    if (!error) frame_denoise_keep(f, patch, t->rect);
    if (!error && t->strata_maps && f->plan.indirect_filter == INDIRECT_FILTER_ADAPTIVE)
        error = find_strata_maps(t, patch);
    patch_destroy(&patch);
    return error;
}

static void block_run(struct pool_task *task)
{
    struct block_task *t = (struct block_task *)task;
    if (!atomic_load(&t->frame->dropped)) t->error = reconstruct(t);
}

static void copy_pixels(const struct block_task *t, struct image *image)
{
    int32_t width = rect_width(t->rect), height = rect_height(t->rect);
    const float *from = t->pixels;
    for (uint32_t c = 0; c < image->channel_count; c++)
        for (int32_t y = 0; y < height; y++, from += width)
            memcpy(plane_at(&image->channels[c].plane, t->rect.x0, t->rect.y0 + y), from,
                   (size_t)width * sizeof *from);
}

/* The block as it was drawn before. */
static int take_pixels(struct scratch *scratch, struct block_task *t, const struct image *image)
{
    const size_t width = (size_t)rect_width(t->rect);
    float *to =
        scratch_take(scratch, (size_t)rect_area(t->rect) * image->channel_count * sizeof *to);
    if (!to) return ERR_MEMORY;
    t->pixels = to;
    t->drawn = true;
    for (uint32_t c = 0; c < image->channel_count; c++)
        for (int32_t y = t->rect.y0; y < t->rect.y1; y++, to += width)
            memcpy(to, plane_at(&image->channels[c].plane, t->rect.x0, y), width * sizeof *to);
    return 0;
}

static int submit_block(struct frame *f, uint32_t view, uint32_t block);

/* Blocks that have come a pass further go to the pool. */
int frame_submit_ready(struct frame *f)
{
    uint32_t block;
    int error = 0;
    /* A frame that waited for others has all blocks at once: some at a time spare the pool. */
    for (uint32_t view = 0; view < plan_views(&f->plan); view++) {
        struct film *film = f->views[view].film;
        film_tell_time(film, frame_clock_us());
        while (!error && !(frame_has_neighbours(f) && f->blocks_out > frame_blocks_out_max(f)) &&
               film_next_ready(film, &block))
            error = submit_block(f, view, block);
    }
    return error;
}

/* Clocks are read one after the other: the parts may seem longer than the whole. */
static void count_time(struct statistics *sum, const struct block_task *t)
{
    const uint64_t all_us = t->task.cpu_us;
    const uint64_t filters_us = statistics_add_filters(sum, &t->statistics);
    sum->reconstruct_cpu_us += all_us > filters_us ? all_us - filters_us : 0;
}

/* Keeps a block's statistics as it was drawn last, and those of the lens's filter as it last ran.
 *  */
static void keep_statistics(struct block_statistics *kept, const struct block_task *t)
{
    const struct lens_statistics lens = kept->lens;
    *kept = t->statistics;
    if (t->drawn) kept->lens = lens;
}

static void block_over(struct frame *f, const struct block_task *t)
{
    f->blocks_out--;
    count_time(&f->statistics, t);
    if (t->error) {
        frame_fail(f, t->error, "", "reconstruction failed");
        return;
    }
    copy_pixels(t, f->views[t->view].image);
    frame_views_drawn(f, t->view, t->block, t->task.cpu_us);
    f->blocks_drawn++;
    if (frame_has_target(f)) frame_target_keep(f, t->rect, &t->measure);
    if (t->strata_maps) frame_adaptive_keep(f, t->block, t->strata_maps, t->measured);
    if (frame_has_rounds(f)) keep_statistics(&f->rounds.statistics[t->block], t);
    /* Pixels count once, as they are in the end. */
    const bool last = film_block_done(f->views[t->view].film, t->block);
    if (last && frame_has_target(f)) frame_target_see(f, t->rect);
    if (last && !frame_has_rounds(f)) {
        statistics_add_block(&f->statistics, &t->statistics);
        frame_files_feed(f);
    }
    const int error = frame_submit_ready(f);
    if (error) {
        frame_fail(f, error, "", "a block could not be reconstructed");
        return;
    }
    frame_spool_feed(f);
    f->tasks++; /* held: what comes next may fail, and the owner drop the frame */
    if (frame_films_complete(f)) {
        if (frame_has_rounds(f))
            frame_rounds_decide(f);
        else
            frame_denoise_end(f);
    }
    if (frame_task_over(f)) f->options.events.drawn(f->options.events.ctx, f, t->rect);
}

static void block_done(struct pool_task *task)
{
    struct block_task *t = (struct block_task *)task;
    struct frame *f = t->frame;
    f->tasks++; /* held until its scratch has the pixels back */
    if (frame_task_over(f)) block_over(f, t);
    scratch_give(f->scratch, t->pixels);
    (void)frame_task_over(f);
    free(t->strata_maps);
    free(t);
}

static int submit_block(struct frame *f, uint32_t view, uint32_t block)
{
    struct block_task *t = calloc(1, sizeof *t);
    if (!t) return ERR_MEMORY;
    t->rect = film_block_rect(f->film, block);
    t->task = (struct pool_task){.run = block_run, .done = block_done};
    t->frame = f;
    t->view = view;
    t->block = block;
    int error = 0;
    if (frame_wants_strata_maps(f)) {
        t->strata_maps =
            calloc(f->adaptive.maps * (size_t)rect_area(t->rect), sizeof *t->strata_maps);
        if (!t->strata_maps) error = ERR_MEMORY;
    } else if (f->plan.lens_extra > 0) {
        error = take_pixels(f->scratch, t, f->image);
    }
    if (error) {
        free(t);
        return error;
    }
    f->blocks_out++;
    frame_task_submit(f, &t->task);
    return 0;
}

struct decode_task {
    struct pool_task task;
    struct frame *frame;
    uint64_t worker;
    struct plan_pass pass;
    struct message_result result; /* its samples lie in bytes */
    uint8_t *bytes;               /* owned */
    struct samples *samples;      /* owned until landed */
    struct rect rect;
    int error;
    struct fault fault;
};

static void decode_run(struct pool_task *task)
{
    struct decode_task *t = (struct decode_task *)task;
    if (atomic_load(&t->frame->dropped)) return;
    t->error =
        samples_unpack(t->result.samples, t->result.samples_bytes, &t->frame->plan, t->pass.number,
                       rect_width(t->rect), rect_height(t->rect), &t->samples, &t->fault);
}

static void judge(struct decode_task *t, uint32_t verdict)
{
    struct frame *f = t->frame;
    struct message_ack ack = {.frame_id = f->options.id,
                              .index = t->result.index,
                              .generation = t->result.generation,
                              .verdict = verdict};
    f->options.events.judged(f->options.events.ctx, f, t->worker, &ack);
}

/* Exhausted memory here is not the worker's fault: it may send the tile again. */
static void reject(struct decode_task *t)
{
    struct frame *f = t->frame;
    bool corrupt = t->error != ERR_MEMORY;
    tile_queue_reject(f->tiles, t->result.index);
    if (corrupt) {
        f->statistics.results_corrupt++;
        f->refusal = t->fault;
    }
    judge(t, corrupt ? VERDICT_CORRUPT : VERDICT_STALE);
}

int frame_land(struct frame *f, uint32_t tile, const struct plan_pass *pass,
               struct samples **samples, const struct counters *counters)
{
    const struct plan_pass of_view = frame_view_pass(f, pass);
    struct film *film = f->views[pass->number % plan_views(&f->plan)].film;
    int error = film_land_pass(film, tile, &of_view, *samples);
    if (error) {
        frame_fail(f, error, "", "a tile's samples could not be kept");
        return error;
    }
    *samples = NULL;
    if (frame_spool_has_next(f, tile)) {
        tile_queue_land_and_take(f->tiles, tile);
        frame_spool_push(f, tile);
    } else {
        tile_queue_land(f->tiles, tile);
    }
    const uint32_t area = (uint32_t)rect_area(tile_grid_rect(&f->grid, tile));
    if (counters) {
        counters_add(&f->statistics.counters, counters);
        f->statistics.tiles_done++;
    }
    f->samples_landed +=
        frame_has_rounds(f) ? frame_pass_work(&f->plan, pass, area) : frame_pass_samples(pass);
    const double work = frame_has_rounds(f) ? (double)frame_pass_work(&f->plan, pass, area)
                                            : (double)frame_pass_samples(pass) * area;
    frame_costs_land(f, tile, work, counters ? counters : &(struct counters){0});
    if (frame_has_rounds(f)) frame_rounds_note(f);
    if (frame_has_target(f)) frame_glance(f, tile);
    error = frame_submit_ready(f);
    if (error) frame_fail(f, error, "", "a block could not be reconstructed");
    if (!error && frame_has_neighbours(f)) error = frame_neighbours_note(f);
    return error;
}

static void land(struct decode_task *t)
{
    struct frame *f = t->frame;
    const uint32_t tile = t->result.index;
    if (frame_land(f, tile, &t->pass, &t->samples, &t->result.counters) != 0) return;
    frame_spool_keep(f, tile, &t->pass, &t->result.counters, &t->bytes, t->result.samples_bytes);
    frame_spool_feed(f);
    /* `traced` comes after the verdict, so that the worker knows its result is in before it is told
     * to forget the frame. */
    bool complete = tile_queue_complete(f->tiles) && !frame_has_rounds(f);
    f->tasks++; /* held: the owner may drop the frame */
    judge(t, VERDICT_ACCEPTED);
    if (frame_task_over(f) && complete) f->options.events.traced(f->options.events.ctx, f);
}

static void decode_done(struct pool_task *task)
{
    struct decode_task *t = (struct decode_task *)task;
    if (frame_task_over(t->frame)) {
        t->frame->statistics.decode_cpu_us += t->task.cpu_us;
        if (t->error)
            reject(t);
        else
            land(t);
    }
    samples_destroy(&t->samples);
    free(t->bytes);
    free(t);
}

uint32_t frame_result(struct frame *f, uint64_t worker, const struct message_result *result,
                      uint8_t **bytes, uint32_t size_bytes)
{
    f->statistics.bytes_received += size_bytes;
    enum verdict verdict = tile_queue_receive(f->tiles, worker, result->index, result->generation);
    if (verdict != VERDICT_ACCEPTED) {
        f->statistics.results_dropped++;
        return verdict;
    }
    struct decode_task *t = calloc(1, sizeof *t);
    if (!t) {
        tile_queue_reject(f->tiles, result->index);
        return VERDICT_STALE;
    }
    f->arrived_us = frame_clock_us();
    t->task = (struct pool_task){.run = decode_run, .done = decode_done};
    t->frame = f;
    t->worker = worker;
    t->pass = frame_pass(f, result->index, tile_queue_pass(f->tiles, result->index));
    t->result = *result;
    t->rect = tile_grid_rect(&f->grid, result->index);
    t->bytes = *bytes;
    *bytes = NULL;
    frame_task_submit(f, &t->task);
    return 0;
}
