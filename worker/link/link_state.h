#pragma once
/* Internals of a link, for its own files alone: link.c creates, drops and closes it, link_dial.c
 * dials, link_read.c and link_write.c move frames. */
#include <netdb.h>
#include <stdbool.h>

#include "proto/link/channel.h"
#include "worker/link/link.h"

enum link_state {
    LINK_STOPPED,   /* before the first dial, or closed for good */
    LINK_RESOLVING, /* looks up the host name */
    LINK_CONNECTING,
    LINK_SEALING, /* connected; both sides prove that they have the key */
    LINK_UP,
    LINK_BREAKING, /* the handle closes; then the wait begins */
    LINK_WAITING,
};

struct link {
    uv_loop_t *loop;
    struct link_client client;
    char *host; /* owned: host name, or the socket's path */
    char port[8];
    bool is_unix, is_keyed; /* keyed: over TCP, with `key` */
    struct link_key key;
    struct channel *channel; /* owned; of this connection */
    enum link_state state;
    union {
        uv_handle_t any;
        uv_stream_t stream;
        uv_tcp_t tcp;
        uv_pipe_t pipe;
    } handle;
    uv_connect_t connecting;
    uv_getaddrinfo_t resolving;
    struct addrinfo *found, *trying; /* owned; the one in use */
    uv_timer_t timer;                /* waits between attempts; when closing, the time limit */
    uv_idle_t turn;
    struct wire_frame_inbox inbox;
    struct bytes_writer pending, scratch;
    size_t queued_bytes;
    unsigned attempt;
    int broken; /* a failure that the next turn handles, so that link_put never calls back */
    bool closing, handle_open;
    unsigned open_handles; /* timer, turn */
    void (*closed)(void *ctx);
    void *closed_ctx;
};

/* Frees a closed link and calls `closed` once no handle and no write of it is open. */
void link_release_if_done(struct link *l);

/* Closes the open handles for good. */
void link_close_all(struct link *l);

/* Drops the link for a libuv status. */
void link_drop_for(struct link *l, const char *what, int status);

/* Starts to read from a connected handle. Returns a libuv status. */
int link_read_start(struct link *l);

/* Continues the handshake, then decrypts the bytes that have come. */
void link_open_sealed(struct link *l);

/* Writes the pending frames and the buffer, which may be NULL. */
void link_write_out(struct link *l, struct shared_buffer *buffer);

/* Sets host, port and is_unix from an address. ERR_SYNTAX, ERR_LIMIT, ERR_MEMORY. */
int link_parse_address(struct link *l, const char *address);
