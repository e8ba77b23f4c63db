#pragma once
/* Empty files that say something of objects:
 *
 *   DIR/KIND/ab/cdef...   a mark of that kind on the object abcdef...
 *
 * KIND is a short relative path without surprises, which callers see to. Plain blocking calls
 * without shared state, for any thread, as objects.h. */
#include "server/store/objects.h"

/* Durable with 0; existed: it was there. ERR_IO, ERR_LIMIT, ... */
int marks_add(const struct objects *o, const char *kind, const struct digest *d, bool *existed);
/* Durable with 0. ERR_NOT_FOUND when there is none. */
int marks_remove(const struct objects *o, const char *kind, const struct digest *d);
bool marks_have(const struct objects *o, const char *kind, const struct digest *d);

/* All of a kind, in no order. each may remove what it is called with. ERR_IO, ERR_LIMIT. */
typedef void (*marks_found)(void *ctx, const struct digest *d);
int marks_each(const struct objects *o, const char *kind, marks_found each, void *ctx);
