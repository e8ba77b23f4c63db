#include "proto/digest.h"

#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

struct digest_state {
    gnutls_hash_hd_t hash;
};

struct digest_state *digest_begin(void)
{
    struct digest_state *state = malloc(sizeof *state);
    if (state == NULL) return NULL;
    if (gnutls_hash_init(&state->hash, GNUTLS_DIG_SHA256) != GNUTLS_E_SUCCESS) {
        free(state);
        return NULL;
    }
    return state;
}

int digest_update(struct digest_state *state, const void *data, size_t size_bytes)
{
    if (size_bytes == 0) return ERR_OK;
    return gnutls_hash(state->hash, data, size_bytes) == GNUTLS_E_SUCCESS ? ERR_OK : ERR_STATE;
}

void digest_finish(struct digest_state **state, struct digest *out)
{
    gnutls_hash_deinit((*state)->hash, out->bytes);
    free(*state);
    *state = NULL;
}

void digest_of(const void *data, size_t size_bytes, struct digest *out)
{
    static const uint8_t nothing[1];
    const void *from = size_bytes != 0 ? data : nothing;
    /* The all-zero digest names nothing, so a failed hash can never be taken for a content. */
    if (gnutls_hash_fast(GNUTLS_DIG_SHA256, from, size_bytes, out->bytes) != GNUTLS_E_SUCCESS)
        memset(out, 0, sizeof *out);
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
