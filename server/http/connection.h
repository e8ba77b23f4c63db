#pragma once
/* The open connections, and the deadline of each. */
#include <microhttpd.h>
#include <stdbool.h>
#include <stdint.h>

struct http;
struct request;

/* A connection, and the time until which the request on it must have arrived (or its answer gone).
 */
struct connection {
    struct connection *next, **link;
    struct http *http;
    int fd;
    uint64_t deadline_ms;    /* of the loop's clock; 0: none */
    struct request *request; /* in work; NULL between requests */
    bool cut;                /* shut down for want of room */
    bool served;             /* the last request was answered by its handler */
    bool lingers;            /* its socket will be emptied when it is closed (linger.h) */
};

/* Sets the connection's deadline; 0 ms: none. */
void connection_deadline(struct connection *connection, uint64_t ms);

/* Keeps the socket after the connection's end, since its last answer is on its way while the client
 * may still send. */
void connection_linger(struct connection *connection);

/* Sends a bare problem answer past MHD and shuts the connection down, for requests that MHD does
 * not let us answer because their body has not ended. */
void connection_abort(struct connection *connection, unsigned status);

/* Ends a connection whose time is over. A request that has begun gets an answer; otherwise the
 * connection is only closed. */
void connection_expire(struct connection *connection);

/* Notes that connections begin and end. Called by MHD: `context` is the connection's struct
 * connection, `ctx` the struct http. */
void connection_changed(void *ctx, struct MHD_Connection *mhd, void **context,
                        enum MHD_ConnectionNotificationCode code);
