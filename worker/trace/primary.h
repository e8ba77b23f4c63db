#pragma once
/* Camera rays: one through every pixel's centre, and more for anti-aliasing. */
#include "proto/plan.h"
#include "worker/trace/block.h"
#include "worker/trace/hit.h"

/* Surfaces at the pixels' centres. Whole blocks are traced, also where they reach beyond the tile:
 * Embree may choose between two triangles at the same distance by the rays around, and these are
 * then the same for every tile. */
void primary_trace(struct queries *q, const struct plan *plan, const struct block *b,
                   struct RTCRayHit16 *rays, struct surface *out);

/* Surfaces at the pixels' anti-aliasing position k. */
void primary_trace_sub(struct queries *q, const struct plan *plan, const struct block *b,
                       uint32_t k, struct RTCRayHit16 *rays, struct surface *out);
