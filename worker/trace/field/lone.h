#pragma once
/* Shades the lone sub-samples of a tile (proto/lone.h): each by as many strata of every light,
 * bounce rays and rays of its glossy lobe as the plan gives a pixel's centre, of its own surface,
 * by the same estimators; what they bring is kept for that sub-sample alone and not filtered.
 *
 * Sub-sample k draws the numbers of a pixel (k + 1) LONE_ROWS rows below its own, where no picture
 * reaches: its samples are a function of seed, frame, pixel, sub-sample, sample and dimension.
 *
 * Sixteen are shaded side by side, those of a square of LONE_SIDE_PX pixels that is aligned to the
 * image: who travels together does not depend on the tile, whose sides are multiples of it. */
#include "worker/trace/field/glossy.h"
#include "worker/trace/field/indirect.h"
#include "worker/trace/field/lone_finder.h"
#include "worker/trace/field/shadow.h"

#define LONE_SIDE_PX LIMIT_TILE_SIDE_MIN_PX
#define LONE_ROWS    LIMIT_IMAGE_SIDE_PX

/* One that was shaded: what an entry of the list holds. */
struct lone_shaded {
    uint32_t place;
    float light[LONE_PART_COUNT][3];
};

/* Between squares nothing of it is kept but finder and shaded ones. */
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

/* Scratch that pixels are shaded with. Borrowed. */
struct lone_tools {
    struct shadow_scratch *shadow;
    struct indirect_scratch *indirect;
    struct glossy_scratch *glossy;
    struct path_scratch *paths;
};

void lone_scratch_init(struct lone_scratch *s);
void lone_scratch_fini(struct lone_scratch *s);

/* Of a tile's first pass, whose planes `samples` holds: adds its list. `c` is the context of the
 * light field. Rays go to COUNTER_RAYS_LONE. ERR_MEMORY, ERR_STATE when stopped. */
int lone_trace(const struct path_context *c, const struct lone_tools *tools, struct rect tile,
               struct lone_scratch *scratch, struct samples *samples);

/* Where nothing lights them, too: sub-samples that surely show their pixel's surface say only so
 * (lone_finder_look). Nothing of planes without what tells. */
void lone_settle(const struct path_context *c, struct rect tile, struct lone_scratch *scratch,
                 struct samples *samples);
