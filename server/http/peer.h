#pragma once
/* Who is connected, and how long each may take. */
#include <microhttpd.h>
#include <stdbool.h>
#include <stdint.h>

struct http;
struct request;

/* A connection, and the time until which the request on it must have arrived (or its answer gone).
 */
struct peer {
    struct peer *next, **link;
    struct http *http;
    int fd;
    uint64_t deadline_ms;    /* of the loop's clock; 0: none */
    struct request *request; /* in work; NULL between requests */
    bool cut;                /* shut down for want of room */
    bool served;             /* the last request was answered by its handler */
    bool lingers;            /* its socket will be emptied when it is closed (lingering.h) */
};

/* Sets the connection's deadline; 0 ms: none. */
void peer_deadline(struct peer *peer, uint64_t ms);

/* Its last answer is on its way while it may still send: the socket is kept after its end. */
void peer_linger(struct peer *peer);

/* Sends a bare problem answer past MHD and shuts the connection: for requests that MHD lets nobody
 * answer because their body has not ended. */
void peer_abort(struct peer *peer, unsigned status);

/* Its time is over. A request that has begun is told why; one that has not is only closed. */
void peer_expire(struct peer *peer);

/* MHD's, when connections begin and end: `context` is the connection's struct peer, `ctx` the
 * struct http. */
void peer_changed(void *ctx, struct MHD_Connection *connection, void **context,
                  enum MHD_ConnectionNotificationCode code);
