#pragma once
/* What a batch of a field's paths has brought to sixteen pixels, sample by sample, and where in the
 * batch it lies. Where only the nodes of a block trace (proto/half_field.h), four samples share the
 * slots of one, so that packets are full all the same. */
#include <string.h>

#include "proto/half_field.h"
#include "worker/trace/path/path_pool.h"

#define FIELD_NODES 4u /* of a block */

/* A batch of samples `first` on; `packed` where no lane but the nodes has any. */
struct field_batch {
    uint32_t first, count;
    bool packed;
};

/* Returns the next batch of `rays` samples, of which `done` are traced. */
static inline struct field_batch field_batch_next(uint32_t done, uint32_t rays, bool packed)
{
    const uint32_t left = rays - done;
    const uint32_t most = packed ? PATH_SLOTS / FIELD_NODES : PATH_SAMPLES;
    return (struct field_batch){done, left < most ? left : most, packed};
}

/* Returns how many times sixteen slots the batch has. */
static inline uint32_t field_batch_rows(const struct field_batch *b)
{
    const uint32_t together = LANES / FIELD_NODES;
    return b->packed ? (b->count + together - 1) / together : b->count;
}

/* Returns the slot of the batch's sample k of a lane, which is a node's in a packed batch. */
static inline uint32_t field_batch_slot(const struct field_batch *b, uint32_t k, uint32_t lane)
{
    const uint32_t across = lane % LANES_ACROSS / 2, down = lane / LANES_ACROSS / 2;
    return b->packed ? k * FIELD_NODES + down * 2 + across : k * LANES + lane;
}

/* A sample: what it brings, and how far away it met something, as path_radiance has it. Lanes
 * without one have zeros. */
struct field_sample {
    struct lanes3 radiance;
    _Alignas(LANES_ALIGN) float distance[LANES];
};

static inline void field_sample_take(const struct path_radiance *h, const struct field_batch *b,
                                     uint32_t k, struct field_sample *out)
{
    if (!b->packed) {
        const size_t first = (size_t)k * LANES;
        memcpy(out->radiance.x, h->indirect.r + first, sizeof out->radiance.x);
        memcpy(out->radiance.y, h->indirect.g + first, sizeof out->radiance.y);
        memcpy(out->radiance.z, h->indirect.b + first, sizeof out->radiance.z);
        memcpy(out->distance, h->distance + first, sizeof out->distance);
        return;
    }
    memset(out, 0, sizeof *out);
    for (uint32_t i = 0; i < LANES; i++) {
        if (!half_field_is_node((int32_t)(i % LANES_ACROSS), (int32_t)(i / LANES_ACROSS))) continue;
        const uint32_t slot = field_batch_slot(b, k, i);
        out->radiance.x[i] = h->indirect.r[slot];
        out->radiance.y[i] = h->indirect.g[slot];
        out->radiance.z[i] = h->indirect.b[slot];
        out->distance[i] = h->distance[slot];
    }
}
