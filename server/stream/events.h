#pragma once
/* The events of one job: the last few as text, ready to send, with ids for replay.
 *
 * A cursor is the id of the last event that a reader has; it walks the ring without holding on to
 * it. Progress and tile events are only worth their newest: a cursor that is behind skips older
 * ones. */
#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"

/* An event as it goes over the wire, shared by the ring and the readers that are sending it. */
struct event_text {
    unsigned refs;
    size_t size_bytes;
    char bytes[];
};

void event_text_unref(struct event_text **text);

/* Formats "id: EPOCH-ID\nevent: NAME\ndata: JSON\n\n". NULL on failed allocation. One reference. */
struct event_text *event_text_create(uint32_t epoch, uint64_t id, const char *name,
                                     const json_t *data);

enum event_kind { EVENT_KEPT, EVENT_PROGRESS, EVENT_TILE };
#define EVENT_KINDS 3

struct event_slot {
    enum event_kind kind;
    struct event_text *text;
};

struct event_ring {
    uint32_t epoch;          /* of this run of the coordinator: ids of another run replay nothing */
    struct event_slot *slot; /* owned; slot of id: id % capacity */
    uint32_t capacity;       /* a power of two up to LIMIT_EVENT_RING */
    uint32_t count;
    uint64_t last_id;             /* 0: no event yet */
    uint64_t lost_id;             /* newest event that was dropped and cannot be skipped */
    uint64_t newest[EVENT_KINDS]; /* id of the newest of each kind */
};

void event_ring_init(struct event_ring *ring, uint32_t epoch);
void event_ring_fini(struct event_ring *ring);

/* Adds an event; the oldest of LIMIT_EVENT_RING goes. ERR_MEMORY: the event counts as lost, so that
 * readers notice. */
int event_ring_push(struct event_ring *ring, const char *name, const json_t *data);

/* Returns whether a reader that has everything up to `cursor` can go on from the ring. */
bool event_ring_has_after(const struct event_ring *ring, uint64_t cursor);

/* Returns the next event after *cursor that is still worth sending, with a reference for the
 * caller, and moves the cursor to it. NULL when there is none. */
struct event_text *event_ring_next(const struct event_ring *ring, uint64_t *cursor);

/* Returns whether event_ring_next would find one. */
bool event_ring_pending(const struct event_ring *ring, uint64_t cursor);

/* Parses a Last-Event-ID field; 0 when it is malformed or of another epoch. */
uint64_t event_id_read(uint32_t epoch, const char *text);
