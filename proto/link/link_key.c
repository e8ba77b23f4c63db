#include "proto/link/link_key.h"

#include <gnutls/gnutls.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/secret_file.h"

#define FILE_BYTES 256u

static int digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* The digits, and nothing behind them but the end of the line. */
static bool decode(const char *text, struct link_key *out)
{
    for (size_t i = 0; i < LINK_KEY_BYTES; i++, text += 2) {
        const int high = digit(text[0]), low = high < 0 ? -1 : digit(text[1]);
        if (low < 0) return false;
        out->bytes[i] = (uint8_t)(high * 16 + low);
    }
    return text[strspn(text, "\r\n")] == '\0';
}

int link_key_read(const char *path, struct link_key *out, struct fault *fault)
{
    char *text = NULL;
    size_t size_bytes = 0;
    int error = secret_file_read(path, SECRET_READERS_NONE, FILE_BYTES, &text, &size_bytes, fault);
    if (error) return error;
    if (!decode(text, out))
        error = fault_set(fault, ERR_SYNTAX, path,
                          "a key has 64 hexadecimal digits: openssl rand -hex 32 makes one");
    gnutls_memset(text, 0, size_bytes);
    free(text);
    return error;
}
