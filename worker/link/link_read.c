#include "worker/link/link_state.h"

/* libuv fills it and calls on_read before anything else is read. */
static char sealed[65536];

static void on_space(uv_handle_t *handle, size_t suggested, uv_buf_t *out)
{
    (void)suggested;
    struct link *l = handle->data;
    if (l->channel) {
        *out = uv_buf_init(sealed, sizeof sealed);
        return;
    }
    size_t space_bytes = 0;
    uint8_t *space = wire_frame_inbox_space(&l->inbox, &space_bytes);
    if (space_bytes > INT32_MAX) space_bytes = INT32_MAX;
    *out = uv_buf_init((char *)space, space ? (unsigned)space_bytes : 0);
}

/* Takes the whole frames that are there. False when the link is not up any more. */
static bool take_frames(struct link *l)
{
    struct wire_frame_view f;
    int e = 0;
    while (l->state == LINK_UP && !l->closing && (e = wire_frame_inbox_next(&l->inbox, &f)) == 0) {
        e = l->client.frame(l->client.ctx, &f);
        if (e) break;
    }
    if (e && e != ERR_INCOMPLETE && l->state == LINK_UP && !l->closing)
        link_drop(l, e, error_text(e));
    return l->state == LINK_UP && !l->closing;
}

static void be_up(struct link *l)
{
    uv_timer_stop(&l->timer);
    l->state = LINK_UP;
    l->client.up(l->client.ctx);
}

static const char no_key[] = "the coordinator does not have this key (--key), or wants none";

void link_open_sealed(struct link *l)
{
    do {
        size_t space_bytes = 0, got = 0;
        uint8_t *space = wire_frame_inbox_space(&l->inbox, &space_bytes);
        const int e = space ? channel_read(l->channel, space, space_bytes, &got) : ERR_MEMORY;
        link_write_out(l, NULL); /* its own words */
        if (l->state == LINK_SEALING && channel_is_up(l->channel)) be_up(l);
        if (e == ERR_INCOMPLETE || l->closing) return;
        if (e) {
            link_drop(l, e, l->state == LINK_SEALING ? no_key : error_text(e));
            return;
        }
        wire_frame_inbox_filled(&l->inbox, got);
    } while (take_frames(l));
}

static void on_read(uv_stream_t *stream, ssize_t size_bytes, const uv_buf_t *buf)
{
    struct link *l = stream->data;
    if (size_bytes == UV_EOF) {
        link_drop(l, ERR_IO, l->state == LINK_SEALING ? no_key : "the coordinator closed the link");
        return;
    }
    if (size_bytes < 0) {
        link_drop_for(l, "reading failed", (int)size_bytes);
        return;
    }
    if (!l->channel) {
        wire_frame_inbox_filled(&l->inbox, (size_t)size_bytes);
        (void)take_frames(l);
        return;
    }
    int e = channel_feed(l->channel, buf->base, (size_t)size_bytes);
    if (e)
        link_drop(l, e, error_text(e));
    else
        link_open_sealed(l);
}

int link_read_start(struct link *l)
{
    return uv_read_start(&l->handle.stream, on_space, on_read);
}
