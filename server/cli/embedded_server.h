#pragma once
/* A coordinator for one command: a child process on a free loopback port, with a temporary data
 * folder. */
#include <limits.h>
#include <sys/resource.h>
#include <sys/types.h>

#include "proto/error.h"

struct embedded_server {
    pid_t pid; /* 0: not running */
    char base_url[64];
    char data_dir[256];
};

#define EMBEDDED_SERVER_ALONE UINT_MAX /* no workers */

/* Starts it with `workers` local workers of `worker_threads` threads (0: the server's default), and
 * waits until it listens. */
int embedded_server_start(struct embedded_server *s, unsigned workers, unsigned worker_threads,
                          struct fault *fault);

/* Asks it to stop, waits, and removes its data. *usage, if not NULL, is that of the child and of
 * all processes that it waited for. Safe to call twice. */
void embedded_server_stop(struct embedded_server *s, struct rusage *usage);
