#pragma once
/* Requests that wait for the store, the pool or the importer: how many there may be, and for how
 * long each may wait.
 *
 * No client waits for ever on a disk that hangs. After its time a request is answered with 503
 * `overdue`. What it asked for is then done later or not at all, never by half: nothing more is
 * begun for it, and what the store has already is completed. It is counted here until then, even
 * after its connection has ended, so that repeated requests fill no memory. */
#include <stdbool.h>
#include <stdint.h>

struct http;
struct request;

struct pending {
    uint64_t answer_ms; /* longest wait of a request that needs no more than an answer */
    unsigned count;     /* with a callback to come, also those that were answered */
    uint64_t overdue;   /* answered as overdue, since the start */
};

/* Returns whether one more may wait. */
bool pending_has_room(const struct http *http);

/* Answers requests that have waited for too long. Called from time to time. */
void pending_tick(struct http *http);
