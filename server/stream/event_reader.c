/* A reader of events: Server-Sent Events (WHATWG HTML, section 9.2) as an MHD response. */
#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>

#include "server/stream/streams.h"

#define CHUNK_BYTES 4096u

static const char preface[] = "retry: 1000\n\n"; /* ms until a browser dials again */
static const char heartbeat[] = ":\n\n";

struct event_reader {
    struct reader base;
    uint64_t cursor;         /* id of the last event that was taken from the ring */
    struct event_text *text; /* being sent; NULL: none */
    size_t sent_bytes;
    bool greeted;
};

static ssize_t send_small(struct event_reader *r, char *out, size_t max_bytes, const char *text,
                          size_t size_bytes)
{
    if (max_bytes < size_bytes) return MHD_CONTENT_READER_END_WITH_ERROR;
    memcpy(out, text, size_bytes);
    return reader_gives(&r->base, size_bytes);
}

static size_t send_text(struct event_reader *r, char *out, size_t max_bytes)
{
    size_t left = r->text->size_bytes - r->sent_bytes;
    size_t n = left < max_bytes ? left : max_bytes;
    memcpy(out, r->text->bytes + r->sent_bytes, n);
    r->sent_bytes += n;
    if (n == left) event_text_unref(&r->text);
    return n;
}

/* Takes the next event that is worth sending; false when there is none. */
static bool take_event(struct event_reader *r)
{
    struct stream *stream = r->base.stream;
    r->text = stream && !r->base.ending ? event_ring_next(&stream->ring, &r->cursor) : NULL;
    r->sent_bytes = 0;
    return r->text != NULL;
}

/* Returns whether no more will come. The stream is over, or the reader has fallen so far behind
 * that events which matter are gone. It then dials again and gets a snapshot. */
static bool is_over(const struct event_reader *r)
{
    const struct stream *stream = r->base.stream;
    return !stream || r->base.ending || !event_ring_has_after(&stream->ring, r->cursor) ||
           (stream->final && !event_ring_pending(&stream->ring, r->cursor));
}

static bool fell_behind(const struct event_reader *r)
{
    const struct stream *stream = r->base.stream;
    return stream && r->base.streams && !r->base.ending &&
           !event_ring_has_after(&stream->ring, r->cursor);
}

static ssize_t end_reader(struct event_reader *r)
{
    if (fell_behind(r)) r->base.streams->cut[READER_EVENTS]++;
    return MHD_CONTENT_READER_END_OF_STREAM;
}

/* Sends as many due events as there is room for; none once events are lost to the reader. */
static size_t send_events(struct event_reader *r, char *out, size_t max_bytes)
{
    size_t n = 0;
    while (n < max_bytes && (r->text || (!is_over(r) && take_event(r))))
        n += send_text(r, out + n, max_bytes - n);
    if (n > 0) reader_moved(&r->base);
    return n;
}

static ssize_t read_events(void *ctx, uint64_t position, char *out, size_t max_bytes)
{
    struct event_reader *r = ctx;
    (void)position;
    if (r->base.streams) (void)cpu_meter_switch(&r->base.streams->meter, CPU_METER_EVENTS);
    if (!r->greeted) {
        r->greeted = true;
        return send_small(r, out, max_bytes, preface, sizeof preface - 1);
    }
    const size_t n = send_events(r, out, max_bytes);
    if (n > 0) return reader_gives(&r->base, n);
    if (is_over(r)) return end_reader(r);
    if (r->base.beat) {
        r->base.beat = false;
        return send_small(r, out, max_bytes, heartbeat, sizeof heartbeat - 1);
    }
    return reader_sleep(&r->base);
}

static void free_reader(void *ctx)
{
    struct event_reader *r = ctx;
    event_text_unref(&r->text);
    reader_leave(&r->base);
    free(r);
}

struct MHD_Response *stream_events_response(struct streams *s, const char *job,
                                            struct MHD_Connection *connection,
                                            uint64_t last_event_id, json_t *snapshot, bool ended)
{
    struct stream *stream = ended ? NULL : streams_obtain(s, job);
    struct event_reader *r = calloc(1, sizeof *r);
    struct MHD_Response *response = NULL;
    bool replay =
        stream && last_event_id != 0 && event_ring_has_after(&stream->ring, last_event_id);
    if (!r || (!stream && !ended)) goto fail;
    r->base.kind = READER_EVENTS;
    if (!replay) {
        r->cursor = stream ? stream->ring.last_id : 0;
        r->text = event_text_create(s->epoch, r->cursor, "snapshot", snapshot);
        if (!r->text) goto fail;
    } else {
        r->cursor = last_event_id;
    }
    response = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, CHUNK_BYTES, read_events, r,
                                                 free_reader);
    if (!response) goto fail;
    reader_join(&r->base, s, stream, stream ? &stream->event_readers : &s->detached, connection);
    reader_bound_socket(&r->base);
    json_decref(snapshot);
    return response;
fail:
    if (r) event_text_unref(&r->text);
    free(r);
    json_decref(snapshot);
    return NULL;
}
