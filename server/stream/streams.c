#include "server/stream/streams.h"

#include <stdlib.h>
#include <string.h>

#include "proto/runtime/clock.h"

#define BEAT_MS     15000u
#define PEEK_MS     2000u
#define PROGRESS_MS 100u /* readers are woken for progress at most this often */

static uint64_t now_ms(void)
{
    return clock_us(CLOCK_MONOTONIC) / 1000;
}

/* Milliseconds of the wall clock tell one life of the coordinator from the next. */
static uint64_t wall_ms(void)
{
    return clock_us(CLOCK_REALTIME) / 1000;
}

int streams_create(struct streams **out)
{
    struct streams *s = calloc(1, sizeof *s);
    if (!s) return ERR_MEMORY;
    s->epoch = (uint32_t)wall_ms();
    s->now_ms = s->beat_ms = s->peek_ms = now_ms();
    s->stuck_ms = UINT64_MAX;
    s->cache_budget.shared_max_bytes = LIMIT_SHARED_PIXELS_BYTES;
    s->cache_budget.most_bytes = LIMIT_PIXELS_BYTES;
    *out = s;
    return 0;
}

static struct stream **bucket_of(struct streams *s, const char *job)
{
    uint32_t hash = 2166136261u; /* FNV-1a */
    for (; *job; job++) hash = (hash ^ (unsigned char)*job) * 16777619u;
    return &s->bucket[hash % STREAM_BUCKETS];
}

struct stream *streams_find(struct streams *s, const char *job)
{
    struct stream *stream = *bucket_of(s, job);
    while (stream && strcmp(stream->job, job) != 0) stream = stream->next;
    return stream;
}

struct stream *streams_obtain(struct streams *s, const char *job)
{
    struct stream *stream = streams_find(s, job), **bucket = bucket_of(s, job);
    if (stream || strlen(job) >= STREAM_JOB_BYTES) return stream;
    stream = calloc(1, sizeof *stream);
    if (!stream) return NULL;
    memcpy(stream->job, job, strlen(job) + 1);
    stream->streams = s;
    event_ring_init(&stream->ring, s->epoch);
    /* Revisions begin above all that an earlier life gave out: pixels change less than a million
     * times a millisecond. */
    stream->revision = wall_ms() << 20;
    stream->next = *bucket;
    *bucket = stream;
    return stream;
}

/* Readers whose stream goes are kept in a list of their own until MHD lets go of them. */
static void detach_all(struct streams *s, struct reader **list)
{
    while (*list) {
        struct reader *r = *list;
        *list = r->next;
        if (r->next) r->next->link = list;
        r->stream = NULL;
        r->next = s->detached;
        r->link = &s->detached;
        if (r->next) r->next->link = &r->next;
        s->detached = r;
        reader_wake(r);
    }
}

static void stream_destroy(struct stream *stream)
{
    struct streams *s = stream->streams;
    struct stream **at = bucket_of(s, stream->job);
    while (*at != stream) at = &(*at)->next;
    *at = stream->next;
    stream_set_in_work(stream, false);
    pixel_readers_orphan(stream);
    detach_all(s, &stream->event_readers);
    detach_all(s, &stream->pixel_readers);
    event_ring_fini(&stream->ring);
    pixel_changes_fini(&stream->changes);
    free(stream);
}

void stream_settle(struct stream *stream)
{
    if (stream->final && !stream->event_readers && !stream->pixel_readers) stream_destroy(stream);
}

void streams_destroy(struct streams **streams)
{
    struct streams *s = *streams;
    if (!s) return;
    for (uint32_t i = 0; i < STREAM_BUCKETS; i++)
        while (s->bucket[i]) stream_destroy(s->bucket[i]);
    while (s->detached) {
        struct reader *r = s->detached;
        s->detached = r->next;
        r->streams = NULL;
        r->next = NULL;
        r->link = NULL;
    }
    free(s);
    *streams = NULL;
}

