/* The views of a frame (enum plan_view): each has a film and a picture of its own. An ordinary
 * frame has one. The others' pictures are composed with the first, which is the frame's. */
#include <stdlib.h>

#include "server/job/frame/frame_work.h"
#include "server/reconstruct/compose/catcher.h"

/* A block is not drawn again sooner, but for its last time, nor while the pool could draw all
 * blocks as often: so what forms is seen soon, and takes a tenth of the pool's time at most. */
#define REST_US    1000000
#define REST_TIMES 10

static uint64_t rest_us(const struct frame *f, uint64_t cpu_us)
{
    const uint64_t blocks = (uint64_t)film_block_count(f->film) * plan_views(&f->plan);
    const uint64_t us = REST_TIMES * cpu_us * blocks / thread_pool_threads(f->options.pool);
    return us > REST_US ? us : REST_US;
}

/* Of a frame that nobody watches, no block is drawn before its last time. */
static void rest_all(struct film *film)
{
    for (uint32_t i = 0; i < film_block_count(film); i++) film_rest(film, i, UINT64_MAX);
}

int frame_views_create(struct frame *f)
{
    const int32_t width = f->plan.width_px, height = f->plan.height_px;
    f->view_plan = plan_of_view(&f->plan);
    int error = 0;
    for (uint32_t k = 0; k < plan_views(&f->plan) && !error; k++) {
        struct frame_view *view = &f->views[k];
        const uint32_t layers = k == 0 ? f->options.layers : LAYER_BEAUTY;
        error = film_create(&f->view_plan, f->block_px, block_core_px(&f->view_plan),
                            block_halo_px(&f->view_plan), &view->film);
        if (!error) film_gather_in(view->film, f->scratch);
        if (!error && f->options.unwatched) rest_all(view->film);
        if (!error) error = image_create(layers, width, height, &view->image);
    }
    f->film = f->views[0].film;
    f->image = f->views[0].image;
    if (error || !f->plan.composite) return error;
    f->block_views = calloc(film_block_count(f->film), sizeof *f->block_views);
    if (!f->block_views) return ERR_MEMORY;
    frame_views_compose(f, (struct rect){0, 0, width, height});
    return 0;
}

void frame_views_destroy(struct frame *f)
{
    for (uint32_t k = 0; k < PLAN_VIEWS; k++) {
        film_destroy(&f->views[k].film);
        image_destroy(&f->views[k].image);
    }
    free(f->block_views);
}

struct plan_pass frame_view_pass(const struct frame *f, const struct plan_pass *pass)
{
    struct plan_pass of_view = *pass;
    of_view.number /= plan_views(&f->plan);
    return of_view;
}

uint64_t frame_pending(const struct frame *f)
{
    uint64_t pending = 0;
    for (uint32_t k = 0; k < plan_views(&f->plan); k++) pending += film_pending(f->views[k].film);
    return pending;
}

int32_t frame_rows_done(const struct frame *f)
{
    int32_t rows = f->plan.height_px;
    for (uint32_t k = 0; k < plan_views(&f->plan); k++) {
        const int32_t own = film_rows_done(f->views[k].film);
        rows = own < rows ? own : rows;
    }
    return rows;
}

bool frame_films_complete(const struct frame *f)
{
    for (uint32_t k = 0; k < plan_views(&f->plan); k++)
        if (!film_complete(f->views[k].film)) return false;
    return true;
}

/* Other layers may tell of pixels without surfaces, too. */
bool frame_view_is_of_surfaces(const struct frame *f, uint32_t view)
{
    const uint32_t known = LAYER_BEAUTY | LAYERS_COMPOSITE;
    return f->plan.composite && (view != PLAN_VIEW_OBJECTS || !(f->options.layers & ~known));
}

void frame_views_compose(struct frame *f, struct rect rect)
{
    const struct catcher_views views = {.with = f->views[PLAN_VIEW_WITH].image,
                                        .without = f->views[PLAN_VIEW_WITHOUT].image,
                                        .plate =
                                            f->options.plate ? plate_image(f->options.plate) : NULL,
                                        .adds = f->options.adds};
    catcher_compose(&views, rect, f->image);
}

/* Until a block has both, one of them alone would tell of no change. */
void frame_views_drawn(struct frame *f, uint32_t view, uint32_t block, uint64_t cpu_us)
{
    static const uint8_t both = 1u << PLAN_VIEW_WITH | 1u << PLAN_VIEW_WITHOUT;
    const struct rect rect = film_block_rect(f->film, block);
    if (!f->options.unwatched)
        film_rest(f->views[view].film, block, frame_clock_us() + rest_us(f, cpu_us));
    if (!f->plan.composite) return;
    f->block_views[block] |= (uint8_t)(1u << view);
    if (view == PLAN_VIEW_OBJECTS || (f->block_views[block] & both) == both)
        frame_views_compose(f, rect);
}
