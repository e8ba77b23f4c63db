/* A reader of the pixel feed as an MHD response: at most one message of bytes in hand. */
#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>

#include "server/stream/streams.h"

struct pixel_reader {
    struct reader base;
    char layer[32];
    enum pixels_format format;
    struct pixel_blocks dirty;
    struct image *still; /* owned; an image without a stream */
    uint64_t generation; /* of the image that the reader was told about; 0: none */
    uint64_t has;        /* it has every change up to this revision */
    uint64_t sweep;      /* the revision when its walk over the blocks began anew */
    uint64_t told;       /* that it has, by the last message */
    size_t message_bytes, sent_bytes;
    uint8_t message[PIXELS_MESSAGE_BYTES];
};

void pixel_reader_mark(struct reader *reader, struct rect changed)
{
    struct pixel_reader *r = (struct pixel_reader *)reader; /* base is its first member */
    if (r->generation == reader->stream->generation) pixel_blocks_mark(&r->dirty, changed);
}

static void put_size(struct pixel_reader *r, const struct image *image, uint64_t revision)
{
    pixels_write_size(r->message, image->width_px, image->height_px, revision);
    r->message_bytes = PIXELS_HEADER_BYTES;
    r->told = revision;
}

/* Which view it is of goes before an image's size. */
static void put_view(struct pixel_reader *r, const struct stream_view *view)
{
    memmove(r->message + PIXELS_HEADER_BYTES, r->message, PIXELS_HEADER_BYTES);
    pixels_write_view(r->message, view->number, view->width_px, view->height_px, r->told);
    r->message_bytes += PIXELS_HEADER_BYTES;
}

/* A new image: its size goes first, then every block that has changed since the revision that the
 * reader has. Every change of a new image comes after those of the one before. */
static bool announce(struct pixel_reader *r)
{
    const struct stream *stream = r->base.stream;
    pixel_blocks_fini(&r->dirty);
    if (pixel_blocks_init(&r->dirty, stream->image->width_px, stream->image->height_px) != 0)
        return false;
    if (r->has > stream->revision)
        r->has = 0; /* it has that from another life of the coordinator */
    pixel_blocks_join(&r->dirty, &stream->changes, r->has);
    r->generation = stream->generation;
    r->sweep = stream->revision;
    put_size(r, stream->image, r->has);
    if (stream->view.number > 0) put_view(r, &stream->view);
    return true;
}

/* Takes the next block. The walk goes over the blocks round and round: when it begins anew, all
 * that was dirty at its last beginning has been sent. */
static bool take_block(struct pixel_reader *r, struct rect *block)
{
    const struct stream *stream = r->base.stream;
    uint32_t from = r->dirty.next;
    if (!pixel_blocks_take(&r->dirty, block)) {
        r->has = r->sweep = stream->revision;
        return false;
    }
    if (r->dirty.next <= from) {
        r->has = r->sweep;
        r->sweep = stream->revision;
    }
    return true;
}

/* A reader has nothing of a still picture for sure until it has the last block. */
static bool next_of_still(struct pixel_reader *r)
{
    struct rect block;
    if (r->base.ending || !pixel_blocks_take(&r->dirty, &block)) return false;
    r->has = r->dirty.count == 0 ? PIXELS_STILL_REVISION : 0;
    r->message_bytes = pixels_write_block(r->message, r->still, r->layer, r->format, block, r->has);
    return r->message_bytes > 0;
}

/* Prepares the next message. False when the feed ends; no bytes when there is nothing to say now.
 */
static bool next_message(struct pixel_reader *r)
{
    const struct stream *stream = r->base.stream;
    struct rect block;
    r->message_bytes = r->sent_bytes = 0;
    if (r->still) return next_of_still(r);
    if (!stream || r->base.ending) return false;
    if (stream->image && r->generation != stream->generation) return announce(r);
    if (stream->image && take_block(r, &block)) {
        r->message_bytes =
            pixels_write_block(r->message, stream->image, r->layer, r->format, block, r->has);
        r->told = r->has;
        return r->message_bytes > 0;
    }
    if (stream->image && (r->base.beat || r->told != r->has)) {
        put_size(r, stream->image, r->has);
        r->base.beat = false;
        return true;
    }
    return !stream->final;
}

static ssize_t read_pixels(void *ctx, uint64_t position, char *out, size_t max_bytes)
{
    struct pixel_reader *r = ctx;
    (void)position;
    if (r->sent_bytes == r->message_bytes && !next_message(r))
        return MHD_CONTENT_READER_END_OF_STREAM;
    size_t left = r->message_bytes - r->sent_bytes;
    if (left == 0) return reader_sleep(&r->base);
    size_t n = left < max_bytes ? left : max_bytes;
    memcpy(out, r->message + r->sent_bytes, n);
    r->sent_bytes += n;
    return (ssize_t)n;
}

static void free_reader(void *ctx)
{
    struct pixel_reader *r = ctx;
    reader_leave(&r->base);
    pixel_blocks_fini(&r->dirty);
    image_destroy(&r->still);
    free(r);
}

static struct pixel_reader *reader_create(const struct pixels_wish *wish)
{
    size_t bytes = strlen(wish->layer) + 1;
    struct pixel_reader *r = bytes <= sizeof r->layer ? calloc(1, sizeof *r) : NULL;
    if (!r) return NULL;
    memcpy(r->layer, wish->layer, bytes);
    r->format = wish->format;
    r->has = wish->after;
    return r;
}

static struct MHD_Response *response_of(struct pixel_reader *r)
{
    return MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, PIXELS_MESSAGE_BYTES, read_pixels, r,
                                             free_reader);
}

struct MHD_Response *stream_pixels_response(struct streams *s, const char *job,
                                            struct MHD_Connection *connection,
                                            const struct pixels_wish *wish)
{
    struct stream *stream = streams_obtain(s, job);
    struct pixel_reader *r = stream ? reader_create(wish) : NULL;
    struct MHD_Response *response = r ? response_of(r) : NULL;
    if (!response) {
        free(r);
        return NULL;
    }
    reader_join(&r->base, s, stream, &stream->pixel_readers, connection);
    return response;
}

struct MHD_Response *stream_still_response(struct streams *s, struct MHD_Connection *connection,
                                           struct image *image, const struct pixels_wish *wish)
{
    struct pixel_reader *r = reader_create(wish);
    struct MHD_Response *response = NULL;
    if (r && pixel_blocks_init(&r->dirty, image->width_px, image->height_px) == 0)
        response = response_of(r);
    if (!response) {
        if (r) pixel_blocks_fini(&r->dirty);
        free(r);
        image_destroy(&image);
        return NULL;
    }
    r->still = image;
    put_size(r, image, 0);
    pixel_blocks_mark(&r->dirty, (struct rect){0, 0, image->width_px, image->height_px});
    reader_join(&r->base, s, NULL, &s->detached, connection);
    return response;
}
