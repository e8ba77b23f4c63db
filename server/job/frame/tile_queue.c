#include "server/job/frame/tile_queue.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/error.h"
#include "server/job/frame/tile_deaths.h"
#include "server/job/frame/tile_heap.h"
#include "server/job/frame/tile_leases.h"

enum tile_state { TILE_WAITING, TILE_LEASED, TILE_RECEIVED, TILE_LANDED };

struct tile_entry {
    struct tile_leases leases;
    uint64_t faulted_by[TILE_QUEUE_FAULTS];
    uint32_t generation; /* of the last lease; 0: never leased */
    uint32_t settled;    /* the generation under which the last pass landed; 0: none has */
    uint32_t rank;       /* place in the order of rows */
    uint16_t passes;     /* that it has in all */
    uint16_t pass;       /* that it is waiting for or at */
    uint16_t returns;    /* of this pass, as all below */
    uint8_t faults;
    uint8_t state;
};

struct tile_queue {
    uint32_t count, window;
    uint32_t passes, landed; /* of all tiles */
    uint64_t reissued, copied;
    struct tile_grid grid;
    int32_t cell_px;
    struct tile_priority priority;
    bool has_priority, is_stale; /* keys are of the priority before */
    uint32_t between;            /* tiles of which some passes have landed, but not the last */
    /* Tiles that wait for a pass not leased before: the first one, and others. Owned. */
    struct tile_heap untouched, begun;
    uint32_t returned_count; /* tiles that came back and wait: a stack */
    uint32_t *returned;
    struct tile_entry *tiles;
    struct tile_deaths deaths; /* at the passes that tiles are at */
};

/* The window, the pass, the rank. */
#define RANK_BITS 32
#define PASS_BITS 11
_Static_assert(LIMIT_PASSES < 1 << PASS_BITS, "passes fit a key");

static struct tile_key key_of(const struct tile_queue *q, uint32_t tile)
{
    const struct tile_entry *t = &q->tiles[tile];
    const uint64_t window = t->rank / q->window;
    return (struct tile_key){
        .lead = q->has_priority ? tile_order_lead(&q->priority, &q->grid, q->cell_px, tile) : 0,
        .place = window << (RANK_BITS + PASS_BITS) | (uint64_t)t->pass << RANK_BITS | t->rank,
        .tile = tile};
}

static void wait_fresh(struct tile_queue *q, uint32_t tile)
{
    tile_heap_push(q->tiles[tile].pass > 0 ? &q->begun : &q->untouched, key_of(q, tile));
}

/* Sorts at the next lease: priorities may change faster than tiles are leased. */
static void follow_priority(struct tile_queue *q)
{
    struct tile_heap *const heaps[] = {&q->untouched, &q->begun};
    q->is_stale = false;
    for (unsigned h = 0; h < 2; h++) {
        for (uint32_t i = 0; i < heaps[h]->count; i++)
            heaps[h]->keys[i] = key_of(q, heaps[h]->keys[i].tile);
        tile_heap_restore(heaps[h]);
    }
}

/* Takes the first of those that wait for a pass not leased before. A priority that moves must not
 * begin tile after tile and end none: beyond some windows' worth of tiles between passes, these go
 * first. */
static uint32_t pop_fresh(struct tile_queue *q)
{
    if (q->is_stale) follow_priority(q);
    if (q->begun.count == 0) return tile_heap_pop(&q->untouched);
    if (q->untouched.count == 0) return tile_heap_pop(&q->begun);
    const bool many = q->has_priority && q->between / TILE_QUEUE_WINDOWS >= q->window;
    const bool begun = many || tile_key_before(&q->begun.keys[0], &q->untouched.keys[0]);
    return tile_heap_pop(begun ? &q->begun : &q->untouched);
}

