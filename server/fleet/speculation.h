#pragma once
/* Tiles that come late: which leased tile an idle worker should trace, too, so that a frame does
 * not wait for the slowest of its workers. Pure, no clock, no IO.
 *
 * A worker takes its tiles in the order in which it got them; how long a thread of it takes is
 * known from its last results. A tile under work longer than that is expected to take half as long
 * again as it has taken already. A copy pays where the idle worker would be done well before: then
 * the first result counts (server/job/frame/tile_queue.h). After Dean and Ghemawat 2004 (MapReduce,
 * backup tasks) and Zaharia et al. 2008 (LATE: the longest approximate time to end first). */
#include <stddef.h>

#include "server/fleet/lease.h"

struct speculation {
    size_t holder; /* its table's place among those given */
    uint32_t at;   /* its place in the table */
    double gain_ms;
};

/* The lease whose copy by the worker of tables[idle] gains most; false when none pays now. Tables
 * may be NULL. */
bool speculation_find(const struct lease_table *const *tables, size_t count, size_t idle,
                      uint64_t now_ms, struct speculation *out);
