#pragma once
/* Traces the mixed pixels of a tile (mixed_finder.h says which). Each gets mixed_samples(plan) rays
 * of its own, sixteen side by side, so that its entries do not depend on the tile.
 *
 * A pixel keeps its four samples where one of the rays shows a surface that none of the 3 x 3
 * pixels around shows. Only lone sub-samples have the light of such a surface. */
#include "worker/trace/field/mixed_finder.h"
#include "worker/trace/path/glossy_lobes.h"

/* Sixteen samples of one pixel. */
struct mixed_subs {
    int32_t x_px, y_px;
    _Alignas(LANES_ALIGN) float px[LANES];
    _Alignas(LANES_ALIGN) float py[LANES];
    _Alignas(LANES_ALIGN) float distance[LANES];
    _Alignas(LANES_ALIGN) uint32_t id[LANES]; /* surface_sub_id */
    struct lanes3 facing;                     /* along the world's axes */
    struct lanes3 point, normal;              /* camera space */
    struct lanes_mask on;                     /* show a surface */
};

/* The shares that each lender has in sixteen samples. */
struct mixed_shares {
    uint32_t lenders; /* bits of slots that are set */
    struct lanes_mask lent;
    _Alignas(LANES_ALIGN) float share[MIXED_SLOTS][LANES];
};

/* Sums over a pixel's samples, lane by lane. */
struct mixed_sums {
    uint32_t lenders;
    _Alignas(LANES_ALIGN) float value[MIXED_SLOTS][MIXED_VALUES_MAX][LANES];
    bool lone;
};

/* Emission over some samples: the sum, and whether some shine and others do not. */
struct mixed_glow {
    struct lanes3 sum;
    bool bright, dark;
};

struct mixed_found {
    uint32_t place;
    float value[MIXED_VALUES_MAX];
};

struct mixed_scratch {
    struct mixed_finder finder;
    struct mixed_found *entries; /* owned; kept from tile to tile */
    uint32_t count, capacity;
    struct path_vertex vertex;
    struct glossy_lobes lobes;
    struct RTCRayHit16 camera;
    struct mixed_subs subs;
    struct mixed_shares shares;
    struct mixed_sums sums;
    struct mixed_glow glow;
    struct counters counters;
};

void mixed_scratch_init(struct mixed_scratch *s);
void mixed_scratch_fini(struct mixed_scratch *s);

/* Adds the list of mixed pixels to the planes of a tile's first pass, and finds the emission of
 * those beside a lamp anew. `lone` has looked at all of the tile. Rays are counted as
 * COUNTER_RAYS_ANTIALIAS. ERR_MEMORY, ERR_STATE when stopped. */
int mixed_trace(const struct path_context *c, struct lone_finder *lone,
                struct mixed_scratch *scratch, struct samples *samples);
