/* A tile's paths, block by block; those of pixels at edges sixteen pixels at a time. */
#include <string.h>

#include "worker/tile/tile_work.h"
#include "worker/trace/path/path_photograph.h"

static bool is_stopped(const _Atomic bool *stop)
{
    return stop && atomic_load_explicit(stop, memory_order_relaxed);
}

/* Returns whether the block shows nothing that paths would bring. Counts the paths that it goes
 * without. */
static bool skips_paths(const struct tile_tracer *t, const struct stages *stages)
{
    const struct block *b = &t->block;
    const int32_t x = b->x_px[0], y = b->y_px[0];
    const struct rect pixels = {x, y, x + LANES_ACROSS, y + LANES_ACROSS};
    if (!stages->skips_paths || lobe_view_meets(&t->lobes, pixels)) return false;
    stages->paths.counters->value[COUNTER_SKIPPED_NO_LOBE] +=
        (uint64_t)lanes_count(&b->kept) * stages->count;
    return true;
}

/* Adds a block's paths up, batch by batch; to zeros where `count` is 0. */
static void trace_block(struct tile_tracer *t, const struct stages *stages,
                        const struct path_context *c, const struct block *b, uint32_t count,
                        const struct samples *samples)
{
    const uint32_t first = stages->first << c->edge_digits, all = count << c->edge_digits;
    path_sums_init(&t->sums, &stages->pass, c->edge_digits, samples->layout.planes);
    for (uint32_t done = 0; done < all;) {
        const uint32_t left = all - done, n = left < PATH_SAMPLES ? left : PATH_SAMPLES;
        path_trace(c, b, first + done, n, &t->path);
        if (c->photograph)
            path_photograph_add(c, &t->sums.parts, first + done, n, &t->path.radiance);
        path_sums_add(&t->sums, &t->path.radiance, n, c->demodulate, c->counters);
        done += n;
    }
}

/* 2^LAMP_DIGITS more samples in each pass tell how much of a pixel a lamp covers: it may be many
 * times as bright as white, and nothing filters it. */
#define LAMP_DIGITS 6u

static void see_lamps(struct tile_tracer *t, const struct stages *stages)
{
    struct path_context c = stages->paths;
    struct block b = t->edges;
    struct lanes3 emission = {.x = {0}};
    float coverage[LANES] = {0};
    const struct path_radiance *h = &t->path.radiance;
    if (c.skip & SKIP_DIFFUSE || lanes_count(&t->beside_lamps) == 0) return;
    b.kept = t->beside_lamps;
    c.seen_only = true;
    c.edge_digits = LAMP_DIGITS;
    for (uint32_t done = 0; done < 1u << LAMP_DIGITS; done += PATH_SAMPLES) {
        path_trace(&c, &b, (stages->pass.number << LAMP_DIGITS) + done, PATH_SAMPLES, &t->path);
        for (size_t slot = 0; slot < PATH_SLOTS; slot++) {
            emission.x[slot % LANES] += h->emission.r[slot];
            emission.y[slot % LANES] += h->emission.g[slot];
            emission.z[slot % LANES] += h->emission.b[slot];
            coverage[slot % LANES] += h->coverage[slot];
        }
    }
    path_sums_see(&t->sums, &t->beside_lamps, &emission, coverage, 1u << LAMP_DIGITS);
}

static void trace_edges(struct tile_tracer *t, const struct stages *stages, struct samples *samples)
{
    struct path_context c = stages->paths;
    c.edge_digits = c.plan->paths.edge_digits;
    if (lanes_count(&t->edges.kept) > 0) {
        trace_block(t, stages, &c, &t->edges, stages->count, samples);
        see_lamps(t, stages);
        path_sums_store(&t->sums, &t->edges, samples);
    }
    memset(&t->edges, 0, sizeof t->edges);
    memset(&t->beside_lamps, 0, sizeof t->beside_lamps);
}

/* Takes a lane out of the block, and has it wait. */
static void put_off(struct tile_tracer *t, int i, int to)
{
    struct block *b = &t->block, *e = &t->edges;
    e->x_px[to] = b->x_px[i];
    e->y_px[to] = b->y_px[i];
    e->element[to] = b->element[i];
    e->inside.on[to] = e->kept.on[to] = -1;
    t->beside_lamps.on[to] =
        mixed_is_beside_lamp(&t->mixed.finder, b->x_px[i], b->y_px[i]) ? -1 : 0;
    b->kept.on[i] = 0;
    b->whole = false;
}

static void put_off_edges(struct tile_tracer *t, const struct stages *stages,
                          struct samples *samples)
{
    const uint8_t *edge = t->mixed.finder.edge;
    uint32_t waiting = lanes_count(&t->edges.kept);
    for (int i = 0; i < LANES; i++) {
        if (!t->block.kept.on[i] || !edge[t->block.element[i]]) continue;
        put_off(t, i, (int)waiting++);
        if (waiting < LANES) continue;
        trace_edges(t, stages, samples);
        waiting = 0;
    }
}

int tile_trace_paths(struct tile_tracer *t, const struct stages *stages, const struct tile_job *job,
                     struct samples *samples)
{
    const struct plan *plan = job->plan;
    const struct rect r = job->rect;
    const bool edges = plan->paths.edge_digits > 0;
    int error = 0;
    if (edges && stages->pass.number > 0)
        error = edge_pixels_find(&stages->paths, r, &t->lone.finder, &t->mixed.finder);
    if (error) return error;
    memset(&t->edges, 0, sizeof t->edges);
    memset(&t->beside_lamps, 0, sizeof t->beside_lamps);
    for (int32_t y = r.y0 & -LANES_ACROSS; y < r.y1; y += LANES_ACROSS) {
        for (int32_t x = r.x0 & -LANES_ACROSS; x < r.x1; x += LANES_ACROSS) {
            if (!tile_shows(t, x, y)) continue;
            block_init(&t->block, x, y, plan->width_px, plan->height_px, r);
            const bool none = skips_paths(t, stages);
            if (edges && !none) put_off_edges(t, stages, samples);
            if (lanes_count(&t->block.kept) > 0) {
                trace_block(t, stages, &stages->paths, &t->block, none ? 0 : stages->count,
                            samples);
                path_sums_store(&t->sums, &t->block, samples);
            }
            if (is_stopped(job->stop)) return ERR_STATE;
        }
        if (tile_is_of_paths(stages)) tile_count_rows(job, y);
    }
    trace_edges(t, stages, samples);
    return 0;
}
