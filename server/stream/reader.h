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
    struct streams *streams; /* NULL once they are gone */
    struct stream *stream;   /* NULL: none, or it is gone; the reader ends */
    struct reader *next, **link;
    struct MHD_Connection *connection;
    bool suspended;
    bool ending;       /* nothing more is to be sent */
    bool beat;         /* a heartbeat is due */
    bool cut;          /* its connection was ended because it did not read */
    uint64_t moved_ms; /* when it last took something, or was woken to */
    int unsent_bytes;  /* in its socket at the last look */
    /* In the line for a turn (rate_limit.h). */
    bool waits;
    struct reader *wait_next, **wait_link;
    int64_t turn_bytes; /* left of its turn */
};

/* Joins a list of a stream, or streams->detached when stream is NULL. */
void reader_join(struct reader *r, struct streams *streams, struct stream *stream,
                 struct reader **list, struct MHD_Connection *connection);
void reader_leave(struct reader *r);

/* Notes that it took bytes, for callbacks that give some. */
void reader_moved(struct reader *r);

/* Returns what a callback must return when it has something to send. MHD sends it when it runs
 * next, on the kind's time. */
ssize_t reader_gives(struct reader *r, size_t bytes);

/* Returns whether it is awake and has taken nothing for so long. A slow link may take bytes out of
 * a full socket long before there is room for more, so the socket is looked at, too. Must be called
 * at each tick. */
bool reader_is_stuck(struct reader *r, uint64_t now_ms, uint64_t after_ms);
/* Ends its connection, and counts it. A client that connects again gets a snapshot. */
void reader_cut(struct reader *r);

/* Keeps the socket's buffer small for a reader of events, so that a stuck one is noticed early. */
void reader_bound_socket(const struct reader *r);

/* Puts the connection to sleep. Returns what a callback must return when it has nothing to send. */
ssize_t reader_sleep(struct reader *r);

/* Wakes it, if it sleeps. streams_kick must follow. */
void reader_wake(struct reader *r);
void readers_wake(struct reader *list);

/* Returns whether the client has closed its side. Needed while the connection sleeps, as MHD does
 * not look then. */
bool reader_is_gone(const struct reader *r);

/* Marks a part of the reader's image as changed (pixel_reader.c). */
void pixel_reader_mark(struct reader *reader, struct rect changed);

/* Encodes and keeps what readers lack of an image that goes. */
void pixel_readers_keep(struct stream *stream);
/* Releases the caches of a stream that goes. */
void pixel_readers_orphan(struct stream *stream);
