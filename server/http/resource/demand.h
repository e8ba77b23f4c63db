#pragma once
/* The work that waits and the workers that are there, for programs that scale workers. */
#include <stdint.h>

struct http;

struct demand {
    uint64_t jobs_waiting;  /* for their turn, and not paused */
    uint64_t tiles_waiting; /* of frames in work */
    uint64_t tiles_leased;  /* that workers hold */
    /* Threads that would have a tile now. A job that waits counts as one: its tiles are not known.
     * It is 0 only when nothing is to be done, so that the last worker may go then. */
    uint64_t threads_wanted;
    uint64_t workers, threads; /* that may work */
};

struct demand demand_now(const struct http *http);
