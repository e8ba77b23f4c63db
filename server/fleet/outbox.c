#include "server/fleet/outbox.h"

#include <stdlib.h>

#include "proto/error.h"
#include "proto/link/wire_frame.h"

struct outbox_write {
    uv_write_t request;
    struct outbox *box;
    uint8_t *data; /* owned */
    void *tail;    /* owned, may be NULL */
    size_t size_bytes;
};

void outbox_init(struct outbox *box, uv_stream_t *stream, uint64_t *sent_bytes,
                 void (*written)(struct outbox *box))
{
    *box = (struct outbox){.stream = stream, .sent_bytes = sent_bytes, .written = written};
    bytes_writer_init(&box->pending);
    bytes_writer_init(&box->scratch);
}

void outbox_fini(struct outbox *box)
{
    bytes_writer_fini(&box->pending);
    bytes_writer_fini(&box->scratch);
}

static void fail(struct outbox *box, int error)
{
    if (box->error == 0) box->error = error;
}

struct bytes_writer *outbox_payload(struct outbox *box)
{
    box->scratch.size_bytes = 0;
    return &box->scratch;
}

static void append_frame(struct outbox *box, uint16_t type, uint64_t request_id, const void *tail,
                         uint32_t tail_bytes)
{
    const struct bytes_writer *head = &box->scratch;
    if (head->failed) {
        fail(box, ERR_MEMORY);
        return;
    }
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    wire_frame_header(header, type, request_id, head->data, (uint32_t)head->size_bytes, tail,
                      tail_bytes);
    bytes_write_raw(&box->pending, header, sizeof header);
    if (head->size_bytes > 0) bytes_write_raw(&box->pending, head->data, head->size_bytes);
    if (box->pending.failed) fail(box, ERR_MEMORY);
}

static void on_written(uv_write_t *request, int status)
{
    struct outbox_write *write = (struct outbox_write *)request;
    struct outbox *box = write->box;
    box->queued_bytes -= write->size_bytes;
    if (status < 0) fail(box, ERR_IO);
    free(write->data);
    free(write->tail);
    free(write);
    if (box->written) box->written(box);
}

/* Seals the pending bytes and the tail, which is freed. The channel's output is pending then. */
static void seal(struct outbox *box, void *tail, uint32_t tail_bytes)
{
    struct channel *c = box->channel;
    const bool has_words = box->pending.size_bytes > 0 || tail_bytes > 0;
    int e = 0;
    if (has_words) e = channel_write(c, box->pending.data, box->pending.size_bytes);
    if (!e && tail_bytes > 0) e = channel_write(c, tail, tail_bytes);
    free(tail);
    if (e) {
        fail(box, e);
        return;
    }
    bytes_writer_fini(&box->pending);
    bytes_writer_init(&box->pending);
    box->pending.data = channel_take(c, &box->pending.size_bytes);
    box->pending.capacity_bytes = box->pending.size_bytes;
}

/* Writes pending and then the tail, both taken over. */
static int write_out(struct outbox *box, void *tail, uint32_t tail_bytes)
{
    if (box->channel) {
        seal(box, tail, tail_bytes);
        if (!box->error && box->pending.size_bytes == 0) return 0;
        tail = NULL;
        tail_bytes = 0;
    }
    struct outbox_write *write = box->error ? NULL : calloc(1, sizeof *write);
    if (!write) {
        fail(box, ERR_MEMORY);
        free(tail);
        return box->error;
    }
    write->box = box;
    write->data = box->pending.data;
    write->tail = tail;
    write->size_bytes = box->pending.size_bytes + tail_bytes;
    uv_buf_t parts[2] = {uv_buf_init((char *)write->data, (unsigned)box->pending.size_bytes),
                         uv_buf_init(tail, tail_bytes)};
    bytes_writer_init(&box->pending);
    int status = uv_write(&write->request, box->stream, parts, tail ? 2 : 1, on_written);
    if (status < 0) {
        fail(box, ERR_IO);
        free(write->data);
        free(tail);
        free(write);
        return box->error;
    }
    box->queued_bytes += write->size_bytes;
    *box->sent_bytes += write->size_bytes;
    return 0;
}

void outbox_put(struct outbox *box, uint16_t type, uint64_t request_id)
{
    append_frame(box, type, request_id, NULL, 0);
}

void outbox_put_tail(struct outbox *box, uint16_t type, uint64_t request_id, void *tail,
                     uint32_t tail_bytes)
{
    append_frame(box, type, request_id, tail, tail_bytes);
    write_out(box, tail, tail_bytes);
}

int outbox_flush(struct outbox *box)
{
    if (box->error) return box->error;
    return box->pending.size_bytes > 0 || box->channel ? write_out(box, NULL, 0) : 0;
}

size_t outbox_backlog(const struct outbox *box)
{
    return box->queued_bytes + box->pending.size_bytes;
}
