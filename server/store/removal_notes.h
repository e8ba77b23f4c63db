#pragma once
/* Notes of files that may be nobody's now, to be looked at until they are gone or somebody's
 * (asset_removal.h):
 *
 *   DIR/removals/ab/cdef...   of the object abcdef...
 *
 * Blocking, any thread, as marks.h. */
#include "server/store/marks.h"

/* Durable with 0. ERR_IO, ERR_NO_SPACE, ... */
int removal_notes_add(const struct objects *o, const struct digest *d);
/* One that stays by mistake does no harm, but to what is nobody's: whoever brings that takes its
 * note away while he holds it. */
void removal_notes_forget(const struct objects *o, const struct digest *d);
void removal_notes_each(const struct objects *o, marks_found each, void *ctx);
