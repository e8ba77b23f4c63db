#pragma once
/* Limits what all clients together may hold: connections, and memory for bodies. When a limit is
 * reached, the oldest connections or bodies whose request is not whole are cut off. So a client
 * that sends its request at once is served, however many others hold connections open. */
#include <stddef.h>

struct http;
struct request;

#define CONNECTION_SPARE        64u         /* kept free for new connections; at most an eighth */
#define CONNECTION_BODIES_BYTES (16u << 20) /* of JSON bodies that have not been answered */

/* Cuts off some of the oldest connections whose request is not whole, if few are left. */
void connection_limits_make_room(struct http *http);

/* Makes room for more of the request's body: the oldest other bodies go, with 503. */
void connection_limits_make_body_room(struct http *http, const struct request *for_whom,
                                      size_t more_bytes);