void streams_set_told_cut(struct streams *s,
                          void (*told)(void *ctx, enum reader_kind kind, const char *job))
{
    s->told_cut = told;
}

void streams_set_kick(struct streams *s, void (*kick)(void *ctx), void *ctx)
{
    s->kick = kick;
    s->kick_ctx = ctx;
}

void streams_kick(struct streams *s)
{
    if (s->kick) s->kick(s->kick_ctx);
}

static void end_readers(struct reader *list)
{
    for (struct reader *r = list; r; r = r->next) {
        r->ending = true;
        reader_wake(r);
    }
}

void streams_end_all(struct streams *s)
{
    for (uint32_t i = 0; i < STREAM_BUCKETS; i++)
        for (struct stream *stream = s->bucket[i]; stream; stream = stream->next) {
            end_readers(stream->event_readers);
            end_readers(stream->pixel_readers);
        }
    end_readers(s->detached);
    streams_kick(s);
}

/* Progress and tiles wake readers ten times a second at most, and not while events owe time (the
 * more readers there are the more they cost); what waits is told by the tick. */
static bool may_wake(struct stream *stream, const char *name)
{
    if (strcmp(name, "progress") != 0 && strcmp(name, "tile") != 0) return true;
    const uint64_t now = now_ms();
    stream->progress_waits =
        now - stream->progress_ms < PROGRESS_MS || !streams_may_tell(stream->streams);
    if (!stream->progress_waits) stream->progress_ms = now;
    return !stream->progress_waits;
}

void stream_event(struct streams *s, const char *job, const char *name, json_t *data, bool final)
{
    struct stream *stream = streams_obtain(s, job);
    if (!stream) return; /* out of memory: readers find out from the job's state */
    const enum cpu_meter_kind was = cpu_meter_switch(&s->meter, CPU_METER_EVENTS);
    (void)event_ring_push(&stream->ring, name, data); /* a failure counts as lost there */
    stream->final |= final;
    if (may_wake(stream, name) || final) readers_wake(stream->event_readers);
    if (final) {
        stream_set_in_work(stream, false);
        readers_wake(stream->pixel_readers);
    }
    stream_settle(stream);
    (void)cpu_meter_switch(&s->meter, was);
    streams_kick(s);
}

static void mark_all(struct stream *stream)
{
    const struct pixel_changes *c = &stream->changes;
    struct rect all = {0, 0, c->width_px, c->height_px};
    pixel_changes_mark(&stream->changes, all, stream->revision);
}

/* What readers lack of an image that goes is kept for them, but for views: nothing of one may come
 * when the next has begun. */
static void let_go_of_image(struct stream *stream, bool follows)
{
    if (!follows && !stream->image) return;
    if (!follows && stream->view.number == 0 && stream->pixel_readers) {
        pixel_readers_keep(stream);
        return;
    }
    for (struct block_cache *cache = stream->caches; cache; cache = cache->next)
        block_cache_clear(cache);
    pixel_changes_fini(&stream->changes);
    stream->kept = false;
}

static struct stream *set_image(struct streams *s, const char *job, const struct image *image)
{
    struct stream *stream = image ? streams_obtain(s, job) : streams_find(s, job);
    if (!stream) return NULL;
    const enum cpu_meter_kind was = cpu_meter_switch(&s->meter, CPU_METER_PIXELS);
    let_go_of_image(stream, image != NULL);
    if (image && pixel_changes_init(&stream->changes, image->width_px, image->height_px) != 0)
        image = NULL; /* out of memory: no feed, but the frame goes on */
    stream_set_in_work(stream, !stream->final && (image || stream->kept));
    stream->image = image;
    stream->view = (struct stream_view){0};
    stream->revision++;
    (void)cpu_meter_switch(&s->meter, was);
    return stream;
}

static void tell_image(struct stream *stream)
{
    stream->generation += !stream->kept; /* readers go on with the same */
    readers_wake(stream->pixel_readers);
    streams_kick(stream->streams);
}

