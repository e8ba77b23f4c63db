#pragma once
/* The key that coordinator and workers share: 64 hexadecimal digits in a file that only its owner
 * can read (`openssl rand -hex 32`), or that root gives to our group. */
#include <stdint.h>

#include "proto/error.h"

#define LINK_KEY_BYTES 32

struct link_key {
    uint8_t bytes[LINK_KEY_BYTES];
};

/* Reads a key. ERR_SYNTAX, or what secret_file_read returns. *fault names the file. */
int link_key_read(const char *path, struct link_key *out, struct fault *fault);
