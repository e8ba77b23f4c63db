#include "proto/link/channel.h"

#include <errno.h>
#include <gnutls/gnutls.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

#include "proto/error.h"

/* The key's hash is SHA-256, and so must be the ciphers'. */
#define PRIORITIES                                                                                 \
    "NONE:+VERS-TLS1.3:+AES-128-GCM:+CHACHA20-POLY1305:+AEAD:+ECDHE-PSK:+GROUP-X25519:"            \
    "+SIGN-ALL:+COMP-NULL"
#define IDENTITY         "shearwater"
#define HANDSHAKE_BYTES  65536u /* that a peer may send before it is up */
#define TIDY_ABOVE_BYTES 65536u /* read bytes are moved out of the way from here on */

struct channel {
    gnutls_session_t session;
    gnutls_psk_client_credentials_t client;
    gnutls_psk_server_credentials_t server;
    struct link_key key;
    struct bytes_writer in, out;
    size_t in_read; /* of `in` */
    bool up;
};

static ssize_t push(gnutls_transport_ptr_t ctx, const void *data, size_t size_bytes)
{
    struct channel *c = ctx;
    bytes_write_raw(&c->out, data, size_bytes);
    if (!c->out.failed) return (ssize_t)size_bytes;
    gnutls_transport_set_errno(c->session, ENOMEM);
    return -1;
}

static ssize_t pull(gnutls_transport_ptr_t ctx, void *out, size_t capacity)
{
    struct channel *c = ctx;
    size_t n = c->in.size_bytes - c->in_read;
    if (n == 0) {
        gnutls_transport_set_errno(c->session, EAGAIN);
        return -1;
    }
    if (n > capacity) n = capacity;
    memcpy(out, c->in.data + c->in_read, n);
    c->in_read += n;
    return (ssize_t)n;
}

static int pull_timeout(gnutls_transport_ptr_t ctx, unsigned ms)
{
    const struct channel *c = ctx;
    (void)ms;
    return c->in.size_bytes > c->in_read;
}

static int give_key(gnutls_session_t session, const char *name, gnutls_datum_t *out)
{
    const struct channel *c = gnutls_session_get_ptr(session);
    if (strcmp(name, IDENTITY) != 0) return -1;
    out->data = gnutls_malloc(LINK_KEY_BYTES);
    if (!out->data) return -1;
    memcpy(out->data, c->key.bytes, LINK_KEY_BYTES);
    out->size = LINK_KEY_BYTES;
    return 0;
}

static int set_server(struct channel *c)
{
    int code = gnutls_psk_allocate_server_credentials(&c->server);
    if (code < 0) return code;
    gnutls_psk_set_server_credentials_function(c->server, give_key);
    return gnutls_credentials_set(c->session, GNUTLS_CRD_PSK, c->server);
}

static int set_client(struct channel *c)
{
    const gnutls_datum_t key = {c->key.bytes, LINK_KEY_BYTES};
    int code = gnutls_psk_allocate_client_credentials(&c->client);
    if (code >= 0)
        code = gnutls_psk_set_client_credentials(c->client, IDENTITY, &key, GNUTLS_PSK_KEY_RAW);
    return code < 0 ? code : gnutls_credentials_set(c->session, GNUTLS_CRD_PSK, c->client);
}

int channel_create(bool server, const struct link_key *key, struct channel **out)
{
    const unsigned flags = GNUTLS_NONBLOCK | GNUTLS_NO_TICKETS | GNUTLS_NO_SIGNAL;
    struct channel *c = calloc(1, sizeof *c);
    if (!c) return ERR_MEMORY;
    c->key = *key;
    bytes_writer_init(&c->in);
    bytes_writer_init(&c->out);
    int code = gnutls_init(&c->session, flags | (server ? GNUTLS_SERVER : GNUTLS_CLIENT));
    if (code >= 0) code = gnutls_priority_set_direct(c->session, PRIORITIES, NULL);
    if (code >= 0) code = server ? set_server(c) : set_client(c);
    if (code < 0) {
        channel_destroy(&c);
        return code == GNUTLS_E_MEMORY_ERROR ? ERR_MEMORY : ERR_UNSUPPORTED;
    }
    gnutls_session_set_ptr(c->session, c);
    gnutls_transport_set_ptr(c->session, c);
    gnutls_transport_set_push_function(c->session, push);
    gnutls_transport_set_pull_function(c->session, pull);
    gnutls_transport_set_pull_timeout_function(c->session, pull_timeout);
    *out = c;
    return 0;
}

void channel_destroy(struct channel **channel)
{
    struct channel *c = *channel;
    *channel = NULL;
    if (!c) return;
    if (c->session) gnutls_deinit(c->session);
    if (c->client) gnutls_psk_free_client_credentials(c->client);
    if (c->server) gnutls_psk_free_server_credentials(c->server);
    gnutls_memset(&c->key, 0, sizeof c->key);
    bytes_writer_fini(&c->in);
    bytes_writer_fini(&c->out);
    free(c);
}

bool channel_is_up(const struct channel *c)
{
    return c->up;
}

/* What was read makes room. */
static void tidy(struct channel *c)
{
    const size_t left = c->in.size_bytes - c->in_read;
    if (left > 0 && c->in_read < TIDY_ABOVE_BYTES) return;
    if (left > 0) memmove(c->in.data, c->in.data + c->in_read, left);
    c->in.size_bytes = left;
    c->in_read = 0;
}

int channel_feed(struct channel *c, const void *data, size_t size_bytes)
{
    tidy(c);
    if (!c->up && c->in.size_bytes + size_bytes > HANDSHAKE_BYTES) return ERR_LIMIT;
    bytes_write_raw(&c->in, data, size_bytes);
    return c->in.failed ? ERR_MEMORY : 0;
}

/* Returns whether the library wants to be called again. Such a code is no end of the link. */
static bool wants_more(long code)
{
    return code == GNUTLS_E_AGAIN || code == GNUTLS_E_INTERRUPTED ||
           (code < 0 && !gnutls_error_is_fatal((int)code));
}

int channel_read(struct channel *c, void *out, size_t capacity, size_t *size_bytes)
{
    *size_bytes = 0;
    if (!c->up) {
        const int code = gnutls_handshake(c->session);
        if (code < 0) return wants_more(code) ? ERR_INCOMPLETE : ERR_STATE;
        c->up = true;
    }
    const ssize_t got = gnutls_record_recv(c->session, out, capacity);
    if (got == 0 || got == GNUTLS_E_PREMATURE_TERMINATION) return ERR_IO;
    if (got < 0) return wants_more(got) ? ERR_INCOMPLETE : ERR_STATE;
    *size_bytes = (size_t)got;
    return 0;
}

int channel_write(struct channel *c, const void *data, size_t size_bytes)
{
    const uint8_t *at = data;
    if (!c->up) return ERR_STATE;
    while (size_bytes > 0) {
        const ssize_t put = gnutls_record_send(c->session, at, size_bytes);
        if (put < 0) return c->out.failed ? ERR_MEMORY : ERR_STATE;
        at += put;
        size_bytes -= (size_t)put;
    }
    return 0;
}

uint8_t *channel_take(struct channel *c, size_t *size_bytes)
{
    uint8_t *data = c->out.data;
    *size_bytes = c->out.size_bytes;
    if (*size_bytes == 0) return NULL;
    bytes_writer_init(&c->out);
    return data;
}
