#include "worker/scene/openness.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/scene/glazing.h"
#include "worker/scene/render_scene.h"
#include "worker/shade/elementary.h"

/* The rays of a bin. Sixteen neighbouring bins share the place that these start from. */
#define RAYS 3u

/* Surfaces nearer to a place than this part of a cell's side do not count as in the way. */
#define NEAR_SHARE 1e-3f

/* A cell that sees more of the sky than this counts as open: chance finds the sky often enough. */
#define OPEN_SHARE 0.3f

/* Cells that see less of the sky through glass than this part of it see none so. */
#define GLAZED_MIN 0.2f

/* What is learned of one kind of way to the sky. */
struct part {
    uint32_t cells;   /* that count */
    float *bins;      /* OPENNESS_BINS a cell of the grid, then of those that count */
    uint16_t *number; /* one a cell of the grid */
};

struct openness {
    const struct render_scene *scene;
    struct openness_grid grid;
    struct part open, through; /* without glass, and through it alone */
    float *glazed;             /* one a cell of the grid */
    pthread_mutex_t lock;
    pthread_cond_t learned;
    _Atomic uint32_t next;
    uint32_t done;
};

static bool part_create(struct part *p, uint32_t cells)
{
    p->bins = malloc((size_t)cells * OPENNESS_BINS * sizeof *p->bins);
    p->number = calloc(cells, sizeof *p->number);
    return p->bins && p->number;
}

static void part_destroy(struct part *p)
{
    free(p->bins);
    free(p->number);
}

struct openness *openness_create(const struct render_scene *scene)
{
    struct openness *o = calloc(1, sizeof *o);
    if (!o) return NULL;
    pthread_mutex_init(&o->lock, NULL);
    pthread_cond_init(&o->learned, NULL);
    o->scene = scene;
    openness_grid_init(&o->grid, scene);
    o->glazed = calloc(o->grid.cells, sizeof *o->glazed);
    if (!part_create(&o->open, o->grid.cells) || !part_create(&o->through, o->grid.cells) ||
        !o->glazed)
        openness_destroy(&o);
    return o;
}

void openness_destroy(struct openness **openness)
{
    struct openness *o = *openness;
    *openness = NULL;
    if (!o) return;
    pthread_cond_destroy(&o->learned);
    pthread_mutex_destroy(&o->lock);
    part_destroy(&o->open);
    part_destroy(&o->through);
    free(o->glazed);
    free(o);
}

/* ---- rays ---- */

struct probe {
    const struct openness *openness;
    uint32_t cell, random;
    float place[3], near;  /* rays begin so far from it: a flat scene lies where its cells do */
    uint32_t seen, glazed; /* rays that reached the sky; of them, through glass */
};

/* Chooses a random place in the cell. */
static void go(struct probe *p)
{
    const struct openness_grid *g = &p->openness->grid;
    const struct openness_box *b = p->cell < g->dense.first ? &g->whole : &g->dense;
    const uint32_t cell = p->cell - b->first;
    const uint32_t at[3] = {cell % b->size[0], cell / b->size[0] % b->size[1],
                            cell / b->size[0] / b->size[1]};
    float shortest = INFINITY;
    for (int k = 0; k < 3; k++) {
        const float side = b->per_cell[k] > 0.0f ? 1.0f / b->per_cell[k] : 0.0f;
        p->place[k] = b->low[k] + ((float)at[k] + path_next(&p->random)) * side;
        shortest = side > 0.0f ? fminf(shortest, side) : shortest;
    }
    p->near = isfinite(shortest) ? NEAR_SHARE * shortest : 0.0f;
}

/* What is in the way. */
enum way { WAY_BLOCKED, WAY_OPEN, WAY_GLAZED };

/* Finds out in a random direction of a bin. */
static enum way look_along(struct probe *p, uint32_t u, uint32_t v)
{
    const float around = ((float)u + path_next(&p->random)) / (float)OPENNESS_U;
    const float down = ((float)v + path_next(&p->random)) / (float)OPENNESS_V;
    float around_sine, around_cosine, down_sine, down_cosine;
    elementary_sincos_turn(around, &around_sine, &around_cosine);
    elementary_sincos_turn(0.5f * down, &down_sine, &down_cosine);
    bool through;
    struct RTCRay ray = {.org_x = p->place[0],
                         .org_y = p->place[1],
                         .org_z = p->place[2],
                         .dir_x = -down_sine * around_cosine,
                         .dir_y = down_cosine,
                         .dir_z = -down_sine * around_sine,
                         .tnear = p->near,
                         .tfar = INFINITY,
                         .mask = UINT32_MAX};
    if (!glazing_sees(p->openness->scene, &ray, &through)) return WAY_BLOCKED;
    p->seen++;
    p->glazed += through;
    return through ? WAY_GLAZED : WAY_OPEN;
}