void stream_image(struct streams *s, const char *job, const struct image *image)
{
    struct stream *stream = set_image(s, job, image);
    if (!stream) return;
    /* Of the first image readers have nothing. A later one may have been drawn while another was
     * seen, and must leave nothing of that one in sight. */
    if (stream->image && stream->generation > 0) mark_all(stream);
    tell_image(stream);
}

void stream_view(struct streams *s, const char *job, const struct image *image,
                 const struct stream_view *view)
{
    struct stream *stream = set_image(s, job, image);
    if (!stream) return;
    stream->view = *view;
    tell_image(stream);
}

void stream_pixels(struct streams *s, const char *job, struct rect changed)
{
    struct stream *stream = streams_find(s, job);
    if (!stream || !stream->image) return;
    const enum cpu_meter_kind was = cpu_meter_switch(&s->meter, CPU_METER_PIXELS);
    stream->revision++;
    pixel_changes_mark(&stream->changes, changed, stream->revision);
    for (struct reader *r = stream->pixel_readers; r; r = r->next) {
        pixel_reader_mark(r, changed);
        if (!r->waits) reader_wake(r);
    }
    (void)cpu_meter_switch(&s->meter, was);
    streams_kick(s);
}

void stream_forget(struct streams *s, const char *job)
{
    struct stream *stream = streams_find(s, job);
    if (stream) stream_destroy(stream);
    streams_kick(s);
}

static void tick_readers(struct streams *s, struct reader *list, bool beat, bool peek)
{
    const enum cpu_meter_kind kind =
        list && list->kind == READER_PIXELS ? CPU_METER_PIXELS : CPU_METER_EVENTS;
    const enum cpu_meter_kind was = list ? cpu_meter_switch(&s->meter, kind) : CPU_METER_NONE;
    for (struct reader *r = list; r; r = r->next) {
        if (reader_is_stuck(r, s->now_ms, s->stuck_ms)) reader_cut(r);
        if (!r->suspended) continue;
        r->ending |= peek && reader_is_gone(r);
        r->beat |= beat;
        if (beat || r->ending) reader_wake(r);
    }
    if (list) (void)cpu_meter_switch(&s->meter, was);
}

void streams_tick(struct streams *s)
{
    const uint64_t now = s->now_ms = now_ms();
    const bool beat = now - s->beat_ms >= BEAT_MS, peek = now - s->peek_ms >= PEEK_MS;
    if (beat) s->beat_ms = now;
    if (peek) s->peek_ms = now;
    for (uint32_t i = 0; s->readers > 0 && i < STREAM_BUCKETS; i++)
        for (struct stream *stream = s->bucket[i]; stream; stream = stream->next) {
            tick_readers(s, stream->event_readers, beat, peek);
            tick_readers(s, stream->pixel_readers, beat, peek);
            if (stream->progress_waits && streams_may_tell(s)) {
                stream->progress_waits = false;
                stream->progress_ms = now;
                readers_wake(stream->event_readers);
            }
        }
    tick_readers(s, s->detached, false, false);
    if (s->readers > 0) streams_kick(s);
}

void streams_totals(struct streams *s, struct streams_totals *out)
{
    *out = (struct streams_totals){.readers = s->readers,
                                   .cut_events = s->cut[READER_EVENTS],
                                   .cut_pixels = s->cut[READER_PIXELS],
                                   .pixel_bytes = s->pixel_bytes,
                                   .blocks_made = s->blocks_made,
                                   .blocks_sent = s->blocks_sent,
                                   .kept_bytes = s->cache_budget.kept_bytes,
                                   .waits = s->rate_limit.waits,
                                   .tells_late = s->tells_late,
                                   .events_cpu_us = cpu_meter_us(&s->meter, CPU_METER_EVENTS),
                                   .pixels_cpu_us = cpu_meter_us(&s->meter, CPU_METER_PIXELS)};
}

uint64_t streams_event_id(const struct streams *s, const char *text)
{
    return event_id_read(s->epoch, text);
}