int tile_queue_create(const struct tile_grid *grid, int32_t cell_px, uint32_t passes,
                      uint32_t window, struct tile_queue **out)
{
    assert(cell_px > 0 && window > 0 && passes > 0 && passes <= LIMIT_PASSES);
    struct tile_queue *q = calloc(1, sizeof *q);
    if (!q) return ERR_MEMORY;
    q->count = tile_grid_count(grid);
    q->passes = q->count * passes;
    q->window = window;
    q->grid = *grid;
    q->cell_px = cell_px;
    q->untouched.keys = calloc(q->count, sizeof *q->untouched.keys);
    q->begun.keys = calloc(q->count, sizeof *q->begun.keys);
    q->returned = calloc(q->count, sizeof *q->returned);
    q->tiles = calloc(q->count, sizeof *q->tiles);
    /* The stack of those that came back is empty still: room for the order. */
    if (!q->untouched.keys || !q->begun.keys || !q->returned || !q->tiles ||
        tile_order_by_rows(grid, cell_px, q->returned) != 0) {
        tile_queue_destroy(&q);
        return ERR_MEMORY;
    }
    for (uint32_t i = 0; i < q->count; i++) {
        q->tiles[q->returned[i]].passes = (uint16_t)passes;
        q->tiles[q->returned[i]].rank = i;
        wait_fresh(q, q->returned[i]);
    }
    *out = q;
    return 0;
}

void tile_queue_destroy(struct tile_queue **queue)
{
    struct tile_queue *q = *queue;
    if (!q) return;
    free(q->untouched.keys);
    free(q->begun.keys);
    free(q->returned);
    free(q->tiles);
    tile_deaths_fini(&q->deaths);
    free(q);
    *queue = NULL;
}

static uint32_t add_lease(struct tile_entry *t, uint64_t worker, bool alone)
{
    const struct tile_lease lease = {
        .worker = worker, .generation = ++t->generation, .alone = alone};
    tile_leases_add(&t->leases, &lease);
    return lease.generation;
}

void tile_queue_steer(struct tile_queue *q, const struct tile_priority *priority)
{
    q->priority = *priority;
    q->has_priority = priority->has_near || !rect_is_empty(priority->region);
    q->is_stale = true;
}

bool tile_queue_lease(struct tile_queue *q, uint64_t worker, uint32_t *tile, uint32_t *generation)
{
    if (tile_queue_waiting(q) == 0) return false;
    if (q->returned_count > 0) {
        *tile = q->returned[--q->returned_count];
        q->reissued++;
    } else {
        *tile = pop_fresh(q);
    }
    struct tile_entry *t = &q->tiles[*tile];
    assert(t->state == TILE_WAITING);
    t->state = TILE_LEASED;
    *generation = add_lease(t, worker, tile_queue_is_suspect(q, *tile));
    return true;
}

bool tile_queue_is_suspect(const struct tile_queue *q, uint32_t tile)
{
    assert(tile < q->count);
    return tile_deaths_of(&q->deaths, tile) > 0;
}

bool tile_queue_gives_suspect(const struct tile_queue *q)
{
    return q->returned_count > 0 && tile_queue_is_suspect(q, q->returned[q->returned_count - 1]);
}

void tile_queue_survived(struct tile_queue *q, uint64_t worker)
{
    tile_deaths_survived(&q->deaths, worker);
}

bool tile_queue_copy(struct tile_queue *q, uint64_t worker, uint32_t tile, uint32_t of_generation,
                     uint32_t *generation)
{
    struct tile_entry *t = tile < q->count ? &q->tiles[tile] : NULL;
    if (!t || t->state != TILE_LEASED || t->leases.at[1].generation != 0) return false;
    if (tile_queue_is_suspect(q, tile)) return false;
    if (t->leases.at[0].generation != of_generation || t->leases.at[0].worker == worker)
        return false;
    *generation = add_lease(t, worker, false);
    q->copied++;
    return true;
}

/* Ends a lease. Returns its tile if this very lease was in force. */
static struct tile_entry *end_lease(struct tile_queue *q, uint64_t worker, uint32_t tile,
                                    uint32_t generation)
{
    struct tile_entry *t = tile < q->count && generation > 0 ? &q->tiles[tile] : NULL;
    return t && tile_leases_end(&t->leases, worker, generation) ? t : NULL;
}

