#pragma once
/* The listening socket. Loopback only: anything wider needs tokens and TLS, which this version does
 * not have. */
#include "proto/error.h"

/* "127.0.0.1:8040", "[::1]:8040", "localhost:0". A non-blocking socket in *fd, owned by the caller,
 * its port in *port. ERR_SYNTAX, ERR_RANGE, ERR_UNSUPPORTED (not a loopback address), ERR_IO. */
int listen_open(const char *address, int *fd, int *port, struct fault *fault);
