/* A reader of the pixel feed as an MHD response: a header and at most one block in hand. */
#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>

#include "server/stream/streams.h"

struct pixel_reader {
    struct reader base;
    struct block_cache *cache; /* of its layer and format; its stream's, or `own` */
    struct block_cache *own;   /* of an image without a stream */
    struct pixel_blocks dirty;
    struct image *still; /* owned; an image without a stream */
    uint64_t generation; /* of the image that the reader was told about; 0: none */
    uint64_t has;        /* it has every change up to this revision */
    uint64_t sweep;      /* the revision when its walk over the blocks began anew */
    uint64_t told;       /* that it has, by the last message */
    uint8_t header[2 * PIXELS_HEADER_BYTES]; /* of its own: a block's, or messages without one */
    size_t header_bytes, sent_bytes;
    struct pixel_block *block; /* being sent, behind the header; NULL: none */
};

static struct pixel_reader *reader_of(struct reader *reader)
{
    return (struct pixel_reader *)reader; /* base is its first member */
}

void pixel_reader_mark(struct reader *reader, struct rect changed)
{
    struct pixel_reader *r = reader_of(reader);
    if (r->generation == reader->stream->generation) pixel_blocks_mark(&r->dirty, changed);
}

/* ---- messages ---- */

static void put_size(struct pixel_reader *r, int32_t width_px, int32_t height_px, uint64_t revision)
{
    pixels_write_size(r->header, width_px, height_px, revision);
    r->header_bytes = PIXELS_HEADER_BYTES;
    r->told = revision;
}

/* Writes the number of the view before the image's size. */
static void put_view(struct pixel_reader *r, const struct stream_view *view)
{
    memmove(r->header + PIXELS_HEADER_BYTES, r->header, PIXELS_HEADER_BYTES);
    pixels_write_view(r->header, view->number, view->width_px, view->height_px, r->told);
    r->header_bytes += PIXELS_HEADER_BYTES;
}

/* Takes the block, NULL when there is none: then the feed ends. */
static bool put_block(struct pixel_reader *r, struct pixel_block *block)
{
    if (!block) return false;
    r->block = block;
    memcpy(r->header, block->bytes, PIXELS_HEADER_BYTES);
    pixels_set_revision(r->header, r->has);
    r->header_bytes = PIXELS_HEADER_BYTES;
    r->told = r->has;
    return true;
}

/* ---- which comes next ---- */

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
    put_size(r, stream->image->width_px, stream->image->height_px, r->has);
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
    struct rect rect;
    if (r->base.ending || !pixel_blocks_take(&r->dirty, &rect)) return false;
    r->has = r->dirty.count == 0 ? PIXELS_STILL_REVISION : 0;
    return put_block(r, pixel_block_create(r->still, r->cache->layer, r->cache->format, rect));
}

/* Gives the rest of a turn back when there is nothing to send. */
static void give_back_turn(struct pixel_reader *r)
{
    if (r->base.turn_bytes > 0) rate_limit_return(&r->base.streams->rate_limit, r->base.turn_bytes);
    r->base.turn_bytes = 0;
}

/* Returns whether the reader has its turn. If not, it is put in line for one. */
static bool has_turn(struct pixel_reader *r)
{
    struct rate_limit *limit = &r->base.streams->rate_limit;
    if (r->base.turn_bytes > 0 || !rate_limit_is_on(limit)) return true;
    streams_settle_when_due(r->base.streams);
    return !r->base.waits && rate_limit_ask(limit, &r->base, streams_clock_us());
}

static bool next_block(struct pixel_reader *r, struct rect rect)
{
    struct stream *stream = r->base.stream;
    struct streams *streams = stream->streams;
    const uint64_t made = r->cache->made;
    struct pixel_block *block = block_cache_block(r->cache, stream->image, &stream->changes, rect);
    streams->blocks_made += r->cache->made - made;
    if (!put_block(r, block)) return false;
    if (rate_limit_is_on(&streams->rate_limit)) r->base.turn_bytes -= (int64_t)block->size_bytes;
    streams->blocks_sent++;
    return true;
}

/* Prepares the next message of a picture; nothing when there is nothing to say now. */
static bool next_of_picture(struct pixel_reader *r)
{
    const struct stream *stream = r->base.stream;
    struct rect rect;
    const bool waits = r->dirty.count > 0 && !has_turn(r);
    if (!waits && take_block(r, &rect)) return next_block(r, rect);
    if (!waits) give_back_turn(r);
    /* A sign of life needs no turn. */
    if (r->base.beat || (!waits && r->told != r->has)) {
        put_size(r, stream->changes.width_px, stream->changes.height_px, r->has);
        r->base.beat = false;
        return true;
    }
    return waits || !stream->final;
}

/* Prepares the next message. False when the feed ends; no bytes when there is nothing to say now.
 */
static bool next_message(struct pixel_reader *r)
{
    const struct stream *stream = r->base.stream;
    pixel_block_unref(&r->block);
    r->header_bytes = r->sent_bytes = 0;
    if (r->still) return next_of_still(r);
    if (!stream || r->base.ending) return false;
    if (stream->image && r->generation != stream->generation) return announce(r);
    if (stream->image || (stream->kept && r->generation == stream->generation))
        return next_of_picture(r);
    return !stream->final;
}

static size_t message_bytes(const struct pixel_reader *r)
{
    return r->header_bytes + (r->block ? r->block->size_bytes - PIXELS_HEADER_BYTES : 0);
}

