/* Frames that are drawn with samples of the frames beside them: traced once, condensed for their
 * neighbours, and drawn when these are traced, too. So a picture depends on samples alone, and not
 * on which frame came first. */
#include <assert.h>
#include <stdlib.h>

#include "server/job/frame/frame_work.h"

void frame_neighbours_begin(struct frame *f)
{
    for (uint32_t k = 0; k < plan_views(&f->plan); k++) film_hold(f->views[k].film, true);
}

void frame_neighbours_destroy(struct frame *f)
{
    struct frame_neighbours *n = &f->neighbours;
    for (int side = 0; side < MOTION_SIDES; side++)
        for (uint32_t k = 0; k < n->held.count[side]; k++)
            residual_history_drop(&n->held.frames[side][k]);
    residual_history_drop(&n->history);
}

struct residual_history *frame_history(const struct frame *f)
{
    return f->neighbours.state >= FRAME_WAITS ? f->neighbours.history : NULL;
}

bool frame_is_waiting(const struct frame *f)
{
    return f->neighbours.state == FRAME_CONDENSES || f->neighbours.state == FRAME_WAITS;
}

bool frame_has_window(const struct frame *f)
{
    return !frame_has_neighbours(f) || f->neighbours.state == FRAME_DRAWS;
}

/* -- condensing -- */

struct condense_task {
    struct pool_task task;
    struct frame *frame;
    uint32_t view;
    struct rect rect;
    int error;
};

static void condense_run(struct pool_task *task)
{
    struct condense_task *t = (struct condense_task *)task;
    struct patch *patch = NULL;
    if (atomic_load(&t->frame->dropped)) return;
    t->error = film_gather_rect(t->frame->views[t->view].film, t->rect, &patch);
    if (!t->error) t->error = residual_history_take(t->frame->neighbours.history, t->view, patch);
    patch_destroy(&patch);
}

static void condensed(struct frame *f)
{
    f->neighbours.state = FRAME_WAITS;
    if (f->neighbours.error)
        frame_fail(f, f->neighbours.error, "", "its samples could not be kept for other frames");
    else
        f->options.events.waits(f->options.events.ctx, f);
}

static void condense_done(struct pool_task *task)
{
    struct condense_task *t = (struct condense_task *)task;
    struct frame *f = t->frame;
    if (frame_task_over(f)) {
        struct frame_neighbours *n = &f->neighbours;
        f->statistics.residual_cpu_us += t->task.cpu_us;
        if (t->error) n->error = t->error;
        if (--n->condensing == 0) condensed(f);
    }
    free(t);
}

static int condense(struct frame *f, uint32_t view, uint32_t block)
{
    struct condense_task *t = calloc(1, sizeof *t);
    if (!t) return ERR_MEMORY;
    *t = (struct condense_task){.task = {.run = condense_run, .done = condense_done},
                                .frame = f,
                                .view = view,
                                .rect = film_block_rect(f->film, block)};
    f->neighbours.condensing++;
    frame_task_submit(f, &t->task);
    return 0;
}

int frame_neighbours_note(struct frame *f)
{
    struct frame_neighbours *n = &f->neighbours;
    if (!tile_queue_complete(f->tiles) || n->state != FRAME_TRACES) return 0;
    int error = residual_history_create(&f->plan, f->motion, &n->history);
    n->state = FRAME_CONDENSES;
    for (uint32_t k = 0; k < plan_views(&f->plan); k++)
        for (uint32_t i = 0; i < film_block_count(f->film) && !error; i++)
            error = condense(f, k, i);
    if (error) frame_fail(f, error, "", "its samples could not be kept for other frames");
    return error;
}

/* -- drawing -- */

void frame_draw(struct frame *f, const struct frame_window *window)
{
    struct frame_neighbours *n = &f->neighbours;
    assert(n->state == FRAME_WAITS);
    n->state = FRAME_DRAWS;
    struct residual_window read = {.plan = &f->plan, .motion = f->motion};
    for (int side = 0; side < MOTION_SIDES; side++) {
        n->held.count[side] = read.count[side] = window->count[side];
        for (uint32_t k = 0; k < window->count[side]; k++)
            read.frames[side][k] = n->held.frames[side][k] =
                residual_history_hold(window->frames[side][k]);
    }
    for (uint32_t k = 0; k < plan_views(&f->plan); k++) {
        n->windows[k] = read;
        n->windows[k].view = k;
        film_hold(f->views[k].film, false);
    }
    const int error = frame_submit_ready(f);
    if (error) frame_fail(f, error, "", "a block could not be reconstructed");
}
