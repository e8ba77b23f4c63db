#pragma once
/* The listening end of worker links: an owner-only Unix socket, or TCP. */
#include <stdbool.h>
#include <uv.h>

#include "proto/error.h"

struct listener {
    union {
        uv_handle_t any;
        uv_stream_t stream;
        uv_tcp_t tcp;
        uv_pipe_t pipe;
    } handle;
    bool is_open; /* the handle must be closed, also after a failed open */
    bool tcp;
    bool waits; /* a connection could not be accepted; libuv reports no other until it is */
    int port;   /* TCP: the port that was bound */
    void (*incoming)(void *ctx, struct listener *l);
    void *ctx;
};

/* Binds and listens. A stale socket file is replaced, and the socket is removed when the handle is
 * closed. *fault names the path and the reason. `incoming` must accept on handle.stream. */
int listener_open_unix(struct listener *l, uv_loop_t *loop, const char *path,
                       void (*incoming)(void *ctx, struct listener *l), void *ctx,
                       struct fault *fault);

/* Listens on "127.0.0.1:7000", "[::1]:7000" or "localhost:7000"; port 0: any. Other addresses are
 * refused (ERR_UNSUPPORTED) unless links are keyed: without a key they are neither encrypted nor
 * authenticated. */
int listener_open_tcp(struct listener *l, uv_loop_t *loop, const char *address, bool keyed,
                      void (*incoming)(void *ctx, struct listener *l), void *ctx,
                      struct fault *fault);

/* Closes it if it is open. Returns true when `closed` will be called from the loop. */
bool listener_close(struct listener *l, void (*closed)(uv_handle_t *handle));
