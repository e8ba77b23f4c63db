/* Tiles that an earlier run of the coordinator had: read from the frame's spool in place of being
 * traced, and kept there as they land.
 *
 * A result is used again only for the very pass that it was traced for, of a frame whose plan,
 * build, instruction set and Embree are the same (the fingerprint), with its checksum; then it is
 * unpacked and checked as when it came. So it is what a worker would send again, to the last bit,
 * and whatever else is decided on from what has landed (rounds, second sets) comes out as before.
 * Anything else in the spool is passed over. */
#include <stdlib.h>
#include <string.h>

#include "proto/link/wire_frame.h"
#include "proto/runtime/build.h"
#include "server/job/frame/frame_work.h"

/* Results that are read at a time: as many as keep a pool busy. */
#define READING_MAX 8

void frame_spool_destroy(struct frame *f)
{
    spool_close(&f->spool.spool);
    free(f->spool.taken);
}

/* -- what is in there -- */

static struct spool_key key_of(const struct frame *f, uint32_t tile, const struct plan_pass *pass)
{
    struct spool_key key = {.tile = tile,
                            .pass = pass->number,
                            .first = pass->first,
                            .count = pass->count,
                            .strata = pass->strata};
    const size_t area = (size_t)rect_area(tile_grid_rect(&f->grid, tile));
    if (pass->strata_map)
        key.strata_crc = wire_frame_crc32c(0, pass->strata_map, area * f->adaptive.maps);
    return key;
}

static const struct spool_record *record_of(const struct frame *f, uint32_t tile, uint32_t number)
{
    const struct plan_pass pass = frame_pass(f, tile, number);
    const struct spool_key key = key_of(f, tile, &pass);
    return spool_find(f->spool.spool, &key);
}

static bool is_there(void *ctx, uint32_t tile)
{
    const struct frame *f = ctx;
    return record_of(f, tile, tile_queue_pass(f->tiles, tile)) != NULL;
}

bool frame_spool_has_next(const struct frame *f, uint32_t tile)
{
    const uint32_t next = tile_queue_pass(f->tiles, tile) + 1;
    if (f->spool.taken == NULL || next >= tile_queue_passes(f->tiles, tile)) return false;
    return record_of(f, tile, next) != NULL;
}

/* -- reading -- */

struct read_task {
    struct pool_task task;
    struct frame *frame;
    uint32_t tile;
    struct plan_pass pass;
    struct rect rect;
    const struct spool_record *record; /* borrowed from the spool, which is open meanwhile */
    struct counters counters;
    struct samples *samples; /* owned until landed */
    int error;
};

/* Counters lie in a record as they do in memory: the fingerprint has the build. */
static int unpack(struct read_task *t, const uint8_t *payload)
{
    struct fault fault;
    const size_t front_bytes = sizeof t->counters, all_bytes = t->record->payload_bytes;
    if (all_bytes < front_bytes) return ERR_TRUNCATED;
    memcpy(&t->counters, payload, front_bytes);
    return samples_unpack(payload + front_bytes, all_bytes - front_bytes, &t->frame->plan,
                          t->pass.number, rect_width(t->rect), rect_height(t->rect), &t->samples,
                          &fault);
}

static void read_run(struct pool_task *task)
{
    struct read_task *t = (struct read_task *)task;
    if (atomic_load(&t->frame->dropped)) return;
    uint8_t *payload = malloc(t->record->payload_bytes + 1);
    t->error = payload ? spool_read(t->frame->spool.spool, t->record, payload) : ERR_MEMORY;
    if (!t->error) t->error = unpack(t, payload);
    free(payload);
}

/* It was counted when it landed first, in this run of the coordinator. */
static bool is_counted(const struct frame *f, const struct read_task *t)
{
    if (f->options.recalled) return true;
    return f->options.counted && t->pass.number < f->options.counted[t->tile];
}

/* False when the frame has failed, and may be gone. */
static bool read_over(struct frame *f, struct read_task *t)
{
    f->spool.reading--;
    f->statistics.decode_cpu_us += t->task.cpu_us;
    if (t->error) {
        tile_queue_give_up(f->tiles, t->tile);
        return true;
    }
    f->arrived_us = frame_clock_us();
    const struct counters *fresh = is_counted(f, t) ? NULL : &t->counters;
    if (frame_land(f, t->tile, &t->pass, &t->samples, fresh) != 0) return false;
    f->statistics.tiles_resumed++;
    if (fresh) counters_add(&f->statistics.counters_resumed, fresh);
    return true;
}

