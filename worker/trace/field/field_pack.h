#pragma once
/* Few lanes of a block that trace rays of a field, laid side by side as often as they fit, each
 * time for another sample: kernels and packets are then as full as where all lanes trace. Without a
 * pack (NULL) slot i of a row is lane i, and a row is a sample. */
#include "worker/trace/path/path.h"

struct field_pack {
    uint32_t replicas;         /* samples of a lane in a row */
    uint32_t lane[LANES];      /* of each slot of a row */
    uint32_t part[LANES];      /* which of the row's samples it has */
    struct lanes_mask on;      /* slots that are in use */
    struct block block;        /* where the slots' lanes lie, */
    struct path_vertex vertex; /* and what they show */
};

/* Packs the lanes of *lanes, one at least. */
void field_pack_init(const struct block *block, const struct path_vertex *from,
                     const struct lanes_mask *lanes, struct field_pack *out);

static inline uint32_t field_pack_replicas(const struct field_pack *pack)
{
    return pack ? pack->replicas : 1;
}

/* Returns how many rows hold that many samples of each lane. */
static inline uint32_t field_pack_rows(const struct field_pack *pack, uint32_t samples)
{
    const uint32_t replicas = field_pack_replicas(pack);
    return (samples + replicas - 1) / replicas;
}

/* Returns the sample that a slot of a row has. */
static inline uint32_t field_pack_sample(const struct field_pack *pack, uint32_t row, int slot)
{
    return pack ? row * pack->replicas + pack->part[slot] : row;
}

/* What a sample has brought to a block's lanes, and how far away it met something, as path_radiance
 * has it. Lanes without one have zeros. */
struct field_sample {
    struct lanes3 radiance;
    _Alignas(LANES_ALIGN) float distance[LANES];
};

/* Takes sample `part` of a row whose slots in the batch begin at `first`. */
void field_pack_take(const struct field_pack *pack, const struct path_radiance *h, uint32_t first,
                     uint32_t part, struct field_sample *out);
