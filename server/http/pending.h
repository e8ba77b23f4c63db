#pragma once
/* Requests that wait for what the store, the pool or the importer does: how many there may be, and
 * for how long each is kept waiting.
 *
 * Nobody waits for ever on a disk that hangs. Who has waited for his time is told so (503
 * `overdue`), and what he asked for is done later or not at all, never by half: nothing more is
 * begun for him, and what the store has already comes out whole. Until that is over he is counted
 * here, whether his connection goes on or not, so that asking again and again fills no memory. */
#include <stdbool.h>
#include <stdint.h>

struct http;
struct request;

struct pending {
    uint64_t answer_ms; /* what a request may wait for that asks for no more than an answer */
    unsigned count;     /* that a callback will come for, also of those that were told */
    uint64_t overdue;   /* told, since the start */
};

/* Can one more wait? */
bool pending_has_room(const struct http *http);

/* From time to time: tells those who have waited for too long. */
void pending_tick(struct http *http);
