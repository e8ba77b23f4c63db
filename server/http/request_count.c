#include "server/http/request_count.h"

void request_count_add(struct request_count *c, enum route_id route, unsigned status)
{
    if (status >= STATUS_FIRST && status < STATUS_FIRST + STATUS_COUNT)
        c->ended[route][status - STATUS_FIRST]++;
}

void request_count_time(struct request_count *c, enum route_id route, uint64_t duration_us)
{
    duration_histogram_add(&c->durations[route], duration_us);
}
