#pragma once
/* Do two samples show the same surface? Points are in camera space (right, up, forward), relative
 * to the eye, so that large coordinates cost no precision. */
#include <stdbool.h>

#include "server/reconstruct/patch.h"

struct surface {
    float point[3];  /* camera space */
    float normal[3]; /* camera space, unit */
    float distance;  /* along the camera ray; 0: no surface */
    uint32_t id;     /* as in PLANE_SUB_ID */
};

/* The camera as the comparison needs it. */
struct surface_view {
    const struct plan_camera *camera; /* borrowed */
    bool orthographic;
    float a_step, b_step;   /* plane coordinates a pixel */
    float a_start, b_start; /* at pixel position 0 */
    float pixel_size;       /* world size of a pixel at distance 1; everywhere if orthographic */
};

void surface_view_init(struct surface_view *view, const struct plan *plan);

/* World size of a pixel at a distance. */
float surface_pixel_size(const struct surface_view *view, float distance);

/* Points at `depth` along the rays through the centres of `count` pixels from image pixel (x, y)
 * on, relative to the eye, along the world's axes; depth 0 gives 0 of a perspective camera. */
void surface_points(const struct surface_view *view, int32_t x, int32_t y, uint32_t count,
                    const float *restrict depth, float *restrict px, float *restrict py,
                    float *restrict pz);

/* Pixel i of the patch (the ray through its centre) and sub-sample k of it, which lies at `offset`
 * within the pixel. False when there is no surface. */
bool surface_of_pixel(const struct surface_view *view, const struct patch *patch, size_t i,
                      struct surface *out);
bool surface_of_sub(const struct surface_view *view, const struct patch *patch, size_t i,
                    uint32_t k, const float offset[2], struct surface *out);

/* How much a sub-sample's surface is a pixel's, in [0, 1], and continuous in all but the id:
 *   normals   1 up to 10 degrees apart, 0 from 20 degrees (filters.md section 2)
 *   points    1 while the sub-sample is off the pixel's tangent plane by no more than
 *             1.5 pixels + |x - x'| (sin of the normals' angle + 0.03), 0 from 1.5 times that. The
 *             second term is a curved surface's sagitta; 0.03 covers 8-bit normals and the half
 *             floats of sub-sample depths
 *   ids       another id counts 1/64: enough to win where nothing else matches
 */
#define SURFACE_COS_FULL 0.984807753f
#define SURFACE_COS_NONE 0.939692621f
#define SURFACE_PLANE_PX 1.5f
#define SURFACE_SLACK    0.03f
#define SURFACE_FADE     1.5f
#define SURFACE_OTHER_ID 0.015625f
float surface_match(const struct surface_view *view, const struct surface *sub,
                    const struct surface *pixel);

/* How a pixel's surface stands to its ray: computed once a pixel, when first asked for. */
struct surface_facing {
    bool known;
    float along, across; /* |cos| and at least the sine of the angle between ray and normal */
};

/* True only when surface_match of pixel i and its own sub-sample k is 1, whatever the sub-sample's
 * place in the pixel: most of a picture is decided by it. False says nothing. *facing belongs to
 * pixel i and starts as zeros. */
bool surface_surely_same(const struct surface_view *view, const struct patch *patch, size_t i,
                         uint32_t k, struct surface_facing *facing);

/* For the nearest-looking one where nothing matches: 0 is like, larger is less so. */
float surface_mismatch(const struct surface_view *view, const struct surface *sub,
                       const struct surface *pixel);
