#pragma once
/* The link to the coordinator: dials, dials again when it is lost, frames what goes in and out.
 *
 * Waits between attempts double from 100 ms to 5 s, without jitter: a schedule that tests can
 * know. The first wait is back as soon as link_settle says that the coordinator took us. */
#include <uv.h>

#include "proto/bytes.h"
#include "proto/error.h"
#include "proto/link/link_key.h"
#include "proto/link/wire_frame.h"
#include "worker/link/shared_buffer.h"

#define LINK_RETRY_MS     100u
#define LINK_RETRY_MAX_MS 5000u

struct link;

struct link_client {
    void *ctx;
    void (*up)(void *ctx); /* connected */
    /* A negative code drops the link. */
    int (*frame)(void *ctx, const struct wire_frame_view *f);
    /* The link was lost, or could not be made: `error` and a sentence. It is dialled again after
     * wait_ms unless link_close is called from inside. */
    void (*down)(void *ctx, int error, const char *why, uint32_t wait_ms);
};

/* Is `address` "unix:PATH" or "HOST:PORT"? *fault names what is wrong with it. */
int link_check_address(const char *address, struct fault *fault);

/* `address`: as link_check_address wants it. key, copied: links over TCP are sealed with it
 * (proto/link/channel.h); NULL: they are not. *fault names what is wrong with it. Nothing happens
 * before link_dial. */
int link_create(uv_loop_t *loop, const char *address, const struct link_key *key,
                const struct link_client *client, struct link **out, struct fault *fault);
void link_dial(struct link *link);

/* The coordinator welcomed us: waits start from the first again. */
void link_settle(struct link *link);

/* Breaks the connection; it is dialled again. */
void link_drop(struct link *link, int error, const char *why);

/* Sends what was put, then closes for good. `closed` comes from the loop when all memory is freed,
 * the link's own included. Waits at most a second for the coordinator to take the last bytes. */
void link_close(struct link *link, void (*closed)(void *ctx), void *ctx);

/* Milliseconds before attempt `attempt`, from 0. */
uint32_t link_wait_ms(unsigned attempt);

/* An empty writer for one payload, then link_put sends it. Without a connection what is put is
 * dropped: a session says again what matters when the link is up. Put frames go out together before
 * the loop sleeps. link_put_buffer appends the buffer to the payload and holds a reference until it
 * is written. */
struct bytes_writer *link_payload(struct link *link);
void link_put(struct link *link, uint16_t type, uint64_t request_id);
void link_put_buffer(struct link *link, uint16_t type, uint64_t request_id,
                     struct shared_buffer *buffer);
