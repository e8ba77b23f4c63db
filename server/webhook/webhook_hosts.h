#pragma once
/* The hosts that an operator allows jobs to have told of their end. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"

#define WEBHOOK_HOSTS_MAX 64

struct webhook_host {
    char name[256]; /* lower case; an IPv6 address without brackets */
    uint16_t port;  /* 0: that of https, and of http */
};

struct webhook_hosts {
    struct webhook_host hosts[WEBHOOK_HOSTS_MAX];
    size_t count;
};

/* Reads "HOST[:PORT],...". ERR_SYNTAX, ERR_LIMIT. */
int webhook_hosts_read(const char *list, struct webhook_hosts *out, struct fault *fault);

/* Checks that a URL leads to one of the hosts, by the parser of the library that will call it.
 * hosts NULL: there are none. ERR_SYNTAX, ERR_UNSUPPORTED; the fault's pointer is /webhook/url. */
int webhook_hosts_check(const struct webhook_hosts *hosts, const char *url, struct fault *fault);
