#include "worker/session/session.h"

#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>

#include "proto/runtime/build.h"
#include "worker/session/session_work.h"

#define TEXT_BYTES 768

/* ---- states ---- */

#define TO(state) (1u << SESSION_##state)
static const unsigned legal[SESSION_STATE_COUNT] = {
    [SESSION_OFFLINE] = TO(GREETING) | TO(OFFLINE) | TO(ENDED),
    [SESSION_GREETING] = TO(WORKING) | TO(OFFLINE) | TO(ENDED),
    [SESSION_WORKING] = TO(DRAINING) | TO(LEAVING) | TO(OFFLINE) | TO(ENDED),
    [SESSION_DRAINING] = TO(WORKING) | TO(LEAVING) | TO(OFFLINE) | TO(ENDED),
    [SESSION_LEAVING] = TO(ENDED),
    [SESSION_ENDED] = 0,
};

void session_enter(struct session *s, enum session_state next)
{
    if (!(legal[s->state] & (1u << next))) abort(); /* our own bug */
    s->state = next;
}

enum session_state session_state(const struct session *s)
{
    return s->state;
}

void session_end(struct session *s, enum session_end how, const char *text)
{
    if (s->state == SESSION_ENDED) return;
    if (s->lacks_memory && how == SESSION_END_TOLD) {
        how = SESSION_END_FAILED;
        text = "memory ran out while a scene was loaded";
    }
    session_enter(s, SESSION_ENDED);
    uv_timer_stop(&s->beat);
    uv_timer_stop(&s->patience);
    session_deadlines_stop(s);
    s->client.ended(s->client.ctx, how, text);
}

void session_note(struct session *s, enum log_level level, const char *what, const char *detail)
{
    const struct log_field fields[] = {{"coordinator", s->options->connect, 0},
                                       {"detail", detail, 0}};
    worker_log_write(s->client.worker_log, level, what, fields, 2);
}

bool session_is_on(const struct session *s)
{
    return s->state == SESSION_WORKING || s->state == SESSION_DRAINING ||
           s->state == SESSION_LEAVING;
}

/* ---- what the leases and the cache say ---- */

static void on_result(void *ctx, const struct lease_result *result)
{
    struct session *s = ctx;
    if (!session_is_on(s)) return; /* kept; said again when the link is back */
    /* Short jobs end between two beats: their results tell of us, too. */
    if (uv_now(s->beat.loop) - s->last_beat_ms >= s->beat_ms / 4) session_send_beat(s);
    struct message_result m = result->message;
    m.samples_bytes = (uint32_t)result->samples->size_bytes;
    message_encode_result(link_payload(s->link), &m);
    link_put_buffer(s->link, MESSAGE_RESULT, result->request_id, result->samples);
}

static void on_tile_fault(void *ctx, uint64_t request_id, const struct message_tile_fault *m)
{
    struct session *s = ctx;
    if (!session_is_on(s)) return;
    message_encode_tile_fault(link_payload(s->link), m);
    link_put(s->link, MESSAGE_FAULT, request_id);
}

static void on_tile_returned(void *ctx, uint64_t request_id, const struct message_returned *m)
{
    session_say_returned(ctx, request_id, m);
}

static void on_moved(void *ctx)
{
    session_moved(ctx);
}

static void on_ask_for_part(void *ctx, const struct message_blob_get *m)
{
    struct session *s = ctx;
    message_encode_blob_get(link_payload(s->link), m);
    link_put(s->link, MESSAGE_BLOB_GET, s->next_request++);
}

static void on_blob_settled(void *ctx, struct cached_blob *blob)
{
    struct session *s = ctx;
    leases_blob_settled(s->leases, blob);
    if (blob->state == BLOB_FAILED && blob->fault.code == ERR_MEMORY)
        session_deadlines_lack_memory(s);
}

/* ---- the link ---- */

static void on_greeting_patience(uv_timer_t *timer)
{
    struct session *s = timer->data;
    link_drop(s->link, ERR_TIMEOUT, "the coordinator does not answer");
}

static int on_frame(void *ctx, const struct wire_frame_view *f)
{
    return session_take(ctx, f);
}

static void on_up(void *ctx)
{
    struct session *s = ctx;
    if (s->state == SESSION_ENDED) return;
    session_enter(s, SESSION_GREETING);
    s->asked = 0;
    s->last_beat_ms = 0;
    session_say_hello(s);
    uv_timer_start(&s->patience, on_greeting_patience, SESSION_GREETING_MS, 0);
}

static void on_down(void *ctx, int error, const char *why, uint32_t wait_ms)
{
    struct session *s = ctx;
    char text[TEXT_BYTES];
    (void)error;
    if (s->state == SESSION_ENDED) return;
    uv_timer_stop(&s->beat);
    uv_timer_stop(&s->patience);
    /* a parent that ends tells those that it has welcomed */
    const bool ends = s->state == SESSION_DRAINING || s->state == SESSION_GREETING;
    const bool meant = ends && s->options->exit_with_parent;
    if (s->state == SESSION_LEAVING || meant) {
        session_end(s, SESSION_END_TOLD, "");
        return;
    }
    session_enter(s, SESSION_OFFLINE);
    blob_cache_link_down(s->cache);
    leases_link_lost(s->leases);
    session_deadlines_moved(s);
    if (s->options->exit_with_parent) {
        session_end(s, SESSION_END_FAILED, why);
        return;
    }
    if (!s->was_told_offline) {
        snprintf(text, sizeof text,
                 "%s; trying again in %u ms and then ever less often, up to every %u ms", why,
                 wait_ms, LINK_RETRY_MAX_MS);
        session_note(s, LOG_WARNING, "link lost", text);
    }
    s->was_told_offline = true;
}

