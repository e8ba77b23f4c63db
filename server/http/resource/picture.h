#pragma once
/* Answers with a frame's picture: the finished file, the blocks so far, another layer or look,
 * or the pixel feed of a finished frame. Encoding runs on the pool. */
#include "server/http/request.h"
#include "server/stream/stream.h"

/* Returns the layer that the query asks for; default beauty. */
const char *picture_layer(const struct request *r);

/* Returns false, and sends a problem, for a name that is no layer's. */
bool picture_layer_is_known(struct request *r);

/* Reads what the query asks of the pixel feed: layer, format, alpha, after. Returns false, and
 * sends a problem, when it is malformed. The layer leads into the request's target. */
bool picture_pixels_request(struct request *r, struct pixels_request *out);

/* Answers with the pixel feed of the finished frame r->match.frame: all of it once, then the end.
 */
void picture_feed(struct request *r);
