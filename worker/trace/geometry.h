#pragma once
/* The planes that describe surfaces: depth, normal, albedo, id, of pixel centres and of
 * anti-aliasing rays. */
#include "proto/samples.h"
#include "worker/trace/block.h"
#include "worker/trace/hit.h"

/* Of pixel centres; NULL where the plan does not ask for a plane. */
struct geometry_planes {
    float *depth;
    uint32_t *id, *normal;
    uint16_t *albedo[3];
};

/* Once a tile: blocks are too many to look planes up for each. */
void geometry_planes_init(struct geometry_planes *planes, const struct samples *samples);

void geometry_store(const struct queries *q, const struct block *b, const struct surface *s,
                    const struct geometry_planes *planes);

/* Anti-aliasing ray k; `centre` is the pixel's own surface, which its depth is relative to. */
void geometry_store_sub(const struct queries *q, const struct plan *plan, const struct block *b,
                        const struct surface *centre, const struct surface *sub, uint32_t k,
                        struct samples *samples);