static void read_done(struct pool_task *task)
{
    struct read_task *t = (struct read_task *)task;
    struct frame *f = t->frame;
    if (frame_task_over(f)) {
        f->tasks++; /* held: the owner may drop the frame */
        const bool goes_on = read_over(f, t);
        const bool complete = goes_on && tile_queue_complete(f->tiles) && !frame_has_rounds(f);
        if (complete)
            f->options.events.traced(f->options.events.ctx, f);
        else if (goes_on)
            f->options.events.extended(f->options.events.ctx, f);
        if (frame_task_over(f)) frame_spool_feed(f);
    }
    samples_destroy(&t->samples);
    free(t);
}

static bool read_tile(struct frame *f, uint32_t tile)
{
    struct read_task *t = calloc(1, sizeof *t);
    if (!t) return false;
    const uint32_t number = tile_queue_pass(f->tiles, tile);
    *t = (struct read_task){.task = {.run = read_run, .done = read_done},
                            .frame = f,
                            .tile = tile,
                            .pass = frame_pass(f, tile, number),
                            .rect = tile_grid_rect(&f->grid, tile),
                            .record = record_of(f, tile, number)};
    f->spool.reading++;
    frame_task_submit(f, &t->task);
    return true;
}

void frame_spool_feed(struct frame *f)
{
    struct frame_spool *s = &f->spool;
    while (s->taken_count > 0 && s->reading < READING_MAX && !frame_is_behind(f)) {
        const uint32_t tile = s->taken[--s->taken_count];
        if (read_tile(f, tile)) continue;
        tile_queue_give_up(f->tiles, tile);
        f->held = true; /* workers that got no tile are told with the next block */
    }
}

void frame_spool_push(struct frame *f, uint32_t tile)
{
    f->spool.taken[f->spool.taken_count++] = tile;
}

void frame_spool_take(struct frame *f)
{
    struct frame_spool *s = &f->spool;
    if (!s->taken) return;
    const uint32_t count = tile_queue_take(f->tiles, is_there, f, s->taken + s->taken_count);
    /* The last of them goes first: so that a tile goes on with its next pass before others begin.
     */
    for (uint32_t i = 0, end = count; i + 1 < end; i++, end--) {
        uint32_t *list = s->taken + s->taken_count, tile = list[i];
        list[i] = list[end - 1];
        list[end - 1] = tile;
    }
    s->taken_count += count;
    frame_spool_feed(f);
}

/* -- opening -- */

static void on_opened(void *ctx, struct spool *spool)
{
    struct frame *f = ctx;
    f->spool.spool = spool;
    if (!frame_task_over(f)) return;
    f->spool.state = FRAME_SPOOL_READY;
    if (spool && spool_count(spool) > 0)
        f->spool.taken = calloc(tile_grid_count(&f->grid), sizeof *f->spool.taken);
    frame_spool_take(f);
    f->options.events.extended(f->options.events.ctx, f);
}

static int hash_text(struct digest_state *state, const char *text)
{
    return digest_update(state, text, strlen(text) + 1);
}

static int fingerprint(const struct frame *f, const char *embree, struct digest *out)
{
    struct digest_state *state = digest_begin();
    if (!state) return ERR_MEMORY;
    int error = hash_text(state, build_id());
    if (!error) error = hash_text(state, build_isa() ? build_isa() : "");
    if (!error) error = hash_text(state, embree);
    if (!error) error = digest_update(state, f->plan_bytes.data, f->plan_bytes.size_bytes);
    digest_finish(&state, out);
    return error;
}

bool frame_take_up(struct frame *f, const char *embree)
{
    struct digest digest;
    const struct frame_options *o = &f->options;
    if (!o->spools || f->spool.state == FRAME_SPOOL_READY) return true;
    if (f->spool.state == FRAME_SPOOL_OPENING) return false;
    f->spool.state = FRAME_SPOOL_OPENING;
    if (fingerprint(f, embree, &digest) != 0 ||
        spool_open(o->spools, o->job, o->number, &digest, on_opened, f) != 0) {
        f->spool.state = FRAME_SPOOL_READY; /* without one */
        return true;
    }
    f->tasks++;
    return false;
}

void frame_spool_keep(struct frame *f, uint32_t tile, const struct plan_pass *pass,
                      const struct counters *counters, uint8_t **bytes, uint32_t size_bytes)
{
    if (!f->spool.spool) return;
    const struct spool_key key = key_of(f, tile, pass);
    spool_append(f->spool.spool, &key, counters, sizeof *counters, *bytes, size_bytes);
    *bytes = NULL;
}
