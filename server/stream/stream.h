#pragma once
/* The streams of running jobs: events (Server-Sent Events with ids and replay) and pixels (a binary
 * feed, newest wins).
 *
 * A stream belongs to one job. The job's side publishes; readers are MHD responses. All calls are
 * on the loop's thread. MHD_run must follow a publish, so that suspended readers go on:
 * streams_set_kick. */
#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "server/image/image.h"
#include "server/stream/cpu_meter.h"
#include "server/stream/pixels.h"
#include "server/stream/rate_limit.h"
#include "server/stream/reader.h"

struct streams;
struct MHD_Response;
struct MHD_Connection;

int streams_create(struct streams **out);
void streams_destroy(struct streams **streams);

/* Sends heartbeats and delayed progress, and drops clients that have left. The HTTP side calls it
 * about four times a second. */
void streams_tick(struct streams *streams);

/* Returns the id that a Last-Event-ID field names; 0 when it is none of this run of the
 * coordinator. On the wire an id is EPOCH-NUMBER, so that ids from before a restart replay nothing.
 */
uint64_t streams_event_id(const struct streams *streams, const char *text);

/* Sets what is called after connections were resumed; the HTTP side then runs MHD soon. */
void streams_set_kick(struct streams *streams, void (*kick)(void *ctx), void *ctx);

/* Ends every reader (before the daemon stops). */
void streams_end_all(struct streams *streams);

/* Publishes an event of a job: name is state, progress, tile, frame, error or snapshot. data is
 * borrowed and written as compact JSON in one line. Ids grow by one per job, from 1. `final` ends
 * the readers after it. Events are kept in a ring of LIMIT_EVENT_RING. For slow readers, progress
 * and tile events replace an unsent older one of their kind. */
void stream_event(struct streams *streams, const char *job, const char *name, json_t *data,
                  bool final);

/* Sets the image that pixel readers see, borrowed until stream_image is called with NULL. All of it
 * is new to them, also when it follows another. */
void stream_image(struct streams *streams, const char *job, const struct image *image);
/* One camera's view of a live job. Its pictures follow each other at growing resolution. */
struct stream_view {
    uint32_t number;             /* from 1; another one is another view */
    int32_t width_px, height_px; /* of its full picture */
};

/* Does the same for an image that shows a view. An image of another size than the full picture is a
 * coarser one of the same. Readers are told both sizes, and get no pixels until stream_pixels. */
void stream_view(struct streams *streams, const char *job, const struct image *image,
                 const struct stream_view *view);
void stream_pixels(struct streams *streams, const char *job, struct rect changed);

/* Forgets the job; readers end. */
void stream_forget(struct streams *streams, const char *job);

/* Creates a reader of events as an MHD response; NULL on failed allocation. `snapshot` (taken) is
 * sent first when last_event_id (0: none) cannot be replayed from the ring. For ended jobs the
 * snapshot is the only event. */
struct MHD_Response *stream_events_response(struct streams *streams, const char *job,
                                            struct MHD_Connection *connection,
                                            uint64_t last_event_id, json_t *snapshot, bool ended);

/* What a reader of pixels asks for; borrowed for the call. */
struct pixels_request {
    const char *layer;
    enum pixels_format format;
    uint64_t after; /* the revision that it has from an earlier feed of the same layer; 0: none */
};

/* Creates a reader of a layer's pixel feed, which consists of blocks "SWPX" (see PROTOCOL.md): u32
 * magic, u16 version, u16 format (1: 3 x f16, 2: 3 x f32, 3 and 4: the same with alpha), u32 x, y,
 * w, h, u64 revision, then w*h*3 numbers, row by row, and with alpha w*h more. The first message
 * has the image's size (w = 0, h = 0, x = width, y = height). The reader has every change up to the
 * revision, and may ask to continue after it. */
struct MHD_Response *stream_pixels_response(struct streams *streams, const char *job,
                                            struct MHD_Connection *connection,
                                            const struct pixels_request *wanted);

/* Creates a reader of an image that will not change any more (taken): it gets all of it once, then
 * ends. */
struct MHD_Response *stream_still_response(struct streams *streams,
                                           struct MHD_Connection *connection, struct image *image,
                                           const struct pixels_request *wanted);

/* The limits of all streams. Without a call of streams_limit there are none. */
struct streams_limits {
    int64_t
        feed_bytes_per_s; /* of all feeds, while pictures are in work (rate_limit.h); 0: no limit */
    int64_t cpu_us_per_s; /* of all streams (cpu_budget.h); 0: no limit */
    uint64_t stuck_ms;    /* a reader whose socket has taken nothing for so long is cut */
};
void streams_limit(struct streams *streams, const struct streams_limits *limits);

/* Counts the thread's CPU time for this kind from here on, and returns the kind before. Streams
 * switch by themselves when they are called. */
enum cpu_meter_kind streams_meter(struct streams *streams, enum cpu_meter_kind kind);

/* Must be called before and after MHD runs. What MHD has yet to send for streams is sent on their
 * time, until streams_meter switches. */
void streams_meter_run(struct streams *streams);
void streams_meter_ran(struct streams *streams);

/* Returns whether readers of pixels wait for their turn. While they do, streams_pace must be called
 * every RATE_LIMIT_EVERY_MS, and MHD run after it. streams_pace deals turns and returns whether
 * some still wait. */
bool streams_wait(const struct streams *streams);
bool streams_pace(struct streams *streams);

/* Sets what is called, with streams_set_kick's ctx, when a reader is cut. */
void streams_set_told_cut(struct streams *streams,
                          void (*told)(void *ctx, enum reader_kind kind, const char *job));

struct streams_totals {
    unsigned readers;
    uint64_t cut_events, cut_pixels;   /* readers that did not read, or fell too far behind */
    uint64_t pixel_bytes;              /* of feeds */
    uint64_t blocks_made, blocks_sent; /* of pictures in work: those made once serve many */
    uint64_t kept_bytes;               /* of blocks that are kept for all feeds */
    uint64_t waits;                    /* turns of feeds that had to wait */
    uint64_t tells_late;               /* times that events waited for their budget */
    uint64_t events_cpu_us, pixels_cpu_us;
};
void streams_totals(struct streams *streams, struct streams_totals *out);
