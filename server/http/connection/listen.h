#pragma once
/* Opens the listening socket. It listens beyond loopback only with tokens and TLS. */
#include <stdbool.h>

#include "proto/error.h"

/* The most unsent bytes that the system keeps for a client that reads nothing. */
#define LISTEN_UNSENT_BYTES 262144

struct listen_guards {
    bool tokens, tls;
};

/* Listens on "127.0.0.1:8040", "[::1]:8040", "localhost:0". *fd is a non-blocking socket, owned by
 * the caller, and *port its port. ERR_SYNTAX, ERR_RANGE, ERR_UNSUPPORTED (not a loopback address,
 * and not both guards), ERR_IO. */
int listen_open(const char *address, const struct listen_guards *guards, int *fd, int *port,
                struct fault *fault);
