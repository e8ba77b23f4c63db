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

struct reader {
    struct streams *streams; /* NULL: they are gone */
    struct stream *stream;   /* NULL: it has none, or it is gone; the reader ends */
    struct reader *next, **link;
    struct MHD_Connection *connection;
    bool suspended;
    bool ending; /* nothing more is to be sent */
    bool beat;   /* a heartbeat is due */
};

/* Joins a list of a stream, or streams->detached when stream is NULL. */
void reader_join(struct reader *r, struct streams *streams, struct stream *stream,
                 struct reader **list, struct MHD_Connection *connection);
void reader_leave(struct reader *r);

/* Puts the connection to sleep: what a callback returns when it has nothing to send. */
ssize_t reader_sleep(struct reader *r);

/* Wakes it, if it sleeps. streams_kick must follow. */
void reader_wake(struct reader *r);
void readers_wake(struct reader *list);

/* Has the client closed its side? Asked while the connection sleeps, as MHD does not look then. */
bool reader_is_gone(const struct reader *r);

/* pixel_reader.c: a part of the image that the reader was told about has changed. */
void pixel_reader_mark(struct reader *reader, struct rect changed);
