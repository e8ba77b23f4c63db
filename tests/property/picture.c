#include "tests/property/picture.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/film/film.h"
#include "server/job/plan.h"
#include "server/reconstruct/block.h"
#include "tests/property/stage.h"
#include "worker/tile.h"

static int last_integrator;

int picture_integrator(void)
{
    return last_integrator;
}

static void die(const char *what, int error)
{
    fprintf(stderr, "picture: %s (%d)\n", what, error);
    abort();
}

static void trace(const struct plan *plan, const struct scene *scene, struct film *film)
{
    struct fault fault = {0};
    struct render_scene *render;
    struct tile_tracer *tracer;
    struct tile_grid grid;
    struct counters counters = {0};
    int error = render_scene_create(scene, 1, &render, &fault);
    if (error) die(fault.detail, error);
    if (tile_tracer_create(&tracer)) die("no memory for a tracer", ERR_MEMORY);
    error = tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px);
    if (error) die("the grid of tiles", error);
    for (uint32_t pass = 0; pass < plan_pass_count(plan); pass++)
        for (uint32_t t = 0; t < (uint32_t)(grid.columns * grid.rows); t++) {
            struct samples *samples;
            error = tile_trace(tracer, render, NULL, plan, pass, tile_grid_rect(&grid, t), NULL,
                               NULL, &samples, &counters);
            if (error) die("a tile cannot be traced", error);
            error = film_land(film, t, pass, samples); /* which takes them */
            if (error) die("a tile cannot land", error);
        }
    tile_tracer_destroy(&tracer);
    render_scene_destroy(&render);
}

static void reconstruct(const struct plan *plan, struct film *film, struct image *image)
{
    uint32_t block;
    while (film_next_ready(film, &block)) {
        struct block_statistics statistics = {0};
        struct patch *patch;
        int error = film_gather(film, block, &patch);
        if (error) die("a block cannot be gathered", error);
        error = block_reconstruct(plan, patch, film_block_rect(film, block), image, &statistics);
        if (error) die("a block cannot be reconstructed", error);
        patch_destroy(&patch);
        film_block_done(film, block);
    }
    if (!film_complete(film)) die("the film is not complete", 0);
}

struct image *picture_render(const struct property_case *c, const struct change *change,
                             char *refused, size_t refused_bytes)
{
    static struct plan plan;
    static struct plan_report report;
    struct fault fault = {0};
    struct job job;
    struct film *film;
    struct image *image = NULL;
    struct stage stage;
    char *text = stage_job(c, change);
    stage_build(c, change, &stage);
    int error = job_read(text, strlen(text), &job, &fault);
    free(text);
    const struct plan_source source = {.scene = stage.scene};
    if (!error) {
        error = plan_make(&job, &source, 0, &plan, &report, &fault);
        job_fini(&job);
    }
    if (error) {
        snprintf(refused, refused_bytes, "%s: %s", fault.pointer, fault.detail);
        stage_free(&stage);
        return NULL;
    }
    last_integrator = (int)report.integrator;
    error = film_create(&plan, c->block, block_halo_px(&plan), &film);
    if (!error) error = image_create(report.layers, plan.width_px, plan.height_px, &image);
    if (error) die("no film", error);
    trace(&plan, stage.scene, film);
    reconstruct(&plan, film, image);
    film_destroy(&film);
    stage_free(&stage);
    return image;
}
