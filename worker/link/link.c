#include "worker/link/link.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/un.h>

#include "worker/link/link_state.h"

#define CLOSE_MS  1000
#define WHY_BYTES 256

/* ---- the end ---- */

void link_release_if_done(struct link *l)
{
    if (!l->closing || l->handle_open || l->open_handles > 0 || l->state == LINK_RESOLVING) return;
    void (*closed)(void *ctx) = l->closed;
    void *ctx = l->closed_ctx;
    channel_destroy(&l->channel);
    wire_frame_inbox_fini(&l->inbox);
    bytes_writer_fini(&l->pending);
    bytes_writer_fini(&l->scratch);
    if (l->found) uv_freeaddrinfo(l->found);
    free(l->host);
    free(l);
    if (closed) closed(ctx);
}

static void on_helper_closed(uv_handle_t *handle)
{
    struct link *l = handle->data;
    l->open_handles--;
    link_release_if_done(l);
}

static void on_broken(uv_handle_t *handle);

static void close_handle(struct link *l)
{
    if (l->handle_open && !uv_is_closing(&l->handle.any)) uv_close(&l->handle.any, on_broken);
}

static void close_helpers(struct link *l)
{
    if (!uv_is_closing((uv_handle_t *)&l->timer))
        uv_close((uv_handle_t *)&l->timer, on_helper_closed);
    if (!uv_is_closing((uv_handle_t *)&l->turn))
        uv_close((uv_handle_t *)&l->turn, on_helper_closed);
}

void link_close_all(struct link *l)
{
    if (l->state == LINK_RESOLVING)
        uv_cancel((uv_req_t *)&l->resolving);
    else
        l->state = LINK_STOPPED;
    close_handle(l);
    close_helpers(l);
}

/* ---- waiting ---- */

uint32_t link_wait_ms(unsigned attempt)
{
    uint32_t wait_ms = LINK_RETRY_MS;
    while (attempt-- > 0 && wait_ms < LINK_RETRY_MAX_MS) wait_ms *= 2;
    return wait_ms < LINK_RETRY_MAX_MS ? wait_ms : LINK_RETRY_MAX_MS;
}

static void on_wait_over(uv_timer_t *timer)
{
    struct link *l = timer->data;
    l->state = LINK_STOPPED;
    link_dial(l);
}

static void wait(struct link *l)
{
    l->state = LINK_WAITING;
    uv_timer_start(&l->timer, on_wait_over, link_wait_ms(l->attempt++), 0);
}

static void on_broken(uv_handle_t *handle)
{
    struct link *l = handle->data;
    l->handle_open = false;
    if (l->closing)
        link_release_if_done(l);
    else
        wait(l);
}

void link_drop(struct link *l, int error, const char *why)
{
    if (l->closing) {
        link_close_all(l);
        return;
    }
    if (l->state == LINK_BREAKING || l->state == LINK_WAITING) return;
    char text[WHY_BYTES];
    snprintf(text, sizeof text, "%s", why);
    bool was_open = l->handle_open;
    l->state = LINK_BREAKING;
    l->broken = 0;
    uv_idle_stop(&l->turn);
    bytes_writer_fini(&l->pending); /* what it had no memory for is of the lost link, too */
    bytes_writer_init(&l->pending);
    close_handle(l);
    l->client.down(l->client.ctx, error, text, link_wait_ms(l->attempt));
    if (!was_open && !l->closing) wait(l);
}

void link_drop_for(struct link *l, const char *what, int status)
{
    char why[WHY_BYTES];
    snprintf(why, sizeof why, "%s: %s", what, uv_strerror(status));
    link_drop(l, ERR_IO, why);
}

void link_settle(struct link *l)
{
    l->attempt = 0;
}

/* ---- making and closing ---- */

static int parse_address(struct link *l, const char *address, struct fault *fault)
{
    const int e = link_parse_address(l, address);
    if (e == ERR_LIMIT)
        return fault_set(fault, e, address, "a socket path has 1 to %zu bytes",
                         sizeof((struct sockaddr_un *)0)->sun_path - 1);
    if (e == ERR_MEMORY) return fault_set(fault, e, address, "%s", error_text(e));
    return e ? fault_set(fault, e, address, "expected unix:PATH or HOST:PORT") : 0;
}

int link_check_address(const char *address, struct fault *fault)
{
    struct link l = {.loop = NULL}; /* takes the address's parts; nothing of it is opened */
    const int e = parse_address(&l, address, fault);
    free(l.host);
    return e;
}

int link_create(uv_loop_t *loop, const char *address, const struct link_key *key,
                const struct link_client *client, struct link **out, struct fault *fault)
{
    struct link *l = calloc(1, sizeof *l);
    if (!l) return fault_set(fault, ERR_MEMORY, address, "%s", error_text(ERR_MEMORY));
    const int e = parse_address(l, address, fault);
    if (e) {
        free(l);
        return e;
    }
    l->loop = loop;
    l->client = *client;
    l->is_keyed = key && !l->is_unix;
    if (l->is_keyed) l->key = *key;
    uv_timer_init(loop, &l->timer);
    uv_idle_init(loop, &l->turn);
    l->timer.data = l->turn.data = l;
    l->open_handles = 2;
    wire_frame_inbox_init(&l->inbox, LIMIT_FRAME_BYTES);
    bytes_writer_init(&l->pending);
    bytes_writer_init(&l->scratch);
    *out = l;
    return 0;
}

static void on_close_too_slow(uv_timer_t *timer)
{
    link_close_all(timer->data);
}

void link_close(struct link *l, void (*closed)(void *ctx), void *ctx)
{
    l->closed = closed;
    l->closed_ctx = ctx;
    if (l->state == LINK_UP && l->pending.size_bytes > 0) link_write_out(l, NULL);
    l->closing = true;
    if (l->state == LINK_UP) uv_read_stop(&l->handle.stream);
    if (l->state == LINK_UP && l->queued_bytes > 0 && l->broken == 0)
        uv_timer_start(&l->timer, on_close_too_slow, CLOSE_MS, 0);
    else
        link_close_all(l);
}
