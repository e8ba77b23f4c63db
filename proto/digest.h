#pragma once
/* SHA-256 digests and their hexadecimal form: the names of assets, scene blobs and results. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DIGEST_BYTES     32
#define DIGEST_HEX_BYTES 65 /* with its end */

struct digest {
    uint8_t bytes[DIGEST_BYTES];
};

struct digest_state; /* a running hash */

/* Begins a digest; NULL on failed allocation. digest_finish frees it and nulls the caller's
 * pointer. */
struct digest_state *digest_begin(void);
int digest_update(struct digest_state *state, const void *data, size_t size_bytes);
void digest_finish(struct digest_state **state, struct digest *out);

void digest_of(const void *data, size_t size_bytes, struct digest *out);
bool digest_equal(const struct digest *a, const struct digest *b);
bool digest_is_zero(const struct digest *d);

/* Writes 64 lower-case hexadecimal digits. */
void digest_to_hex(const struct digest *d, char out[DIGEST_HEX_BYTES]);

/* Reads a digest. ERR_SYNTAX unless `hex` is exactly 64 lower-case hexadecimal digits. */
int digest_from_hex(const char *hex, struct digest *out);
