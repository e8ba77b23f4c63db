#pragma once
/* What the nodes around a block show, above it and to its left: pixels in its first row and column
 * lie between these and nodes of the block. */
#include "proto/counter.h"
#include "proto/half_field.h"
#include "worker/trace/hit/block.h"
#include "worker/trace/hit/primary.h"

#define HALF_FIELD_RING 5

struct half_field_ring {
    struct surface_view view;
    struct surface surface;
    struct shown_surface shown[HALF_FIELD_RING];
    bool is_there[HALF_FIELD_RING]; /* in the image, and with a surface */
};

/* Traces rays through the centres of the nodes around the block. */
void half_field_ring_see(struct queries *q, const struct plan *plan, const struct block *block,
                         struct RTCRayHit16 *rays, struct half_field_ring *ring,
                         struct counters *counters);

/* Sets what lane i of a surface, which has been hit, shows through pixel (x, y). */
void half_field_show(const struct surface_view *view, const struct surface *s, int i, int32_t x,
                     int32_t y, struct shown_surface *out);

/* Returns whether all nodes of the ring that pixel (x, y) of the block at (x0, y0) lies beside show
 * its surface. */
bool half_field_ring_shows(const struct half_field_ring *ring, int32_t x0, int32_t y0, int32_t x,
                           int32_t y, const struct shown_surface *pixel);