/* Takes a tile that came back out of those that wait. */
static void take_out(struct tile_queue *q, uint32_t tile)
{
    uint32_t at = 0;
    while (q->returned[at] != tile) at++;
    q->returned_count--;
    memmove(&q->returned[at], &q->returned[at + 1],
            (q->returned_count - at) * sizeof q->returned[0]);
}

enum verdict tile_queue_receive(struct tile_queue *q, uint64_t worker, uint32_t tile,
                                uint32_t generation)
{
    assert(q->tiles);
    struct tile_entry *t = end_lease(q, worker, tile, generation);
    if (t && t->state == TILE_LEASED) {
        t->state = TILE_RECEIVED;
        return VERDICT_ACCEPTED;
    }
    if (t) return VERDICT_DUPLICATE; /* the other one's was first */
    if (tile >= q->count || generation == 0 || generation > q->tiles[tile].generation)
        return VERDICT_FOREIGN;
    t = &q->tiles[tile];
    if (t->state == TILE_LANDED || t->state == TILE_RECEIVED || generation <= t->settled)
        return VERDICT_DUPLICATE;
    if (tile_leases_find(&t->leases, generation)) return VERDICT_FOREIGN;
    if (t->generation != generation || t->state != TILE_WAITING) return VERDICT_STALE;
    take_out(q, tile); /* it came back, and was not leased since */
    t->state = TILE_RECEIVED;
    return VERDICT_ACCEPTED;
}

/* Ends a pass that has landed. The caller sets the tile's new state. */
static struct tile_entry *end_pass(struct tile_queue *q, uint32_t tile)
{
    struct tile_entry *t = &q->tiles[tile];
    assert(tile < q->count && t->state == TILE_RECEIVED);
    t->settled = t->generation;
    memset(&t->leases, 0, sizeof t->leases);
    t->returns = 0;
    t->faults = 0;
    tile_deaths_clear(&q->deaths, tile);
    q->between += t->pass == 0;
    t->pass++;
    q->between -= t->pass == t->passes;
    q->landed++;
    return t;
}

void tile_queue_land(struct tile_queue *q, uint32_t tile)
{
    struct tile_entry *t = end_pass(q, tile);
    t->state = t->pass < t->passes ? TILE_WAITING : TILE_LANDED;
    if (t->state == TILE_WAITING) wait_fresh(q, tile);
}

uint32_t tile_queue_take(struct tile_queue *q, bool (*is_wanted)(void *ctx, uint32_t tile),
                         void *ctx, uint32_t *out)
{
    uint32_t taken = 0, kept = 0;
    assert(q->returned_count == 0); /* what is kept stands there meanwhile */
    while (q->untouched.count + q->begun.count > 0) {
        const uint32_t tile = pop_fresh(q);
        if (is_wanted(ctx, tile)) {
            q->tiles[tile].state = TILE_RECEIVED;
            out[taken++] = tile;
        } else {
            q->returned[kept++] = tile;
        }
    }
    for (uint32_t i = 0; i < kept; i++) wait_fresh(q, q->returned[i]);
    return taken;
}

void tile_queue_land_and_take(struct tile_queue *q, uint32_t tile)
{
    const struct tile_entry *t = end_pass(q, tile);
    assert(t->pass < t->passes);
}

void tile_queue_give_up(struct tile_queue *q, uint32_t tile)
{
    struct tile_entry *t = &q->tiles[tile];
    assert(tile < q->count && t->state == TILE_RECEIVED && t->leases.at[0].generation == 0);
    t->state = TILE_WAITING;
    wait_fresh(q, tile);
}

uint32_t tile_queue_passes(const struct tile_queue *q, uint32_t tile)
{
    assert(tile < q->count);
    return q->tiles[tile].passes;
}

void tile_queue_reorder(struct tile_queue *q, const uint32_t *order)
{
    assert(tile_queue_complete(q));
    for (uint32_t i = 0; i < q->count; i++) q->tiles[order[i]].rank = i;
    q->window = 1;
}