/* ---- life ---- */

static void release_one(struct session *s)
{
    if (--s->open > 0 || !s->closing) return;
    void (*closed)(void *ctx) = s->closed;
    void *ctx = s->closed_ctx;
    free(s);
    if (closed) closed(ctx);
}

static void on_timer_closed(uv_handle_t *handle)
{
    release_one(handle->data);
}

static void on_pool_closed(void *ctx)
{
    release_one(ctx);
}

/* The last bytes are out: now the threads may take their time. */
static void close_pool(struct session *s)
{
    if (!s->pool) return;
    if (s->client.flushed && s->cache)
        s->client.flushed(s->client.ctx, blob_cache_is_loading(s->cache));
    thread_pool_close(&s->pool, on_pool_closed, s);
    leases_destroy(&s->leases);
    blob_cache_destroy(&s->cache);
}

static void on_link_closed(void *ctx)
{
    struct session *s = ctx;
    s->link = NULL;
    close_pool(s);
    release_one(s);
}

void session_close(struct session *s, void (*closed)(void *ctx), void *ctx)
{
    s->closing = true;
    s->closed = closed;
    s->closed_ctx = ctx;
    if (s->state != SESSION_ENDED) session_enter(s, SESSION_ENDED);
    if (s->leases) leases_drop_all(s->leases);
    uv_close((uv_handle_t *)&s->beat, on_timer_closed);
    uv_close((uv_handle_t *)&s->patience, on_timer_closed);
    for (int i = 0; i < SESSION_DEADLINE_COUNT; i++)
        uv_close((uv_handle_t *)&s->deadlines[i], on_timer_closed);
    if (s->link)
        link_close(s->link, on_link_closed, s);
    else
        close_pool(s);
}

static int build(struct session *s, uv_loop_t *loop, struct fault *fault)
{
    const struct options *o = s->options;
    const struct blob_cache_options cache = {.blob_dir = o->blob_dir,
                                             .cache_dir = o->cache_dir,
                                             .cache_bytes = o->cache_bytes,
                                             .threads = o->threads};
    const struct blob_cache_client blob_cache_client = {s, on_ask_for_part, on_blob_settled};
    const struct leases_client leases_client = {
        s, on_result, on_tile_fault, on_tile_returned, on_moved, s->client.worker_log};
    const struct link_client link_client = {s, on_up, on_frame, on_down};
    const struct pool_tools tools = {s->tracing->tracer_create, s->tracing->tracer_destroy,
                                     s->tracing->ctx};
    struct link_key key;
    int e = o->key ? link_key_read(o->key, &key, fault) : 0;
    if (e == 0)
        e = link_create(loop, o->connect, o->key ? &key : NULL, &link_client, &s->link, fault);
    if (o->key) gnutls_memset(&key, 0, sizeof key);
    if (e) return e;
    s->open++;
    e = thread_pool_create(loop, "trace", o->threads, &tools, &s->pool);
    if (e == 0) s->open++;
    if (e == 0) e = blob_cache_create(s->pool, s->tracing, &cache, &blob_cache_client, &s->cache);
    if (e == 0)
        e = leases_create(s->pool, s->cache, s->tracing, o->packing, &leases_client, &s->leases);
    return e ? fault_set(fault, e, "worker", "%s", error_text(e)) : 0;
}

int session_create(uv_loop_t *loop, const struct options *options, const struct tracing *tracing,
                   const struct session_client *client, struct session **out, struct fault *fault)
{
    if (build_isa_check(fault) != 0) return fault->code;
    /* Asked now: what fails once in there, for want of memory, may hang the next time. */
    if (!tracing->embree_version(tracing->ctx))
        return fault_set(fault, ERR_MEMORY, "embree", "it gives no device: is there no memory?");
    struct session *s = calloc(1, sizeof *s);
    if (!s) return fault_set(fault, ERR_MEMORY, "worker", "%s", error_text(ERR_MEMORY));
    s->options = options;
    s->tracing = tracing;
    s->client = *client;
    s->next_request = 1;
    uv_timer_init(loop, &s->beat);
    uv_timer_init(loop, &s->patience);
    s->beat.data = s->patience.data = s;
    session_deadlines_init(s, loop);
    s->open = 2 + SESSION_DEADLINE_COUNT;
    int e = build(s, loop, fault);
    if (e) {
        session_close(s, NULL, NULL);
        return e;
    }
    *out = s;
    return 0;
}

void session_start(struct session *s)
{
    session_deadlines_start(s);
    link_dial(s->link);
}

void session_stop(struct session *s)
{
    switch (s->state) {
    case SESSION_OFFLINE:
    case SESSION_GREETING:
        session_end(s, SESSION_END_TOLD, "");
        return;
    case SESSION_WORKING:
    case SESSION_DRAINING:
        session_enter(s, SESSION_LEAVING);
        session_note(s, LOG_INFO, "leaving", "");
        leases_return(s->leases, false);
        session_leave_when_done(s);
        return;
    case SESSION_LEAVING:
        leases_return(s->leases, true);
        session_say_goodbye(s);
        return;
    default:
        return;
    }
}
