#pragma once
/* How a client asks to see a picture: the parameters of image.png. */
#include "server/http/request.h"
#include "server/image/png_shade.h"

/* Lays view, exposure, bits and alpha of the query over a layer's options. False, and a problem is
 * sent, for a value that none of them has. */
bool png_query_read(struct request *r, const struct png_options *otherwise,
                    struct png_options *out);

/* Returns whether two options give the same bytes. */
bool png_query_is_same(const struct png_options *a, const struct png_options *b);
