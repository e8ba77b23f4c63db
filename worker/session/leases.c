#include "worker/session/leases.h"

#include <stddef.h>
#include <stdlib.h>

#include "worker/session/leases_work.h"

/* ---- lists ---- */

struct leased_frame *leases_find_frame(const struct leases *leases, uint64_t id)
{
    for (struct leased_frame *f = leases->frames; f; f = f->next)
        if (f->id == id && !f->gone) return f;
    return NULL;
}

static void free_frame(struct leases *leases, struct leased_frame *f)
{
    struct leased_frame **at = &leases->frames;
    while (*at != f) at = &(*at)->next;
    *at = f->next;
    frame_blobs_release(&f->blobs, leases->cache);
    free(f);
}

void leases_append(struct leases *leases, struct leased_tile *t)
{
    t->previous = leases->last;
    if (leases->last)
        leases->last->next = t;
    else
        leases->first = t;
    leases->last = t;
}

static void unlink_tile(struct leases *leases, struct leased_tile *t)
{
    if (t->previous)
        t->previous->next = t->next;
    else
        leases->first = t->next;
    if (t->next)
        t->next->previous = t->previous;
    else
        leases->last = t->previous;
}

/* Frees a tile that no thread has. */
static void free_tile(struct leases *leases, struct leased_tile *t)
{
    struct leased_frame *f = t->frame;
    unlink_tile(leases, t);
    bytes_writer_fini(&t->packed);
    shared_buffer_unref(&t->samples);
    free(t->strata_maps);
    free(t);
    if (--f->tiles == 0 && f->gone) free_frame(leases, f);
}

/* ---- counts: a tile is open, kept, or neither; blobs are held while tiles are open ---- */

static void leave_open(struct leases *leases, struct leased_tile *t)
{
    struct leased_frame *f = t->frame;
    leases->counts.open--;
    if (--f->open > 0) return;
    frame_blobs_release(&f->blobs, leases->cache);
}

/* ---- tracing ---- */

static struct leased_tile *tile_of(struct pool_task *task)
{
    return (struct leased_tile *)((char *)task - offsetof(struct leased_tile, task));
}

static void run_tile(struct pool_task *task)
{
    struct leased_tile *t = tile_of(task);
    struct leases *leases = t->leases;
    t->error = leases->tracing->trace(leases->tracing->ctx, task->tool, &t->job, &t->packed);
}

static void send_result(struct leases *leases, const struct leased_tile *t)
{
    struct lease_result result = {.request_id = t->request_id,
                                  .message = {.frame_id = t->lease.frame_id,
                                              .index = t->lease.index,
                                              .generation = t->lease.generation,
                                              .counters = t->counters},
                                  .samples = t->samples};
    leases->client.result(leases->client.ctx, &result);
}

static void note(struct leases *leases, const struct leased_tile *t, enum log_level level,
                 const char *what, const char *detail)
{
    const struct worker_log_lease lease = {.job = t->frame->job,
                                           .trace = &t->frame->trace,
                                           .frame_id = t->lease.frame_id,
                                           .tile = t->lease.index,
                                           .generation = t->lease.generation};
    worker_log_write_lease(leases->client.worker_log, level, what, &lease, detail);
}

/* Tells the coordinator that the tile cannot be rendered, and forgets it. */
static void give_up(struct leases *leases, struct leased_tile *t, int code, const char *place,
                    const char *detail)
{
    struct message_tile_fault m = {.frame_id = t->lease.frame_id,
                                   .index = t->lease.index,
                                   .generation = t->lease.generation,
                                   .code = code};
    struct fault text;
    fault_set(&text, code, "", "%s%s%s", place, place[0] ? ": " : "", detail);
    for (size_t i = 0; i < sizeof m.text && i < sizeof text.detail; i++) m.text[i] = text.detail[i];
    m.text[sizeof m.text - 1] = '\0';
    note(leases, t, LOG_WARNING, "tile cannot be traced", m.text);
    leases->client.faulted(leases->client.ctx, t->request_id, &m);
    leave_open(leases, t);
    free_tile(leases, t);
}

static void done_tile(struct pool_task *task)
{
    struct leased_tile *t = tile_of(task);
    struct leases *leases = t->leases;
    if (t->state == TILE_DROPPED) {
        leave_open(leases, t);
        free_tile(leases, t);
        leases->client.moved(leases->client.ctx);
        return;
    }
    if (t->error == 0) {
        t->samples = shared_buffer_take(&t->packed);
        if (!t->samples) t->error = ERR_MEMORY;
    }
    if (t->error) {
        give_up(leases, t, t->error, "tile", error_text(t->error));
    } else {
        /* What loading cost is told once, with the first result after it. */
        frame_blobs_take_costs(&t->frame->blobs, &t->counters);
        t->state = TILE_DONE;
        leave_open(leases, t);
        leases->counts.kept++;
        send_result(leases, t);
    }
    leases->client.moved(leases->client.ctx);
}

static void queue_tile(struct leases *leases, struct leased_tile *t)
{
    t->state = TILE_QUEUED;
    t->job = (struct tracing_job){.plan = &t->frame->plan,
                                  .pass = &t->lease.pass,
                                  .rect = t->lease.rect,
                                  .progress = &leases->rows,
                                  .stop = &t->stop,
                                  .packing = leases->packing,
                                  .counters = &t->counters};
    frame_blobs_loaded(&t->frame->blobs, &t->job);
    t->task = (struct pool_task){.run = run_tile, .done = done_tile};
    thread_pool_submit(leases->pool, &t->task);
}

