#pragma once
/* Decides how many tiles each worker gets: a pure function of what the workers hold and ask for.
 *
 * A worker's queue is filled to two tiles a thread, so that none of its threads waits for the link.
 * When fewer tiles are left, queues become shorter, down to one tile a thread, because at the end
 * all workers wait for what a slow one has queued. For the same reason a worker gets no tile that
 * it would finish later than the others finish all the rest and one tile more. Tiles go where the
 * fewest are held per thread, so that a short supply is spread evenly. */
#include <stddef.h>
#include <stdint.h>

#define SCHEDULE_TILES_PER_THREAD 2u

struct schedule_worker {
    uint32_t threads; /* at least 1 */
    uint32_t want;    /* tiles it asked for and did not get */
    uint32_t in_hand; /* leases it holds */
    double pace_ms;   /* that a thread takes for a tile; 0: not known */
};

/* Returns the most tiles that a worker should hold, of `supply` left for `threads_total` threads.
 */
uint32_t schedule_depth(uint32_t threads, uint64_t threads_total, uint64_t supply);

/* Shares tiles out. `workers` are all that may work, also those that want nothing. Fills give[i],
 * the tiles for worker i: at most its want, their sum at most `supply`. supply UINT64_MAX: not
 * known. Ties go to the worker that comes first. */
void schedule_share(const struct schedule_worker *workers, size_t count, uint64_t supply,
                    uint32_t *give);