/* The next bytes of the message: of the header, or of the block behind it. */
static size_t copy_out(struct pixel_reader *r, char *out, size_t max_bytes)
{
    size_t done = 0;
    if (r->sent_bytes < r->header_bytes) {
        done = r->header_bytes - r->sent_bytes;
        if (done > max_bytes) done = max_bytes;
        memcpy(out, r->header + r->sent_bytes, done);
    }
    const size_t left = message_bytes(r) - r->sent_bytes - done;
    const size_t more = left < max_bytes - done ? left : max_bytes - done;
    if (more > 0 && r->block) memcpy(out + done, r->block->bytes + r->sent_bytes + done, more);
    r->sent_bytes += done + more;
    return done + more;
}

static ssize_t read_pixels(void *ctx, uint64_t position, char *out, size_t max_bytes)
{
    struct pixel_reader *r = ctx;
    (void)position;
    if (r->base.streams) (void)cpu_meter_switch(&r->base.streams->meter, CPU_METER_PIXELS);
    if (r->sent_bytes == message_bytes(r) && !next_message(r))
        return MHD_CONTENT_READER_END_OF_STREAM;
    if (r->sent_bytes == message_bytes(r)) return reader_sleep(&r->base);
    const size_t n = copy_out(r, out, max_bytes);
    reader_moved(&r->base);
    if (r->base.streams) r->base.streams->pixel_bytes += n;
    return reader_gives(&r->base, n);
}

/* ---- what outlasts the image ---- */

/* All that readers of the cache lack. */
static int find_wanted(const struct stream *stream, const struct block_cache *cache,
                       struct pixel_blocks *wanted)
{
    int error = pixel_blocks_init(wanted, stream->changes.width_px, stream->changes.height_px);
    for (struct reader *reader = stream->pixel_readers; !error && reader; reader = reader->next) {
        const struct pixel_reader *r = reader_of(reader);
        if (r->cache == cache && r->generation == stream->generation)
            pixel_blocks_add(wanted, &r->dirty);
    }
    return error;
}

void pixel_readers_keep(struct stream *stream)
{
    size_t room = LIMIT_KEPT_PIXELS_BYTES;
    for (struct block_cache *cache = stream->caches; cache; cache = cache->next) {
        struct pixel_blocks wanted;
        int error = find_wanted(stream, cache, &wanted);
        if (!error)
            error = block_cache_keep(cache, stream->image, &stream->changes, &wanted, &room);
        /* Without them its readers end, and ask for the picture's file. */
        if (error) block_cache_clear(cache);
        pixel_blocks_fini(&wanted);
    }
    stream->kept = true;
}

/* ---- its life ---- */

void pixel_readers_orphan(struct stream *stream)
{
    for (struct reader *reader = stream->pixel_readers; reader; reader = reader->next)
        block_cache_leave(&stream->caches, &reader_of(reader)->cache);
}

static void free_reader(void *ctx)
{
    struct pixel_reader *r = ctx;
    struct stream *stream = r->base.stream;
    if (r->base.streams) give_back_turn(r);
    pixel_block_unref(&r->block);
    block_cache_leave(stream ? &stream->caches : &r->own, &r->cache);
    reader_leave(&r->base);
    pixel_blocks_fini(&r->dirty);
    image_destroy(&r->still);
    free(r);
}

static struct pixel_reader *reader_create(struct streams *s, struct block_cache **caches,
                                          const struct pixels_request *wanted)
{
    struct pixel_reader *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    r->base.kind = READER_PIXELS;
    r->has = wanted->after;
    r->cache = block_cache_join(caches ? caches : &r->own, &s->cache_budget, wanted->layer,
                                wanted->format);
    if (r->cache) return r;
    free(r);
    return NULL;
}

static struct MHD_Response *response_of(struct pixel_reader *r)
{
    return MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, PIXELS_MESSAGE_BYTES, read_pixels, r,
                                             free_reader);
}

struct MHD_Response *stream_pixels_response(struct streams *s, const char *job,
                                            struct MHD_Connection *connection,
                                            const struct pixels_request *wanted)
{
    struct stream *stream = streams_obtain(s, job);
    struct pixel_reader *r = stream ? reader_create(s, &stream->caches, wanted) : NULL;
    struct MHD_Response *response = r ? response_of(r) : NULL;
    if (!response) {
        if (r) block_cache_leave(&stream->caches, &r->cache);
        free(r);
        return NULL;
    }
    reader_join(&r->base, s, stream, &stream->pixel_readers, connection);
    return response;
}

struct MHD_Response *stream_still_response(struct streams *s, struct MHD_Connection *connection,
                                           struct image *image, const struct pixels_request *wanted)
{
    struct pixel_reader *r = reader_create(s, NULL, wanted);
    struct MHD_Response *response = NULL;
    if (r && pixel_blocks_init(&r->dirty, image->width_px, image->height_px) == 0)
        response = response_of(r);
    if (!response) {
        if (r) {
            pixel_blocks_fini(&r->dirty);
            block_cache_leave(&r->own, &r->cache);
        }
        free(r);
        image_destroy(&image);
        return NULL;
    }
    r->still = image;
    put_size(r, image->width_px, image->height_px, 0);
    pixel_blocks_mark(&r->dirty, (struct rect){0, 0, image->width_px, image->height_px});
    reader_join(&r->base, s, NULL, &s->detached, connection);
    return response;
}
