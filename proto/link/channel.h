#pragma once
/* A worker link behind TLS 1.3 with a shared key (RFC 8446, with a fresh X25519 exchange each time,
 * so that a key that leaks later opens nothing of before). Knows no sockets: bytes that came are
 * fed in, bytes to be sent are taken out, and neither ever waits. */
#include <stdbool.h>

#include "proto/bytes.h"
#include "proto/link/link_key.h"

struct channel;

/* server: who listens. ERR_MEMORY; ERR_UNSUPPORTED when the library lacks what is needed. */
int channel_create(bool server, const struct link_key *key, struct channel **out);
void channel_destroy(struct channel **channel);

/* Both sides have shown that they have the key. */
bool channel_is_up(const struct channel *c);

/* Bytes that came from the peer. ERR_MEMORY, ERR_LIMIT. */
int channel_feed(struct channel *c, const void *data, size_t size_bytes);

/* Goes on with the handshake, then gives plain bytes. ERR_INCOMPLETE: more must come first;
 * ERR_STATE: the peer does not have the key, or the bytes are not his; ERR_IO: he has said goodbye.
 */
int channel_read(struct channel *c, void *out, size_t capacity, size_t *size_bytes);

/* Plain bytes for the peer; only while it is up. ERR_STATE, ERR_MEMORY. */
int channel_write(struct channel *c, const void *data, size_t size_bytes);

/* What is to be sent: taken over by the caller (free). NULL: nothing. */
uint8_t *channel_take(struct channel *c, size_t *size_bytes);
