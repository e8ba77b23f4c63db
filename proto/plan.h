#pragma once
/* The frame plan: all that a worker must know to trace any tile of a frame, and all that
 * reconstruction must know about what the samples mean. Made once by server/job, never changed. */
#include "proto/bytes.h"
#include "proto/digest.h"
#include "proto/error.h"
#include "proto/pattern.h"
#include "proto/tile.h"

enum camera_type { CAMERA_PERSPECTIVE = 0, CAMERA_ORTHOGRAPHIC = 1 };

/* right, up, forward: orthonormal, right-handed with right x up = -forward. A pixel (px, py) in
 * continuous coordinates maps to a = (2 px/width - 1)*half_width, b = (1 - 2
 * py/height)*half_height; perspective: direction = forward + a right + b up (not normalised) from
 * eye; orthographic: from eye + a right + b up along forward. */
struct plan_camera {
    uint32_t type;
    float eye[3], right[3], up[3], forward[3];
    float half_width, half_height; /* at distance 1, or scene units when orthographic */
};

enum light_type { LIGHT_POINT = 0, LIGHT_SPOT = 1, LIGHT_DIRECTIONAL = 2, LIGHT_RECTANGLE = 3 };
enum light_profile { PROFILE_UNIFORM = 0, PROFILE_GAUSSIAN = 1 };

/* One light. The irradiance at a receiver is color * E with a scalar E that the light's geometry
 * gives, averaged over its strata:
 *   point, spot      E = cone * window * max(0, n.w) / d^2            color: intensity, W/sr
 *   directional      E = max(0, n.w)                                  color: irradiance, W/m^2
 *   rectangle        E = mean over strata of I(y) max(0,n.w) max(0,-N.w) / d^2 * area
 *                                                                     color: radiance, W/sr/m^2
 * w points from the receiver to the light. cone: smoothstep-free glTF form,
 * clamp((cos - cos_outer)/(cos_inner - cos_outer), 0, 1)^2; window (range > 0):
 * clamp(1 - (d/range)^4, 0, 1); I: 1, or exp(-2 (u^2 + v^2)) for u, v in [-1, 1] (sigma = half
 * the half-side, filters.md section 2). A rectangle emits to the side of half_u x half_v. */
struct plan_light {
    uint32_t type;
    uint32_t profile;
    float position[3];  /* centre of a rectangle */
    float direction[3]; /* unit; the way the light travels; a rectangle's normal */
    float half_u[3], half_v[3];
    float color[3];
    float cos_inner, cos_outer;
    float range;              /* scene units; 0: none */
    float power;              /* relative, for choosing a light at a bounce; > 0 */
    uint32_t strata_per_axis; /* l; 1 for lights without area */
};

/* Which planes a tile's samples hold; samples.h says what they are. */
struct plan {
    struct digest scene;
    int32_t width_px, height_px;
    int32_t tile_px;
    struct pattern pattern;
    struct plan_camera camera;
    uint32_t light_count;
    struct plan_light lights[LIMIT_LIGHTS];
    uint32_t planes;       /* bits of enum plane_id, 1u << PLANE_ */
    uint32_t light_planes; /* bits of enum light_plane_id, for every light with area; lights
                              without area never have slopes */
    uint32_t sub_samples;  /* anti-aliasing rays a pixel, 0 .. LIMIT_SUB_SAMPLES */
    uint32_t bounces;      /* 0 .. LIMIT_INDIRECT_BOUNCES */
    uint32_t indirect_strata_per_axis; /* l; 0 without bounces */
    float radiance_scale;              /* a power of two: radiance * scale fits a half float */
    float length_unit;     /* a power of two near the scene's radius: lengths / unit fit one */
    uint32_t capabilities; /* what a worker needs, enum capability */
};

void plan_encode(struct bytes_writer *w, const struct plan *plan);

/* 0 or ERR_TRUNCATED, ERR_TRAILING, ERR_LIMIT, ERR_RANGE, ERR_NOT_FINITE; *fault names the field.
 * A decoded plan is safe to trace: camera and light vectors finite and not degenerate, all counts
 * within limits.h, planes consistent with bounces and sub_samples. */
int plan_decode(const void *data, size_t size_bytes, struct plan *out, struct fault *fault);

/* What plan_decode demands of a camera and of a light, for others who read such fields: finite,
 * within limits.h, axes orthonormal, areas and cones not degenerate. `place` ("cameras[2]")
 * precedes the field in *fault; a light's power and strata are not looked at. */
int plan_camera_check(const struct plan_camera *camera, const char *place, struct fault *fault);
int plan_light_check(const struct plan_light *light, const char *place, struct fault *fault);

/* Light k's planes under this plan: light_planes less what its type cannot have. */
uint32_t plan_light_planes(const struct plan *plan, uint32_t light);

/* The camera ray through continuous pixel position (px, py): origin, unit direction. */
void plan_camera_ray(const struct plan *plan, float px, float py, float origin[3],
                     float direction[3]);

/* World size of a pixel at `distance` along a unit camera ray (constant when orthographic). */
float plan_pixel_size(const struct plan *plan, float distance);
