#pragma once
/* The streams of all jobs and their readers, as the files of this folder see them.
 *
 * A stream is created by its job's first event or reader. It is freed after the final event with
 * its last reader, or when it is forgotten. Readers that outlive their stream end. */
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
    struct block_cache *caches;   /* its encoded blocks; each reader uses one of the caches */
    bool kept;                    /* the image is gone: readers are sent what the caches have */
    struct pixel_changes changes; /* of the image's blocks: for readers that join */
    struct stream_view view;      /* that the image shows; number 0: none */
    uint64_t generation;          /* of the image: grows with stream_image */
    uint64_t revision;            /* of its pixels: grows, also over lives of the coordinator */
    uint64_t progress_ms;         /* when readers were last woken for progress */
    bool progress_waits;          /* an event is there that streams_tick will wake readers for */
    bool in_work;                 /* until the final event, also when the image is gone */
    bool final;
};

/* What was spent up to the last settlement. */
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
        due; /* kind of the last callback that gave MHD bytes, which are yet to be sent */
    struct cpu_budget cpu_budget;
    struct settled settled;
    struct rate_limit rate_limit;
    struct pixel_budget cache_budget; /* of all streams' caches */
    uint64_t now_ms;                  /* as of the last tick */
    uint64_t stuck_ms;                /* after which a reader that takes nothing is cut */
    uint64_t cut[READER_KINDS];
    uint64_t pixel_bytes; /* given to readers */
    uint64_t blocks_made, blocks_sent;
    uint64_t tells_late;       /* times that events had to wait */
    uint64_t beat_ms, peek_ms; /* when these were last done */
    uint32_t epoch;
    unsigned readers;
};

struct stream *streams_find(struct streams *streams, const char *job);

/* Finds or creates a stream. NULL on failed allocation, or for a job id that is too long. */
struct stream *streams_obtain(struct streams *streams, const char *job);

/* Frees the stream if it is not needed any more. */
void stream_settle(struct stream *stream);
void streams_kick(struct streams *streams);

/* Charges what was spent since the last call, and tells the rate limit what feeds may take
 * (stream_limits.c). */
void streams_settle(struct streams *streams);
/* Does so if the last time is as long ago as turns are apart. */
void streams_settle_when_due(struct streams *streams);
/* Sets whether its pictures are in work. While any are, feeds are limited. */
void stream_set_in_work(struct stream *stream, bool in_work);
/* Returns whether readers may be woken for events that can wait. */
bool streams_may_tell(struct streams *streams);
uint64_t streams_clock_us(void);