void tile_queue_extend(struct tile_queue *q, uint32_t tile, uint32_t passes)
{
    struct tile_entry *t = &q->tiles[tile];
    assert(tile < q->count && t->state == TILE_LANDED && t->passes + passes <= LIMIT_PASSES);
    if (passes == 0) return;
    t->passes = (uint16_t)(t->passes + passes);
    q->passes += passes;
    q->between++;
    t->state = TILE_WAITING;
    wait_fresh(q, tile);
}

uint32_t tile_queue_pass(const struct tile_queue *q, uint32_t tile)
{
    assert(tile < q->count);
    return q->tiles[tile].pass;
}

/* Lets a tile wait again after a lease ended without a result, unless it has another lease or its
 * result is being decoded. */
static void put_back(struct tile_queue *q, struct tile_entry *t)
{
    if (t->state == TILE_RECEIVED || t->leases.at[0].generation != 0) return;
    t->state = TILE_WAITING;
    q->returned[q->returned_count++] = (uint32_t)(t - q->tiles);
}

void tile_queue_reject(struct tile_queue *q, uint32_t tile)
{
    assert(tile < q->count && q->tiles[tile].state == TILE_RECEIVED);
    q->tiles[tile].state = TILE_LEASED;
    put_back(q, &q->tiles[tile]);
}

static bool is_alone(const struct tile_queue *q, uint32_t tile, uint32_t generation)
{
    const struct tile_lease *lease =
        tile < q->count ? tile_leases_find(&q->tiles[tile].leases, generation) : NULL;
    return lease && lease->alone;
}

enum tile_return tile_queue_return(struct tile_queue *q, uint64_t worker, uint32_t tile,
                                   uint32_t generation, enum tile_cause cause)
{
    const bool alone = is_alone(q, tile, generation);
    struct tile_entry *t = end_lease(q, worker, tile, generation);
    if (!t) return TILE_GOES_ON;
    put_back(q, t);
    if (cause == TILE_INNOCENT) return TILE_GOES_ON;
    /* The first makes it a suspect; from then on those count that held nothing else. */
    if (cause == TILE_DIED && (alone || !tile_queue_is_suspect(q, tile)))
        tile_deaths_add(&q->deaths, tile, worker);
    const uint32_t deaths = tile_deaths_of(&q->deaths, tile);
    if (deaths >= TILE_QUEUE_DEATHS && deaths > tile_deaths_elsewhere(&q->deaths, tile))
        return TILE_IS_DEADLY;
    return ++t->returns < TILE_QUEUE_RETURNS ? TILE_GOES_ON : TILE_CAME_BACK_OFTEN;
}

bool tile_queue_fault(struct tile_queue *q, uint64_t worker, uint32_t tile, uint32_t generation)
{
    struct tile_entry *t = end_lease(q, worker, tile, generation);
    if (!t) return true;
    put_back(q, t);
    if (t->faults == TILE_QUEUE_FAULTS) return false;
    for (unsigned i = 0; i < t->faults; i++)
        if (t->faulted_by[i] == worker) return ++t->returns < TILE_QUEUE_RETURNS;
    t->faulted_by[t->faults++] = worker;
    return t->faults < TILE_QUEUE_FAULTS;
}

/* LIMIT_IMAGE_PIXELS in tiles of 64 px, by LIMIT_PASSES: half of what 32 bits hold. */
uint32_t tile_queue_count(const struct tile_queue *q)
{
    return q->passes;
}

uint32_t tile_queue_waiting(const struct tile_queue *q)
{
    return q->untouched.count + q->begun.count + q->returned_count;
}

uint32_t tile_queue_landed(const struct tile_queue *q)
{
    return q->landed;
}

uint64_t tile_queue_reissued(const struct tile_queue *q)
{
    return q->reissued;
}

uint64_t tile_queue_copied(const struct tile_queue *q)
{
    return q->copied;
}

bool tile_queue_complete(const struct tile_queue *q)
{
    return q->landed == q->passes;
}
