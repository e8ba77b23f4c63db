#pragma once
/* Camera rays: one through every pixel's centre, and more for anti-aliasing. */
#include "proto/plan.h"
#include "worker/trace/hit/block.h"
#include "worker/trace/hit/hit.h"

/* Embree's own bound is 1e18; farther origins abort the process. */
#define ORIGIN_MAX 1e18f

/* Finds the surfaces at the pixels' centres. Whole blocks are traced, also where they reach beyond
 * the tile: Embree may choose between two triangles at the same distance by the rays around, and
 * these are then the same for every tile. */
void primary_trace(struct queries *q, const struct plan *plan, const struct block *b,
                   struct RTCRayHit16 *rays, struct surface *out);

/* The camera rays of a block: fields that no query changes as queries_init_rays left them. */
struct primary_packet {
    struct RTCRayHit16 rays;
    struct lanes_mask valid; /* inside the image, and fit for Embree */
};

/* Blocks that are traced together. Their rays are made at once, and Embree's answers still stay in
 * the first-level cache. */
#define PRIMARY_ROW 8

/* Traces `count` blocks side by side, the first at (x, y), for hit_resolve. */
void primary_trace_row(struct queries *q, const struct plan *plan, int32_t x, int32_t y,
                       uint32_t count, struct primary_packet *row);

/* Traces rays to sixteen positions in one pixel: `first` to first + 15 of `count` that are spread
 * all over it (pattern_golden_at). They lie at (px, py) of the image. */
void primary_trace_pixel(struct queries *q, const struct plan *plan, int32_t x, int32_t y,
                         uint32_t first, uint32_t count, struct RTCRayHit16 *rays, float px[LANES],
                         float py[LANES], struct surface *out);

/* Finds the surfaces at anti-aliasing position k of `count` in each pixel. */
void primary_trace_sub(struct queries *q, const struct plan *plan, const struct block *b,
                       uint32_t k, uint32_t count, struct RTCRayHit16 *rays, struct surface *out);
