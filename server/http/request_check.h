#pragma once
/* Checks every request before its route is looked at: framing of the body, host, origin. */
#include "server/http/request.h"

/* What a request says about its body. */
struct body_claim {
    bool present;
    bool chunked;
    uint64_t size_bytes; /* 0 when chunked */
};

/* Returns true when the request may go on; else it has its answer. */
bool request_check(struct request *r, const char *version, struct body_claim *claim);

/* Returns whether the host is "localhost", "127.0.0.1" or "[::1]", with or without a port: names
 * that no page of another site can stand behind (DNS rebinding). */
bool request_check_host_is_local(const char *host);
