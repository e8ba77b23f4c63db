#pragma once
/* The depth of one frame: what was measured, and how sure that is. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "server/import/rgbd/rgbd_document.h"
#include "server/import/scene/warnings.h"

/* All arrays are owned and have a value a pixel, rows from the top. */
struct depth_map {
    int32_t width, height;
    float *z;     /* metres along the camera's axis; 0: not known */
    float *sure;  /* measurements that z is worth; 0: not known, below 1: filled in */
    float *color; /* rgb, linear; NULL: not read */
};

/* Returns what a sensor's measurement of a depth is off by, its standard deviation in metres, as
 * Nguyen, Izadi and Lovell 2012 measured it. */
static inline float depth_noise_m(float z)
{
    const float off = z > 0.4f ? z - 0.4f : 0.0f;
    return 0.0012f + 0.0019f * off * off;
}

/* Computes the normal of the surface that a pixel shows at z, where 1/z has these slopes a pixel to
 * the right and down: away from the camera, and not normalised, so that along the pixel's ray,
 * where z grows by one, it is 1/z. */
static inline void depth_normal(const struct rgbd_document *d, int32_t x, int32_t y, float z,
                                const float slopes[2], double out[3])
{
    out[0] = (double)slopes[0] * d->fx;
    out[1] = (double)slopes[1] * d->fy;
    out[2] = 1 / (double)z - (double)slopes[0] * (x - d->cx) - (double)slopes[1] * (y - d->cy);
}

/* Reads the depth of a frame, and with_color its colours. Faults name the frame's members:
 * ERR_MISMATCH for sizes that differ, ERR_MISSING where no pixel has a depth, ERR_LIMIT. The caller
 * owns *out. */
int depth_map_read(const struct rgbd_document *d, struct files *files, uint32_t frame,
                   bool with_color, struct depth_map *out, struct warnings *warnings,
                   struct fault *fault);
void depth_map_destroy(struct depth_map *map);

/* Takes away what lies between two surfaces and belongs to none, as sensors report it at edges. */
void depth_map_drop_strays(struct depth_map *map);

/* Improves z by what another frame measured of the same points, and fills in what only that frame
 * saw. to_other: from this frame's camera to the other's. ERR_MEMORY. */
int depth_map_fuse(struct depth_map *map, const struct depth_map *other,
                   const struct rgbd_document *d, const struct affine *to_other,
                   const struct affine *from_other, struct fault *fault);

/* Filters z along surfaces, as the colours tell them apart, and fills in small holes. ERR_MEMORY.
 */
int depth_map_smooth(struct depth_map *map, struct fault *fault);
