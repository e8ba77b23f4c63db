#pragma once
/* The tiles of a frame, and the state of each. Pure data, no clock, no IO.
 *
 * A tile is traced in passes, one after the other. In each pass it waits, is leased to a worker
 * under a generation, its result is received (taken to be decoded) and lands; then it waits for the
 * next pass, until the last has landed. In any other case it goes back to the head of the queue. A
 * result counts under the lease in force. While the tile waits again, it also counts under the last
 * lease that ended, so a worker that comes back under a new id can still deliver it.
 *
 * A tile of a slow worker may be leased to a second one as a copy: two leases are in force, and the
 * first result counts. The bytes are the same from any worker.
 *
 * Tiles are brought to their last pass window by window, so that what is held between passes is
 * bounded; small pictures are one window. Within a window the least advanced pass goes first, so
 * that the picture forms early and no tile is left behind with many passes to go. Within a pass
 * tiles are leased in the order of tile_order.h. A priority goes before all that, but for tiles
 * that came back, and for the bound on tiles between passes. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/link/message.h"
#include "proto/tile.h"
#include "server/job/frame/tile_order.h"

/* The number of different workers that must fail at a tile before the frame fails. */
#define TILE_QUEUE_FAULTS 3
/* The number of times that a pass of a tile may come back without a result from workers that died
 * or gave up: a tile that kills every worker must not do so for ever. */
#define TILE_QUEUE_RETURNS 32
/* The number of workers in a row that may die while they trace a pass of a tile. After the first
 * the tile is a suspect, leased only to workers that hold nothing else. So a worker that dies after
 * that died of it, and tiles that were held beside it by chance are cleared. As many more may die
 * as have died meanwhile at tiles that nobody suspected. */
#define TILE_QUEUE_DEATHS 3
/* The number of windows of tiles that may be between their first pass and their last when
 * priorities change. */
#define TILE_QUEUE_WINDOWS 4

struct tile_queue;

/* Creates the queue. Tiles are leased cell by cell, cell_px a side, in windows of `window` tiles in
 * their order (at least 1). Each has `passes` passes, 1 .. LIMIT_PASSES. ERR_MEMORY. */
int tile_queue_create(const struct tile_grid *grid, int32_t cell_px, uint32_t passes,
                      uint32_t window, struct tile_queue **out);
void tile_queue_destroy(struct tile_queue **queue);

/* Leases the next tile to a worker; false when none waits. Generations of a tile grow from 1 over
 * all its passes. */
bool tile_queue_lease(struct tile_queue *q, uint64_t worker, uint32_t *tile, uint32_t *generation);
/* Returns whether a worker has died at this pass of the tile. */
bool tile_queue_is_suspect(const struct tile_queue *q, uint32_t tile);
/* Returns whether the next tile is a suspect, which only a worker that holds nothing should get. */
bool tile_queue_gives_suspect(const struct tile_queue *q);
/* Clears the worker's deaths: it did not die of its tiles. */
void tile_queue_survived(struct tile_queue *q, uint64_t worker);

/* Leases a copy of a leased tile to another worker. False, and nothing is leased, when that lease
 * is not in force, the worker holds the tile itself, it is a suspect, or there is a copy already.
 */
bool tile_queue_copy(struct tile_queue *q, uint64_t worker, uint32_t tile, uint32_t of_generation,
                     uint32_t *generation);

/* Changes the order from now on. An empty priority is the order of the start. */
void tile_queue_steer(struct tile_queue *q, const struct tile_priority *priority);

/* Changes the order in which tiles come that are given more passes. Each then goes on to its last
 * pass before the next begins, as far as there are workers. All passes have landed. */
void tile_queue_reorder(struct tile_queue *q, const uint32_t *order);

/* Gives a tile whose passes have all landed more of them, LIMIT_PASSES in all at most. */
void tile_queue_extend(struct tile_queue *q, uint32_t tile, uint32_t passes);

/* Returns the pass that a tile waits for, is leased or received for; the count of passes when the
 * last has landed. */
uint32_t tile_queue_pass(const struct tile_queue *q, uint32_t tile);

/* Judges a result: ACCEPTED (the tile is now received; land or reject it), DUPLICATE, STALE (leased
 * again since) or FOREIGN (no such tile, never leased in that generation, or leased to another
 * worker). */
enum verdict tile_queue_receive(struct tile_queue *q, uint64_t worker, uint32_t tile,
                                uint32_t generation);

/* Ends the decoding of a received tile: its pass lands, or is rejected. */
void tile_queue_land(struct tile_queue *q, uint32_t tile);
void tile_queue_reject(struct tile_queue *q, uint32_t tile);

/* Takes waiting tiles whose result is there already. It takes all that `is_wanted` and that wait
 * for a pass not leased before. They are received then, and stand in `out` (room for all tiles), as
 * many as it returns, in the order in which they would have been leased. No tile that came back may
 * wait. */
uint32_t tile_queue_take(struct tile_queue *q, bool (*is_wanted)(void *ctx, uint32_t tile),
                         void *ctx, uint32_t *out);
/* Lands a pass of a received tile that has another pass, and receives that at once, too. */
void tile_queue_land_and_take(struct tile_queue *q, uint32_t tile);
/* Puts a tile that was taken back into the queue. */
void tile_queue_give_up(struct tile_queue *q, uint32_t tile);
/* Returns how many passes a tile has in all. */
uint32_t tile_queue_passes(const struct tile_queue *q, uint32_t tile);

/* Why a lease came back without a result. */
enum tile_cause {
    TILE_GIVEN_BACK, /* the tile may be the reason */
    TILE_DIED,       /* its worker died at the tile */
    TILE_INNOCENT,   /* its worker broke the protocol; not counted */
};
enum tile_return { TILE_GOES_ON, TILE_CAME_BACK_OFTEN, TILE_IS_DEADLY };

/* Returns a lease without a result; ignored unless the lease is in force. A tile that is not
 * TILE_GOES_ON should not be leased any more. */
enum tile_return tile_queue_return(struct tile_queue *q, uint64_t worker, uint32_t tile,
                                   uint32_t generation, enum tile_cause cause);

/* Notes that a worker cannot trace the tile; ignored unless the lease is in force. Returns false
 * when too many different workers said so. */
bool tile_queue_fault(struct tile_queue *q, uint64_t worker, uint32_t tile, uint32_t generation);

uint32_t tile_queue_count(const struct tile_queue *q);   /* passes of all tiles */
uint32_t tile_queue_waiting(const struct tile_queue *q); /* tiles that could be leased now */
uint32_t tile_queue_landed(const struct tile_queue *q);  /* passes of all tiles */
/* Returns the leases beyond the first of each pass of each tile, without copies. */
uint64_t tile_queue_reissued(const struct tile_queue *q);
/* Returns the copies that were leased. */
uint64_t tile_queue_copied(const struct tile_queue *q);
bool tile_queue_complete(const struct tile_queue *q);
