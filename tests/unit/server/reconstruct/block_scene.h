#pragma once
/* A picture of two surfaces with an edge between them, from samples that are computed from their
 * place, and its reconstruction block by block. */
#include <stdbool.h>

#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/synthetic.h"
#include "tests/unit/unit.h"

#define ALL_LAYERS 0xfffu
#define PI         3.14159265358979f

/* A picture of two surfaces: what is left of the edge (in pixel coordinates, slanted) is near. */
struct world {
    float edge_x,
        slant; /* the edge's x at row y is edge_x + slant y; edge_x < 0: only the far one */
    bool far_missing;
    float slat_px; /* how wide the near one is; 0: all that is left of the edge */
    float near_depth, far_depth;
    float near_light, far_light; /* irradiance */
    float near_albedo, far_albedo;
    float normal_turn; /* radians between the two normals */
    uint32_t near_id, far_id;
    float tilt; /* of the far plane against the view, radians */
};

extern const struct world plain;

struct samples *world_tile(const struct plan *plan, const struct world *w, uint32_t tile);

/* Lands all tiles, reconstructs all blocks. w NULL: the synthetic scene. */
struct image *render(const struct plan *plan, const struct world *w, int32_t block_px,
                     int32_t more_halo_px, struct block_statistics *sum, double *seconds);

static inline void make_plan(struct plan *plan, int32_t width, int32_t height)
{
    synthetic_plan(plan, width, height, 32);
}
