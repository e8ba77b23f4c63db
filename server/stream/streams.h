#pragma once
/* The streams of all jobs and their readers, as the files of this folder see them.
 *
 * A stream comes with its job's first event or reader and goes after the final event with its last
 * reader, or when it is forgotten. Readers that outlive their stream end. */
#include "proto/limits.h"
#include "server/stream/block_cache.h"
#include "server/stream/cpu_budget.h"
#include "server/stream/cpu_meter.h"
#include "server/stream/events.h"
#include "server/stream/pixels.h"
#include "server/stream/rate_limit.h"
#include "server/stream/reader.h"
#include "server/stream/stream.h"

#define STREAM_JOB_BYTES 32
#define STREAM_BUCKETS   1024u

struct stream {
    struct streams *streams;
    struct stream *next; /* in its bucket */
    char job[STREAM_JOB_BYTES];
    struct event_ring ring;
    struct reader *event_readers, *pixel_readers;
    const struct image *image;    /* borrowed from the job's side */
    struct block_cache *caches;   /* its blocks as they go out; of them the readers hold one each */
    bool kept;                    /* the image is gone: readers are sent what caches have of it */
    struct pixel_changes changes; /* of the image's blocks: for readers that join */
    struct stream_view view;      /* that the image shows; number 0: none */
    uint64_t generation;          /* of the image: grows with stream_image */
    uint64_t revision;            /* of its pixels: grows, also over lives of the coordinator */
    uint64_t progress_ms;         /* when readers were last woken for progress */
    bool progress_waits;          /* an event that streams_tick will wake readers for */
    bool in_work; /* its pictures: until the event that ends it, also when the image is gone */
    bool final;
};

/* What has been told of spending: the rest is new. */
struct settled {
    uint64_t events_us, pixels_us, pixel_bytes;
};

struct streams {
    struct stream *bucket[STREAM_BUCKETS];
    struct reader *detached; /* readers whose stream is gone */
    void (*kick)(void *ctx);
    void *kick_ctx;
    void (*told_cut)(void *ctx, enum reader_kind kind, const char *job); /* of the same ctx */
    struct cpu_meter meter;
    enum cpu_meter_kind
        due; /* the kind of the last that gave MHD bytes, which it has yet to send */
    struct cpu_budget cpu_budget;
    struct settled settled;
    struct rate_limit rate_limit;
    struct pixel_budget cache_budget; /* of all streams' caches */
    uint64_t now_ms;                  /* as of the last tick */
    uint64_t stuck_ms;                /* until a reader that takes nothing is cut */
    uint64_t cut[READER_KINDS];
    uint64_t pixel_bytes; /* given to readers */
    uint64_t blocks_made, blocks_sent;
    uint64_t tells_late;       /* events that can wait had to */
    uint64_t beat_ms, peek_ms; /* when these were last done */
    uint32_t epoch;
    unsigned readers;
};

struct stream *streams_find(struct streams *streams, const char *job);

/* Finds or makes; NULL on failed allocation or a job id that is too long. */
struct stream *streams_obtain(struct streams *streams, const char *job);

/* Frees the stream if nobody needs it any more. */
void stream_settle(struct stream *stream);
void streams_kick(struct streams *streams);

/* stream_limits.c: what was spent since the last time is counted, and what there is for feeds is
 * told to the rate limit. */
void streams_settle(struct streams *streams);
/* As often as turns are dealt. */
void streams_settle_when_due(struct streams *streams);
/* Are its pictures in work? While any are, feeds are paced. */
void stream_set_in_work(struct stream *stream, bool in_work);
/* May readers be woken for events that can wait? */
bool streams_may_tell(struct streams *streams);
uint64_t streams_clock_us(void);
