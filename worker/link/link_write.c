#include <stdlib.h>

#include "worker/link/link_state.h"

struct link_write {
    uv_write_t request;
    struct link *link;
    uint8_t *data; /* owned */
    struct shared_buffer *buffer;
    size_t size_bytes;
};

static void on_written(uv_write_t *request, int status)
{
    struct link_write *write = (struct link_write *)request;
    struct link *l = write->link;
    l->queued_bytes -= write->size_bytes;
    free(write->data);
    shared_buffer_unref(&write->buffer);
    free(write);
    if (status < 0 && status != UV_ECANCELED) link_drop_for(l, "writing failed", status);
    if (l->closing && l->queued_bytes == 0) link_close_all(l);
}

static void on_turn(uv_idle_t *turn);

static void break_later(struct link *l, int error)
{
    if (l->broken == 0) l->broken = error;
    if (!l->closing) uv_idle_start(&l->turn, on_turn);
}

/* Encrypts the pending frames and the buffer. */
static int seal(struct link *l, const struct shared_buffer *buffer)
{
    int e = 0;
    if (l->pending.size_bytes > 0)
        e = channel_write(l->channel, l->pending.data, l->pending.size_bytes);
    if (e == 0 && buffer) e = channel_write(l->channel, buffer->data, buffer->size_bytes);
    bytes_writer_fini(&l->pending);
    bytes_writer_init(&l->pending);
    if (e) return e;
    l->pending.data = channel_take(l->channel, &l->pending.size_bytes);
    l->pending.capacity_bytes = l->pending.size_bytes;
    return 0;
}

void link_write_out(struct link *l, struct shared_buffer *buffer)
{
    if (l->channel && !l->pending.failed) {
        const int e = seal(l, buffer);
        if (e) break_later(l, e);
        if (e || l->pending.size_bytes == 0) return;
        buffer = NULL;
    }
    struct link_write *write = calloc(1, sizeof *write);
    if (!write || l->pending.failed) {
        free(write);
        break_later(l, ERR_MEMORY);
        return;
    }
    size_t tail_bytes = buffer ? buffer->size_bytes : 0;
    write->link = l;
    write->data = l->pending.data;
    write->buffer = buffer ? shared_buffer_ref(buffer) : NULL;
    write->size_bytes = l->pending.size_bytes + tail_bytes;
    uv_buf_t parts[2] = {uv_buf_init((char *)write->data, (unsigned)l->pending.size_bytes),
                         uv_buf_init(buffer ? (char *)buffer->data : NULL, (unsigned)tail_bytes)};
    bytes_writer_init(&l->pending);
    int status = uv_write(&write->request, &l->handle.stream, parts, buffer ? 2 : 1, on_written);
    if (status == 0) {
        l->queued_bytes += write->size_bytes;
        return;
    }
    free(write->data);
    shared_buffer_unref(&write->buffer);
    free(write);
    break_later(l, ERR_IO);
}

static void on_turn(uv_idle_t *turn)
{
    struct link *l = turn->data;
    uv_idle_stop(turn);
    if (l->state != LINK_UP) return;
    if (l->broken == 0 && (l->pending.size_bytes > 0 || l->pending.failed)) link_write_out(l, NULL);
    if (l->broken) link_drop(l, l->broken, error_text(l->broken));
}

struct bytes_writer *link_payload(struct link *l)
{
    l->scratch.size_bytes = 0;
    l->scratch.failed = false; /* that was another message */
    return &l->scratch;
}

static bool append(struct link *l, uint16_t type, uint64_t request_id,
                   const struct shared_buffer *buffer)
{
    if (l->state != LINK_UP) return false;
    const struct bytes_writer *head = &l->scratch;
    if (head->failed) {
        break_later(l, ERR_MEMORY);
        return false;
    }
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    wire_frame_header(header, type, request_id, head->data, (uint32_t)head->size_bytes,
                      buffer ? buffer->data : NULL, buffer ? (uint32_t)buffer->size_bytes : 0);
    bytes_write_raw(&l->pending, header, sizeof header);
    if (head->size_bytes > 0) bytes_write_raw(&l->pending, head->data, head->size_bytes);
    return true;
}

void link_put(struct link *l, uint16_t type, uint64_t request_id)
{
    if (append(l, type, request_id, NULL)) uv_idle_start(&l->turn, on_turn);
}

void link_put_buffer(struct link *l, uint16_t type, uint64_t request_id,
                     struct shared_buffer *buffer)
{
    if (append(l, type, request_id, buffer)) link_write_out(l, buffer);
}
