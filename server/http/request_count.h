#pragma once
/* Counts answered requests by route and status. */
#include <stdint.h>

#include "server/http/route.h"
#include "server/metric/duration_histogram.h"

#define STATUS_FIRST 100u
#define STATUS_COUNT 500u

/* The last row counts requests that met no route. */
struct request_count {
    uint64_t ended[ROUTE_COUNT + 1][STATUS_COUNT];
    struct duration_histogram durations[ROUTE_COUNT + 1]; /* of ended requests, without streams */
};

static inline void request_count_add(struct request_count *c, enum route_id route, unsigned status)
{
    if (status >= STATUS_FIRST && status < STATUS_FIRST + STATUS_COUNT)
        c->ended[route][status - STATUS_FIRST]++;
}
