#pragma once
/* The planes that describe surfaces: depth, normal, albedo, id, of pixel centres and of
 * anti-aliasing rays. */
#include "proto/samples.h"
#include "worker/trace/hit/block.h"
#include "worker/trace/hit/hit.h"

/* The planes of an anti-aliasing ray; NULL where the plan does not ask for a plane. */
struct geometry_sub_planes {
    uint16_t *depth, *normal, *id, *albedo[3];
};

/* The planes of pixel centres, and those of the anti-aliasing rays that there are. */
struct geometry_planes {
    float *depth;
    uint32_t *id, *normal;
    uint16_t *albedo[3];
    struct geometry_sub_planes sub[LIMIT_SUB_SAMPLES];
};

/* Looks the planes up once for each tile, since doing so for each block would take too long. */
void geometry_planes_init(struct geometry_planes *planes, const struct samples *samples);

void geometry_store(const struct queries *q, const struct block *b, const struct surface *s,
                    const struct geometry_planes *planes);

/* Does the same for an anti-aliasing ray; `centre` is the pixel's own surface, which its depth
 * is relative to, or the scene's unit of length where there is none. */
void geometry_store_sub(const struct queries *q, const struct block *b, float length_unit,
                        const struct surface *centre, const struct surface *sub,
                        const struct geometry_sub_planes *planes);
