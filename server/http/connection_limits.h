#pragma once
/* What many clients together may hold: connections and the memory of bodies. Where that is used up
 * those go who have been at it longest without having said what they want, so that whoever comes
 * and speaks at once is served, however many others only hold the line. */
#include <stddef.h>

struct http;
struct request;

#define CONNECTION_SPARE        64u         /* kept free for new connections; at most an eighth */
#define CONNECTION_BODIES_BYTES (16u << 20) /* of JSON bodies that have not been answered */

/* Cuts some of the oldest connections off whose request is not whole, if few are left. */
void connection_limits_make_room(struct http *http);

/* Makes room for more of the request's body: the oldest others go, with 503. */
void connection_limits_make_body_room(struct http *http, const struct request *for_whom,
                                      size_t more_bytes);
