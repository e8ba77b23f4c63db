#pragma once
/* A connection that follows a stream: asleep (suspended) until there is something to send. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "proto/tile.h"

struct MHD_Connection;
struct MHD_Response;
struct stream;
struct streams;

enum reader_kind { READER_EVENTS, READER_PIXELS };
#define READER_KINDS 2

struct reader {
    enum reader_kind kind;
    struct streams *streams; /* NULL: they are gone */
    struct stream *stream;   /* NULL: it has none, or it is gone; the reader ends */
    struct reader *next, **link;
    struct MHD_Connection *connection;
    bool suspended;
    bool ending;       /* nothing more is to be sent */
    bool beat;         /* a heartbeat is due */
    bool cut;          /* it was: it did not read */
    uint64_t moved_ms; /* when it last took something, or was woken to */
    int unsent_bytes;  /* that waited in its socket when that was last looked at */
    /* In the line for a turn (rate_limit.h). */
    bool waits;
    struct reader *wait_next, **wait_link;
    int64_t turn_bytes; /* that it may send still */
};

/* Joins a list of a stream, or streams->detached when stream is NULL. */
void reader_join(struct reader *r, struct streams *streams, struct stream *stream,
                 struct reader **list, struct MHD_Connection *connection);
void reader_leave(struct reader *r);

/* It took bytes: what a callback does that gives some. */
void reader_moved(struct reader *r);

/* What a callback returns that has something to send: MHD does so when it runs next, on the kind's
 * time. */
ssize_t reader_gives(struct reader *r, size_t bytes);

/* Is it awake, and has taken nothing for so long? Then its socket is full, and as full as it was: a
 * slow link takes bytes out of it long before there is room for more. Asked at each tick. */
bool reader_is_stuck(struct reader *r, uint64_t now_ms, uint64_t after_ms);
/* Ends its connection, and counts it; who dials again is given a snapshot. */
void reader_cut(struct reader *r);

/* Few bytes wait in the kernel for a reader of events, so that it is seen early that it is stuck.
 */
void reader_bound_socket(const struct reader *r);

/* Puts the connection to sleep: what a callback returns when it has nothing to send. */
ssize_t reader_sleep(struct reader *r);

/* Wakes it, if it sleeps. streams_kick must follow. */
void reader_wake(struct reader *r);
void readers_wake(struct reader *list);

/* Has the client closed its side? Asked while the connection sleeps, as MHD does not look then. */
bool reader_is_gone(const struct reader *r);

/* pixel_reader.c: a part of the image that the reader was told about has changed. */
void pixel_reader_mark(struct reader *reader, struct rect changed);

/* The image goes: what its readers lack of it is made and kept for them. */
void pixel_readers_keep(struct stream *stream);
/* The stream goes: they let go of its caches. */
void pixel_readers_orphan(struct stream *stream);
