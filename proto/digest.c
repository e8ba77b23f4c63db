#include "proto/digest.h"

#include <nettle/sha2.h>
#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

struct digest_state {
    struct sha256_ctx hash;
};

struct digest_state *digest_begin(void)
{
    struct digest_state *state = malloc(sizeof *state);
    if (state) sha256_init(&state->hash);
    return state;
}

int digest_update(struct digest_state *state, const void *data, size_t size_bytes)
{
    if (size_bytes > 0) sha256_update(&state->hash, size_bytes, data);
    return ERR_OK;
}

void digest_finish(struct digest_state **state, struct digest *out)
{
    sha256_digest(&(*state)->hash, DIGEST_BYTES, out->bytes);
    free(*state);
    *state = NULL;
}

/* Uses nettle, on which GnuTLS stands. It allocates nothing, so it cannot fail. */
void digest_of(const void *data, size_t size_bytes, struct digest *out)
{
    struct sha256_ctx hash;
    sha256_init(&hash);
    if (size_bytes > 0) sha256_update(&hash, size_bytes, data);
    sha256_digest(&hash, DIGEST_BYTES, out->bytes);
}

bool digest_equal(const struct digest *a, const struct digest *b)
{
    return memcmp(a->bytes, b->bytes, DIGEST_BYTES) == 0;
}

bool digest_is_zero(const struct digest *d)
{
    static const struct digest zero;
    return digest_equal(d, &zero);
}

void digest_to_hex(const struct digest *d, char out[DIGEST_HEX_BYTES])
{
    static const char digits[] = "0123456789abcdef";
    for (size_t i = 0; i < DIGEST_BYTES; i++) {
        out[2 * i] = digits[d->bytes[i] >> 4];
        out[2 * i + 1] = digits[d->bytes[i] & 15];
    }
    out[DIGEST_HEX_BYTES - 1] = '\0';
}

static int hex_value(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return -1;
}

int digest_from_hex(const char *hex, struct digest *out)
{
    struct digest read;
    for (size_t i = 0; i < DIGEST_BYTES; i++) {
        int high = hex_value(hex[2 * i]);
        if (high < 0) return ERR_SYNTAX; /* also the end of a short text: look no further */
        int low = hex_value(hex[2 * i + 1]);
        if (low < 0) return ERR_SYNTAX;
        read.bytes[i] = (uint8_t)(high << 4 | low);
    }
    if (hex[DIGEST_HEX_BYTES - 1] != '\0') return ERR_SYNTAX;
    *out = read;
    return ERR_OK;
}