void leases_go_on(struct leases *leases, struct leased_tile *t)
{
    struct fault fault = {0};
    const enum blob_state state = frame_blobs_state(&t->frame->blobs, &fault);
    if (state == BLOB_READY)
        queue_tile(leases, t);
    else if (state == BLOB_FAILED)
        give_up(leases, t, fault.code, fault.pointer, fault.detail);
}

void leases_blob_settled(struct leases *leases, struct cached_blob *blob)
{
    for (struct leased_tile *t = leases->first, *next; t; t = next) {
        next = t->next;
        if (t->state != TILE_WAITING) continue;
        if (frame_blobs_have(&t->frame->blobs, blob)) leases_go_on(leases, t);
    }
    leases->client.moved(leases->client.ctx);
}

/* ---- the coordinator's messages ---- */

int leases_create(struct thread_pool *pool, struct blob_cache *cache, const struct tracing *tracing,
                  enum packing packing, const struct leases_client *client, struct leases **out)
{
    struct leases *leases = calloc(1, sizeof *leases);
    if (!leases) return ERR_MEMORY;
    leases->pool = pool;
    leases->cache = cache;
    leases->tracing = tracing;
    leases->packing = packing;
    leases->client = *client;
    *out = leases;
    return 0;
}

void leases_destroy(struct leases **leases)
{
    struct leases *h = *leases;
    *leases = NULL;
    if (!h) return;
    for (struct leased_tile *t = h->first, *next; t; t = next) {
        next = t->next;
        free_tile(h, t);
    }
    while (h->frames) free_frame(h, h->frames);
    free(h);
}

void leases_acknowledge(struct leases *leases, const struct message_ack *m)
{
    for (struct leased_tile *t = leases->first; t; t = t->next) {
        const struct message_tile *lease = &t->lease;
        if (t->state != TILE_DONE || lease->index != m->index || lease->frame_id != m->frame_id ||
            lease->generation != m->generation)
            continue;
        if (m->verdict == VERDICT_CORRUPT)
            note(leases, t, LOG_WARNING, "result refused",
                 "the coordinator found it corrupt: this machine may be at fault");
        leases->counts.kept--;
        free_tile(leases, t);
        return;
    }
}

/* Forgets a tile in any state; one that is being traced is stopped and freed when it is done. */
static void drop(struct leases *leases, struct leased_tile *t)
{
    if (t->state == TILE_DROPPED) return;
    if (t->state == TILE_DONE) {
        leases->counts.kept--;
        free_tile(leases, t);
        return;
    }
    if (t->state == TILE_QUEUED && !thread_pool_withdraw(leases->pool, &t->task)) {
        atomic_store(&t->stop, true);
        t->state = TILE_DROPPED;
        return;
    }
    leave_open(leases, t);
    free_tile(leases, t);
}

static void drop_frame(struct leases *leases, struct leased_frame *f)
{
    f->gone = true;
    f->tiles++; /* holds it while its tiles go */
    for (struct leased_tile *t = leases->first, *next; t; t = next) {
        next = t->next;
        if (t->frame == f) drop(leases, t);
    }
    if (--f->tiles == 0) free_frame(leases, f);
}

void leases_cancel(struct leases *leases, uint64_t frame_id)
{
    struct leased_frame *f = leases_find_frame(leases, frame_id);
    if (f) drop_frame(leases, f);
}

void leases_drop_all(struct leases *leases)
{
    for (struct leased_frame *f = leases->frames, *next; f; f = next) {
        next = f->next;
        if (!f->gone) drop_frame(leases, f);
    }
}

/* ---- leaving and coming back ---- */

static bool is_begun(struct leases *leases, struct leased_tile *t)
{
    if (t->state != TILE_QUEUED) return t->state != TILE_WAITING;
    if (!thread_pool_withdraw(leases->pool, &t->task)) return true;
    t->state = TILE_WAITING;
    return false;
}

void leases_link_lost(struct leases *leases)
{
    for (struct leased_tile *t = leases->first, *next; t; t = next) {
        next = t->next;
        if (!is_begun(leases, t)) drop(leases, t);
    }
    /* Frames that come again are told again. */
    for (struct leased_frame *f = leases->frames, *next; f; f = next) {
        next = f->next;
        if (f->tiles == 0) free_frame(leases, f);
    }
}

void leases_resend(struct leases *leases)
{
    for (struct leased_tile *t = leases->first; t; t = t->next)
        if (t->state == TILE_DONE) send_result(leases, t);
}

void leases_return(struct leases *leases, bool all)
{
    for (struct leased_tile *t = leases->first, *next; t; t = next) {
        next = t->next;
        bool begun = is_begun(leases, t);
        if (begun && (!all || t->state != TILE_QUEUED)) continue;
        struct message_returned m = {.frame_id = t->lease.frame_id,
                                     .index = t->lease.index,
                                     .generation = t->lease.generation};
        leases->client.returned(leases->client.ctx, t->request_id, &m);
        drop(leases, t);
    }
}

struct leases_counts leases_counts(const struct leases *leases)
{
    return leases->counts;
}

bool leases_is_tracing(const struct leases *leases)
{
    for (const struct leased_tile *t = leases->first; t; t = t->next)
        if (t->state == TILE_QUEUED || t->state == TILE_DROPPED) return true;
    return false;
}

uint64_t leases_rows(const struct leases *leases)
{
    return atomic_load_explicit(&leases->rows, memory_order_relaxed);
}
