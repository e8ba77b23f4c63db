#pragma once
/* Finds a tile's lone sub-samples (proto/lone.h): those whose surface no pixel of the 3 x 3 around
 * them shows, by the tile's planes. Pixels just outside the tile are traced at their first lookup,
 * in the same blocks as for any tile, so that the result does not depend on the tile. */
#include "proto/samples.h"
#include "proto/surface_match.h"
#include "worker/trace/path/path.h"

/* Pixel centres of a block beside the tile, as planes have them. */
struct lone_cell {
    bool traced;
    float depth[LANES];
    uint32_t normal[LANES], id[LANES];
};

/* Blocks along a side of the widest tile, and one beyond it at each end. */
#define LONE_SIDE_CELLS (LIMIT_TILE_SIDE_PX / LANES_ACROSS + 3)

/* A sub-sample's position in its pixel, and what it shows. */
struct lone_candidate {
    int32_t x_px, y_px;
    float offset[2];
    struct shown_surface surface;
};

/* What planes have of a block's pixels and of one sub-sample of each. */
struct lone_pixels {
    _Alignas(LANES_ALIGN) float depth[LANES];
    _Alignas(LANES_ALIGN) float distance[LANES];
    _Alignas(LANES_ALIGN) uint32_t normal[LANES];
    _Alignas(LANES_ALIGN) uint32_t id[LANES];
    _Alignas(LANES_ALIGN) uint32_t coarse[LANES]; /* the pixels' normals, packed as sub-samples' */
    _Alignas(LANES_ALIGN) uint32_t sub_depth[LANES], sub_normal[LANES];
    _Alignas(LANES_ALIGN) uint32_t sub_id[LANES];
    struct lanes3 facing;    /* the pixels' normals */
    struct lanes_mask alike; /* ids and normals of both, which show something */
    struct lanes_mask open;  /* kept, shows something, and not surely what the pixel shows */
    bool settled;            /* some sub_depth or sub_normal are those of the pixels now */
};

struct field_kernels;

struct lone_finder {
    const struct field_kernels *kernels;
    const struct path_context *context; /* of rays to pixel centres; its counters count them */
    struct samples *samples;
    struct rect tile, cells; /* cells: blocks that hold the tile and the pixels around it */
    struct surface_view view;
    struct lone_cell ring[4 * LONE_SIDE_CELLS]; /* top, bottom, left and right cells */
    struct RTCRayHit16 rays;
    struct surface surface;
    struct block block;
};

/* Prepares the finder for a tile. All is borrowed; the planes are PLANES_COMPARED. */
void lone_finder_init(struct lone_finder *f, const struct path_context *c, struct rect tile,
                      struct samples *samples);

/* Continues with what is known of the tile, by another context. */
void lone_finder_resume(struct lone_finder *f, const struct path_context *c);

/* Finds what the centre of a pixel shows, which lies in the tile or at most one pixel beside it.
 * *full_id, which may be NULL, becomes PLANE_ID's number. False: there is no surface, or no pixel
 * of the image. */
bool lone_finder_pixel(struct lone_finder *f, int32_t x, int32_t y, struct shown_surface *out,
                       uint32_t *full_id);

/* Finds the kept lanes of the block whose sub-sample k is lone and reflects light, and returns
 * their number. Sub-samples that surely show their pixel's surface get its depth and normal in the
 * planes: readers only ask whether they match, and equal values take the fewest bytes. */
uint32_t lone_finder_look(struct lone_finder *f, const struct block *b,
                          struct lanes_mask lone[LIMIT_SUB_SAMPLES]);

/* Does only the second part: writes the pixel's depth and normal. */
void lone_finder_settle(const struct lone_finder *f, const struct block *b);
