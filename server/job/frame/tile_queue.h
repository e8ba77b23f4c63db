#pragma once
/* The tiles of a frame: who traces which, and what became of it. Pure data, no clock, no IO.
 *
 * A tile is traced in passes, one after the other. For its pass it waits, is leased to a worker
 * under a generation, its result is received (taken to be decoded) and then lands; it then waits
 * for the next pass, until its last has landed. Anything else puts it back in the queue, where it
 * goes first. A result counts under the lease that is in force, or, while the tile waits after this
 * came back, under the one that was last: whose link broke may send under another name what nobody
 * has begun since.
 *
 * Of a tile whose worker is slow a copy may be leased to a second one: two leases are in force, and
 * the first result counts. The bytes are the same whoever sends them.
 *
 * A window of tiles after the other is brought to its last pass, so that what is held between
 * passes is bounded; small pictures are one window. Within it the pass that is least far goes
 * first, so that the window forms early and no tile is left behind with many passes to go. Within
 * a pass tiles are given in the order of tile_order.h. A priority goes before all that, but for
 * tiles that came back, and for the bound on tiles between passes. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/link/message.h"
#include "proto/tile.h"
#include "server/job/frame/tile_order.h"

/* Different workers that must have failed at a tile before the frame fails. */
#define TILE_QUEUE_FAULTS 3
/* Times that a pass of a tile may come back without a result, by workers that died or gave up: a
 * tile that kills every worker must not do so for ever. */
#define TILE_QUEUE_RETURNS 32
/* Workers that may die in a row while they trace a pass of a tile. After the first, the tile is a
 * suspect: it is to be leased to workers that hold nothing else, so that those that die after it
 * were ended by it, and what died with it by chance is cleared. */
#define TILE_QUEUE_DEATHS 3
/* Windows of tiles that may be between their first pass and their last when priorities change. */
#define TILE_QUEUE_WINDOWS 4

struct tile_queue;

/* Tiles are taken cell by cell, cell_px a side, in windows of `window` tiles in their order (at
 * least 1); each has `passes` passes, 1 .. LIMIT_PASSES. ERR_MEMORY. */
int tile_queue_create(const struct tile_grid *grid, int32_t cell_px, uint32_t passes,
                      uint32_t window, struct tile_queue **out);
void tile_queue_destroy(struct tile_queue **queue);

/* Leases the next tile to a worker; false when none waits. Generations of a tile grow from 1 over
 * all its passes. */
bool tile_queue_lease(struct tile_queue *q, uint64_t worker, uint32_t *tile, uint32_t *generation);
/* A worker has died at this pass of the tile. */
bool tile_queue_is_suspect(const struct tile_queue *q, uint32_t tile);
/* The next tile is one: only a worker that holds nothing should ask. */
bool tile_queue_gives_suspect(const struct tile_queue *q);
/* It did not die of what it was at. */
void tile_queue_survived(struct tile_queue *q, uint64_t worker);

/* Leases a copy of a leased tile to another worker. False, and nothing is leased, when that lease
 * is not in force, the worker holds the tile itself, it is a suspect, or there is a copy already.
 */
bool tile_queue_copy(struct tile_queue *q, uint64_t worker, uint32_t tile, uint32_t of_generation,
                     uint32_t *generation);

/* Changes the order from now on. An empty priority is the order of the start. */
void tile_queue_steer(struct tile_queue *q, const struct tile_priority *priority);

/* A tile whose passes have all landed gets more of them, LIMIT_PASSES in all at most. */
void tile_queue_extend(struct tile_queue *q, uint32_t tile, uint32_t passes);

/* The pass that a tile waits for, is leased or received for; the count of passes when the last has
 * landed. */
uint32_t tile_queue_pass(const struct tile_queue *q, uint32_t tile);

/* A result came: ACCEPTED (the tile is now received; land or reject it), DUPLICATE, STALE (leased
 * again since) or FOREIGN (no such tile, never leased in that generation, or leased to another
 * worker). */
enum verdict tile_queue_receive(struct tile_queue *q, uint64_t worker, uint32_t tile,
                                uint32_t generation);

/* What a received tile turned out to be. */
void tile_queue_land(struct tile_queue *q, uint32_t tile);
void tile_queue_reject(struct tile_queue *q, uint32_t tile);

/* Tiles whose result is there already: takes all of those that wait, for a pass not leased before,
 * and that `is_wanted`; they are received from then on, and stand in `out` (room for all tiles), as
 * many as it returns, in the order in which they would have been leased. No tile that came back
 * may wait. */
uint32_t tile_queue_take(struct tile_queue *q, bool (*is_wanted)(void *ctx, uint32_t tile),
                         void *ctx, uint32_t *out);
/* Lands a pass of a received tile that has another, of which it is received at once, too. */
void tile_queue_land_and_take(struct tile_queue *q, uint32_t tile);
/* A tile that was taken waits to be leased after all. */
void tile_queue_give_up(struct tile_queue *q, uint32_t tile);
/* Passes of a tile, in all. */
uint32_t tile_queue_passes(const struct tile_queue *q, uint32_t tile);

/* Why a lease came back without a result. */
enum tile_cause {
    TILE_GIVEN_BACK, /* for any reason that may be the tile's */
    TILE_DIED,       /* its worker did, at the tile */
    TILE_INNOCENT,   /* its worker was sent away for what it did; not counted */
};
enum tile_return { TILE_GOES_ON, TILE_CAME_BACK_OFTEN, TILE_IS_DEADLY };

/* Ignored unless the lease is in force. What is not TILE_GOES_ON should be given to nobody any
 * more. */
enum tile_return tile_queue_return(struct tile_queue *q, uint64_t worker, uint32_t tile,
                                   uint32_t generation, enum tile_cause cause);

/* A worker cannot trace the tile; ignored unless the lease is in force. False when too many
 * different workers said so. */
bool tile_queue_fault(struct tile_queue *q, uint64_t worker, uint32_t tile, uint32_t generation);

uint32_t tile_queue_count(const struct tile_queue *q);   /* passes of all tiles */
uint32_t tile_queue_waiting(const struct tile_queue *q); /* tiles that could be leased now */
uint32_t tile_queue_landed(const struct tile_queue *q);  /* passes of all tiles */
/* Leases beyond the first of each pass of each tile. */
uint64_t tile_queue_reissued(const struct tile_queue *q);
/* Copies that were leased; they are not among these. */
uint64_t tile_queue_copied(const struct tile_queue *q);
bool tile_queue_complete(const struct tile_queue *q);
