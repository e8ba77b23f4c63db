#pragma once
/* The link to the coordinator. It dials, dials again when the connection is lost, and frames the
 * messages.
 *
 * Waits between attempts double from 100 ms to 5 s. They have no jitter, so that tests can predict
 * them. link_settle resets the wait. */
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
    /* A frame has come. A negative return value drops the link. */
    int (*frame)(void *ctx, const struct wire_frame_view *f);
    /* The link was lost or could not be made; `why` is a sentence. It is dialled again after
     * wait_ms unless the callback calls link_close. */
    void (*down)(void *ctx, int error, const char *why, uint32_t wait_ms);
};

/* Checks that `address` is "unix:PATH" or "HOST:PORT". *fault names what is wrong with it. */
int link_check_address(const char *address, struct fault *fault);

/* Creates a link to `address` (link_check_address); it stays idle until link_dial. Links over TCP
 * are sealed with `key` (proto/link/channel.h), which is copied; NULL: they are in the clear.
 * *fault names what is wrong with the address. */
int link_create(uv_loop_t *loop, const char *address, const struct link_key *key,
                const struct link_client *client, struct link **out, struct fault *fault);
void link_dial(struct link *link);

/* Resets the wait between attempts: the coordinator has welcomed the worker. */
void link_settle(struct link *link);

/* Breaks the connection; it is dialled again. */
void link_drop(struct link *link, int error, const char *why);

/* Sends the frames that were put, then closes the link for good. Waits at most a second for the
 * coordinator to take the last bytes. The loop calls `closed` when all memory is freed, the link's
 * own included. */
void link_close(struct link *link, void (*closed)(void *ctx), void *ctx);

/* Returns the wait in milliseconds before attempt `attempt`, counted from 0. */
uint32_t link_wait_ms(unsigned attempt);

/* link_payload returns an empty writer for one payload, which link_put sends as a frame.
 * link_put_buffer appends `buffer` to the payload and holds a reference until it is written. Frames
 * go out together before the loop sleeps. Without a connection they are dropped: the session sends
 * what matters again when the link is up. */
struct bytes_writer *link_payload(struct link *link);
void link_put(struct link *link, uint16_t type, uint64_t request_id);
void link_put_buffer(struct link *link, uint16_t type, uint64_t request_id,
                     struct shared_buffer *buffer);
