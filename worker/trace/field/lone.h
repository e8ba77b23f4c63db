#pragma once
/* Shades the lone sub-samples of a tile (proto/lone.h). Each gets as many strata of every light,
 * bounce rays and rays of its glossy lobe as the plan gives a pixel's centre, by the same
 * estimators. The result belongs to that sub-sample alone and is not filtered.
 *
 * Sub-sample k draws the numbers of a pixel (k + 1) LONE_ROWS rows below its own, beyond any
 * picture. Its samples are a function of seed, frame, pixel, sub-sample, sample and dimension.
 *
 * Sixteen are shaded side by side, from a square of LONE_SIDE_PX pixels that is aligned to the
 * image. The sides of tiles are multiples of it, so that a packet does not depend on the tile. */
#include "worker/trace/field/glossy.h"
#include "worker/trace/field/indirect.h"
#include "worker/trace/field/lone_finder.h"
#include "worker/trace/field/shadow.h"

#define LONE_SIDE_PX LIMIT_TILE_SIDE_MIN_PX
#define LONE_ROWS    LIMIT_IMAGE_SIDE_PX

/* A shaded sub-sample: an entry of the list. */
struct lone_shaded {
    uint32_t place;
    float light[LONE_PART_COUNT][3];
};

/* Between squares only the finder and the shaded sub-samples are kept. */
struct lone_scratch {
    struct lone_finder finder;
    struct plan plan; /* of lone sub-samples: planes of their light alone */
    struct counters counters;
    struct path_vertex met; /* what a block's rays met */
    struct RTCRayHit16 camera;
    struct path_vertex vertex; /* those at hand */
    struct block block;        /* they are elements of `samples` */
    uint32_t held;             /* of them, lanes 0 .. held - 1 */
    uint32_t place[LANES];
    struct shading_point point;
    struct samples *samples;    /* owned while a tile is traced */
    struct lone_shaded *shaded; /* owned; kept from tile to tile */
    uint32_t count, capacity;
};

/* The scratch memory of pixel centres. Borrowed. */
struct lone_tools {
    struct shadow_scratch *shadow;
    struct indirect_scratch *indirect;
    struct glossy_scratch *glossy;
    struct path_scratch *paths;
};

void lone_scratch_init(struct lone_scratch *s);
void lone_scratch_fini(struct lone_scratch *s);

/* Adds the list of lone sub-samples to the planes of a tile's first pass. `c` is the context of the
 * light field. Rays are counted as COUNTER_RAYS_LONE. ERR_MEMORY, ERR_STATE when stopped. */
int lone_trace(const struct path_context *c, const struct lone_tools *tools, struct rect tile,
               struct lone_scratch *scratch, struct samples *samples);

/* Settles the planes of sub-samples that surely show their pixel's surface (lone_finder_look), for
 * plans without a list. Does nothing if the planes for the decision are missing. */
void lone_settle(const struct path_context *c, struct rect tile, struct lone_scratch *scratch,
                 struct samples *samples);
