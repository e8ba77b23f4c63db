#pragma once
/* The outgoing side of one worker link. Messages are gathered and written once a turn of the loop,
 * so that a burst of leases or acknowledgements costs one system call. */
#include <stdbool.h>
#include <uv.h>

#include "proto/bytes.h"
#include "proto/link/channel.h"

struct outbox {
    uv_stream_t *stream;         /* borrowed */
    struct bytes_writer pending; /* whole frames, not yet given to libuv */
    struct bytes_writer scratch; /* the payload that is being encoded */
    size_t queued_bytes;         /* given to libuv and not yet written */
    struct channel *channel;     /* borrowed: seals what goes out; NULL: it goes in the clear */
    uint64_t *sent_bytes;        /* borrowed: grows with every byte that went out */
    int error;                   /* the first failure, or 0; nothing is sent after it */
    void (*written)(struct outbox *box);
};

/* Initialises an outbox. `written` is called on the loop's thread after libuv has finished a write;
 * may be NULL. */
void outbox_init(struct outbox *box, uv_stream_t *stream, uint64_t *sent_bytes,
                 void (*written)(struct outbox *box));

/* Frees an outbox, only after the stream's close callback: libuv ends all writes before it. */
void outbox_fini(struct outbox *box);

/* Returns an empty writer to encode one payload into; outbox_put sends what is in it. */
struct bytes_writer *outbox_payload(struct outbox *box);
void outbox_put(struct outbox *box, uint16_t type, uint64_t request_id);

/* Does the same with `tail` after the payload; takes the tail over (free). Flushes at once. */
void outbox_put_tail(struct outbox *box, uint16_t type, uint64_t request_id, void *tail,
                     uint32_t tail_bytes);

/* Gives libuv the gathered messages and the channel's own bytes. Returns 0 or the first failure,
 * also one from earlier. */
int outbox_flush(struct outbox *box);

/* Returns the bytes that still wait on this side of the kernel. */
size_t outbox_backlog(const struct outbox *box);
