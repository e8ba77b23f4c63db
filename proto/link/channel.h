#pragma once
/* A worker link in TLS 1.3 with a shared key (RFC 8446). Each connection has a fresh X25519
 * exchange, so that a leaked key decrypts no earlier traffic. A channel has no socket: received
 * bytes are fed in and bytes to be sent are taken out. No function blocks. */
#include <stdbool.h>

#include "proto/bytes.h"
#include "proto/link/link_key.h"

struct channel;

/* Creates a channel; `server` is true on the listening side. ERR_MEMORY; ERR_UNSUPPORTED when the
 * library lacks a feature. */
int channel_create(bool server, const struct link_key *key, struct channel **out);
void channel_destroy(struct channel **channel);

/* Returns whether both sides have proved that they have the key. */
bool channel_is_up(const struct channel *c);

/* Feeds in bytes received from the peer. ERR_MEMORY, ERR_LIMIT. */
int channel_feed(struct channel *c, const void *data, size_t size_bytes);

/* Continues the handshake, then returns decrypted bytes. ERR_INCOMPLETE: more bytes must be fed in;
 * ERR_STATE: the peer does not have the key, or the bytes are not its own; ERR_IO: the peer has
 * closed the channel. */
int channel_read(struct channel *c, void *out, size_t capacity, size_t *size_bytes);

/* Encrypts bytes for the peer. ERR_STATE while the channel is not up, ERR_MEMORY. */
int channel_write(struct channel *c, const void *data, size_t size_bytes);

/* Returns the bytes to be sent, which the caller frees. NULL: there are none. */
uint8_t *channel_take(struct channel *c, size_t *size_bytes);
