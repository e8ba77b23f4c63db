#pragma once
/* The key that coordinator and workers share: 64 hexadecimal digits in a file that nobody else may
 * read (`openssl rand -hex 32`). */
#include <stdint.h>

#include "proto/error.h"

#define LINK_KEY_BYTES 32

struct link_key {
    uint8_t bytes[LINK_KEY_BYTES];
};

/* ERR_SYNTAX, and what secret_file_read refuses. *fault names the file. */
int link_key_read(const char *path, struct link_key *out, struct fault *fault);
