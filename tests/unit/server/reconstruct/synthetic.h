#pragma once
/* A scene made of formulas for film and reconstruction tests: what every pixel holds is a pure
 * function of its place, so that any cut of the image can be checked against it. */
#include <stdint.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "proto/samples.h"

struct synthetic_pixel {
    float depth, normal[3], albedo[3];
    uint32_t id;
    float sub_depth[LIMIT_SUB_SAMPLES];
    float indirect[3];
    float bounce_distance_min, open; /* eighths, so that halves hold them */
    float irradiance;
    uint32_t visibility; /* 9 bits */
};

/* One rectangle light of 3 x 3 strata, one bounce, three sub-samples, all planes of that. */
void synthetic_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px);

/* A tilted floor with a checkerboard of ids, and holes where x + y is a multiple of 11. */
struct synthetic_pixel synthetic_pixel(const struct plan *plan, int32_t x, int32_t y);

uint16_t synthetic_sub_id(uint32_t id);
void synthetic_put_bounces(struct samples *s, const struct plan *plan, size_t i,
                           const struct synthetic_pixel *p);
void synthetic_put(struct samples *s, const struct plan *plan, size_t i,
                   const struct synthetic_pixel *p);

/* Owned by the caller; NULL on failed allocation. */
struct samples *synthetic_tile(const struct plan *plan, uint32_t tile);
/* Does the same, for picture_land. */
struct samples *synthetic_tile_of(const struct plan *plan, uint32_t tile, const void *ctx);
