#include "server/http/request_count.h"

void request_count_add(struct request_count *c, enum route_id route, unsigned status,
                       uint64_t duration_us)
{
    if (status >= STATUS_FIRST && status < STATUS_FIRST + STATUS_COUNT)
        c->ended[route][status - STATUS_FIRST]++;
    c->duration_us[route] += duration_us;
}
