#pragma once
/* Speculative copies of late tiles: chooses which leased tile an idle worker should trace, too, so
 * that a frame does not wait for its slowest worker. Pure, no clock, no IO.
 *
 * A worker traces its tiles in the order of its leases, and its last results tell how long a thread
 * takes. A tile that takes longer is expected to take half as long again as it has taken already. A
 * copy pays when the idle worker would be done well before. The first result counts
 * (server/job/frame/tile_queue.h). After Dean and Ghemawat 2004 (MapReduce, backup tasks) and
 * Zaharia et al. 2008 (LATE: the longest approximate time to end first). */
#include <stddef.h>

#include "server/fleet/lease.h"

struct speculation {
    size_t holder; /* index of its table */
    uint32_t at;   /* index in the table */
    double gain_ms;
};

/* Finds the lease whose copy by the worker of tables[idle] gains most. Returns false when none pays
 * now. Tables may be NULL. */
bool speculation_find(const struct lease_table *const *tables, size_t count, size_t idle,
                      uint64_t now_ms, struct speculation *out);
