#pragma once
/* Resolves mixed pixels (proto/mixed.h): their light is that of the 3 x 3 pixels around, by the
 * shares and mean albedos that the worker has found with many samples. */
#include "server/reconstruct/compose/resolve.h"

/* Resolves pixel i from the patch's mixed entries, of which `first` is its own first. */
void resolve_mixed(const struct resolver *r, size_t i, uint32_t first, struct resolved *out);
