#pragma once
/* Decides whether two samples show the same surface. The worker shades sub-samples that no pixel
 * around them shows, and reconstruction lights all others by these pixels. Both decide by the same
 * numbers, those that travel in planes.
 *
 * Points are in camera space (right, up, forward), relative to the eye, so that large coordinates
 * cost no precision. */
#include <math.h>
#include <stdbool.h>

#include "proto/plan.h"

struct shown_surface {
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

/* Returns the world size of a pixel at a distance. */
static inline float surface_pixel_size(const struct surface_view *view, float distance)
{
    return view->orthographic ? view->pixel_size : view->pixel_size * distance;
}

/* Larger distances, whose squares might not be finite, count as this. */
#define SURFACE_DISTANCE_MAX 1e16f
static inline float surface_distance(float distance)
{
    return distance < SURFACE_DISTANCE_MAX ? distance : SURFACE_DISTANCE_MAX;
}

/* Returns a sub-sample's distance from its number in PLANE_SUB_DEPTH and the distance of its pixel,
 * 0 for none. SUB_DEPTH_MISS gives 0. */
static inline float surface_sub_distance(float relative, float pixel, float length_unit)
{
    const float reference = pixel > 0.0f ? pixel : length_unit;
    return surface_distance((relative + 1.0f) * reference);
}

/* Returns a pixel's id as a sub-sample's plane has it. 0 means no surface there, so low bits of 0
 * read 0xffff. */
static inline uint32_t surface_sub_id(uint32_t id)
{
    const uint32_t low = id & 0xffffu;
    return low != 0 ? low : 0xffffu;
}

/* Sets what is seen at `distance` along the ray through image position (px, py); `normal` is along
 * the world's axes. */
void shown_surface_init(const struct surface_view *view, float px, float py, float distance,
                        const float normal[3], uint32_t id, struct shown_surface *out);

/* How much a sub-sample's surface is a pixel's, in [0, 1], and continuous in all but the id:
 *   normals   1 up to 10 degrees apart, 0 from 20 degrees (docs/reconstruction.md, Anti-aliasing)
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
float surface_match(const struct surface_view *view, const struct shown_surface *sub,
                    const struct shown_surface *pixel);

/* Ranks pixels where none matches: 0 looks alike, larger is less so. */
float surface_mismatch(const struct surface_view *view, const struct shown_surface *sub,
                       const struct shown_surface *pixel);

/* The angle between a pixel's surface and its ray, computed once a pixel, when first asked for. It
 * starts as zeros. */
struct surface_facing {
    bool known;
    float along, across; /* |cos| and at least the sine of the angle between ray and normal */
};

/* How far, at most, a sub-sample lies beside its pixel's centre (and a little for rounding), and
 * how far off the pixel's plane it may. */
#define SURFACE_CORNER_PX 0.71f
#define SURFACE_ROUNDING  0.999f
static inline float surface_corner(const struct surface_view *view, float sub)
{
    return SURFACE_CORNER_PX * surface_pixel_size(view, sub);
}

static inline float surface_allowed(const struct surface_view *view, float pixel, float sub)
{
    return SURFACE_ROUNDING * SURFACE_PLANE_PX *
           surface_pixel_size(view, pixel > sub ? pixel : sub);
}

/* Answers surface_near's first question: whether two distances above 0 are SURFACE_NEAR however the
 * surface faces. */
static inline bool surface_near_anyhow(const struct surface_view *view, float pixel, float sub)
{
    return surface_corner(view, sub) + fabsf(sub - pixel) <= surface_allowed(view, pixel, sub);
}

/* Whether a sub-sample anywhere in a pixel is sure to have surface_match 1 with it as far as points
 * go, by the two distances along their rays: with r and r' the unit rays, x' - x = d'(r' - r) + (d'
 * - d) r. Its part along n is at most d'|r' - r| sin + |d' - d| cos, cos = |r.n|, up to |r' - r|
 * itself in the sine; |r' - r| is at most a corner's pixels. Both factors are at most 1 with any
 * cos, which is asked first. */
enum surface_nearness { SURFACE_FAR, SURFACE_NEAR, SURFACE_NEAR_IF_FACING };
static inline enum surface_nearness surface_near(const struct surface_view *view, float pixel,
                                                 float sub)
{
    if (!(pixel > 0.0f) || !(sub > 0.0f)) return SURFACE_FAR;
    return surface_near_anyhow(view, pixel, sub) ? SURFACE_NEAR : SURFACE_NEAR_IF_FACING;
}

void surface_face(const struct surface_view *view, const struct shown_surface *pixel,
                  struct surface_facing *facing);
bool surface_near_facing(const struct surface_view *view, float pixel, float sub,
                         const struct surface_facing *facing);

/* Returns the weight of a pixel `column` columns and `row` rows beside a sub-sample's own, -1 ..
 * 1, of what the own pixel leaves: an eighth times a tent 3 pixels wide around the sub-sample,
 * which lies at `offset` in its pixel. */
float surface_share(const float offset[2], int32_t column, int32_t row);

/* Below this sum of shares times matches, no pixel shows the sub-sample's surface. */
#define SURFACE_WEIGHT_MIN 1e-6f
