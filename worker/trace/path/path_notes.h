#pragma once
/* Notes the surfaces that camera paths meet: features for filters, and colours of layers. */
#include "worker/trace/path/path.h"

/* Notes what the contexts' readers want of v, whose surfaces are resolved. */
void path_note(const struct path_context *c, const struct path_packet *p,
               const struct path_vertex *v, struct path_radiance *h);

/* Multiplies a slot's colour by lane i's tint. */
void path_dim(struct path_rgb *color, uint32_t slot, const struct lanes3 *tint, uint32_t i);
