#pragma once
/* The connection to a running tev, which listens on TCP and never answers. */
#include <stdbool.h>

#include "proto/error.h"
#include "server/cli/tev/tev_packet.h"

struct tev_link {
    char host[256], port[8];
    bool anywhere; /* not on loopback alone */
    int fd;        /* -1: not connected */
};

/* Parses "HOST:PORT", with IPv6 in brackets. ERR_SYNTAX, ERR_RANGE. */
int tev_link_parse(const char *text, bool anywhere, struct tev_link *link, struct fault *fault);

/* Connects to tev. ERR_UNSUPPORTED for a host that is not this machine unless `anywhere`; ERR_IO
 * when no process listens. */
int tev_link_connect(struct tev_link *link, struct fault *fault);

/* Sends a packet. ERR_IO: the connection is gone, and closed. */
int tev_link_send(struct tev_link *link, const struct tev_packet *packet);
void tev_link_close(struct tev_link *link);
