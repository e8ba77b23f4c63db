#include "server/http/connection_limits.h"

#include <stdlib.h>
#include <sys/socket.h>

#include "server/http/request.h"

#define CUT_AT_ONCE 32u

/* It has not said what it wants, or takes its time with it. Uploads have a bound of their own. */
static bool is_idle(const struct connection *p)
{
    const struct request *r = p->request;
    return !p->cut && (!r || (!r->handled && !r->pending && !r->upload && r->status == 0));
}

/* Newest connections come first in the list, so the last ones found are the oldest. */
void connection_limits_make_room(struct http *http)
{
    struct connection *oldest[CUT_AT_ONCE];
    size_t found = 0;
    const unsigned eighth = http->connections_max / 8;
    const unsigned spare = eighth < CONNECTION_SPARE ? eighth : CONNECTION_SPARE;
    if (http->connections + spare < http->connections_max) return;
    for (struct connection *p = http->open; p; p = p->next)
        if (is_idle(p)) oldest[found++ % CUT_AT_ONCE] = p;
    for (size_t i = 0; i < found && i < CUT_AT_ONCE; i++) {
        oldest[i]->cut = true;
        oldest[i]->deadline_ms = 0;
        (void)shutdown(oldest[i]->fd, SHUT_RDWR);
        http->connections_cut++;
    }
}

static struct request *oldest_body(const struct http *http, const struct request *but)
{
    struct request *oldest = NULL;
    for (struct connection *p = http->open; p; p = p->next) {
        struct request *r = p->request;
        if (r && r != but && r->body_bytes > 0 && !r->handled && !r->pending && r->status == 0)
            oldest = r;
    }
    return oldest;
}

void connection_limits_make_body_room(struct http *http, const struct request *for_whom,
                                      size_t more_bytes)
{
    while (http->body_room_bytes + more_bytes > CONNECTION_BODIES_BYTES) {
        struct request *r = oldest_body(http, for_whom);
        if (!r) return;
        http->body_room_bytes -= r->body_room_bytes;
        free(r->body);
        r->body = NULL;
        r->body_bytes = r->body_room_bytes = 0;
        r->status = 503;
        connection_abort(r->connection, 503);
    }
}