/* Traces some rays over the whole sphere from four places, to see if a closer look is needed. */
static bool is_open(struct probe *p)
{
    uint32_t open = 0;
    for (uint32_t k = 0; k < 4; k++) {
        go(p);
        for (uint32_t i = 0; i < 16; i++)
            open +=
                look_along(p, (i * 2 + k) * 5 % OPENNESS_U, (i + 4 * k) % OPENNESS_V) == WAY_OPEN;
    }
    return (float)open > OPEN_SHARE * 4 * 16;
}

/* Traces rays from one place into 4 x 4 bins. */
static void look(struct probe *p, uint32_t u, uint32_t v, float *open, float *through)
{
    go(p);
    for (uint32_t i = 0; i < 16; i++) {
        const uint32_t bin = (v + i / 4) * OPENNESS_U + u + i % 4;
        const enum way way = look_along(p, u + i % 4, v + i / 4);
        open[bin] += way == WAY_OPEN ? 1.0f : 0.0f;
        through[bin] += way == WAY_GLAZED ? 1.0f : 0.0f;
    }
}

/* Smooths the bins with weights 1 2 1 both ways, since neighbours see much the same. */
static void blur(const float *counts, float *open)
{
    static const float weight[3] = {0.25f, 0.5f, 0.25f};
    for (uint32_t v = 0; v < OPENNESS_V; v++)
        for (uint32_t u = 0; u < OPENNESS_U; u++) {
            float sum = 0.0f;
            for (uint32_t j = 0; j < 3; j++)
                for (uint32_t i = 0; i < 3; i++) {
                    const uint32_t x = (u + OPENNESS_U + i - 1) % OPENNESS_U;
                    const uint32_t y = v + j < 1 ? 0 : v + j > OPENNESS_V ? v : v + j - 1;
                    sum += weight[i] * weight[j] * counts[y * OPENNESS_U + x];
                }
            open[v * OPENNESS_U + u] = sum / (float)RAYS;
        }
}

static void learn_cell(struct openness *o, uint32_t cell)
{
    float open[OPENNESS_BINS] = {0}, through[OPENNESS_BINS] = {0};
    struct probe p = {.openness = o, .cell = cell, .random = path_mix(cell + 1)};
    o->open.number[cell] = is_open(&p) ? 0 : 1;
    if (o->open.number[cell] == 0 && p.glazed == 0) return;
    for (uint32_t k = 0; k < RAYS; k++)
        for (uint32_t v = 0; v < OPENNESS_V; v += 4)
            for (uint32_t u = 0; u < OPENNESS_U; u += 4) look(&p, u, v, open, through);
    const float share = p.seen > 0 ? (float)p.glazed / (float)p.seen : 0.0f;
    o->glazed[cell] = share < GLAZED_MIN ? 0.0f : share;
    o->through.number[cell] = o->glazed[cell] > 0.0f ? 1 : 0;
    if (o->open.number[cell]) blur(open, o->open.bins + (size_t)cell * OPENNESS_BINS);
    if (o->through.number[cell]) blur(through, o->through.bins + (size_t)cell * OPENNESS_BINS);
}

/* Numbers the cells that count and packs their bins. */
static void number_cells(struct part *p, uint32_t cells)
{
    for (uint32_t k = 0; k < cells; k++) {
        if (p->number[k] == 0) continue;
        memmove(p->bins + (size_t)p->cells * OPENNESS_BINS, p->bins + (size_t)k * OPENNESS_BINS,
                OPENNESS_BINS * sizeof *p->bins);
        p->number[k] = (uint16_t)++p->cells;
    }
}

void openness_learn(struct openness *o)
{
    uint32_t mine = 0, cell = 0;
    while ((cell = atomic_fetch_add_explicit(&o->next, 1, memory_order_relaxed)) < o->grid.cells) {
        learn_cell(o, cell);
        mine++;
    }
    atomic_store_explicit(&o->next, o->grid.cells, memory_order_relaxed);
    pthread_mutex_lock(&o->lock);
    o->done += mine;
    if (mine > 0 && o->done == o->grid.cells) {
        number_cells(&o->open, o->grid.cells);
        number_cells(&o->through, o->grid.cells);
        pthread_cond_broadcast(&o->learned);
    }
    while (o->done < o->grid.cells) pthread_cond_wait(&o->learned, &o->lock);
    pthread_mutex_unlock(&o->lock);
}

uint32_t openness_cells(const struct openness *o)
{
    return o->open.cells;
}

const float *openness_of(const struct openness *o, uint32_t cell)
{
    return o->open.bins + (size_t)cell * OPENNESS_BINS;
}

const struct openness_grid *openness_grid(const struct openness *o)
{
    return &o->grid;
}

const uint16_t *openness_numbers(const struct openness *o)
{
    return o->open.number;
}

const float *openness_glazed(const struct openness *o)
{
    return o->glazed;
}

uint32_t openness_panes(const struct openness *o)
{
    return o->through.cells;
}

const float *openness_through(const struct openness *o, uint32_t pane)
{
    return o->through.bins + (size_t)pane * OPENNESS_BINS;
}

const uint16_t *openness_pane_numbers(const struct openness *o)
{
    return o->through.number;
}
