#pragma once
/* How many requests ended how, by route and status. */
#include <stdint.h>

#include "server/http/route.h"

#define STATUS_FIRST 100u
#define STATUS_COUNT 500u

/* The last row counts requests that met no route. */
struct request_count {
    uint64_t ended[ROUTE_COUNT + 1][STATUS_COUNT];
    uint64_t duration_us[ROUTE_COUNT + 1]; /* without streams */
};

void request_count_add(struct request_count *c, enum route_id route, unsigned status,
                       uint64_t duration_us);
