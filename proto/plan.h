#pragma once
/* The frame plan: all that a worker must know to trace any tile of a frame, and all that
 * reconstruction must know about what the samples mean. Made once by server/job, never changed. */
#include <stdbool.h>

#include "proto/bytes.h"
#include "proto/digest.h"
#include "proto/error.h"
#include "proto/pattern.h"
#include "proto/shutter.h"
#include "proto/tile.h"

enum camera_type { CAMERA_PERSPECTIVE = 0, CAMERA_ORTHOGRAPHIC = 1 };

/* right, up, forward: orthonormal, right-handed with right x up = -forward. A pixel (px, py) in
 * continuous coordinates maps to a = (2 px/width - 1)*half_width, b = (1 - 2
 * py/height)*half_height; perspective: direction = forward + a right + b up (not normalised) from
 * eye; orthographic: from eye + a right + b up along forward.
 *
 * A thin lens (aperture_radius > 0, perspective only): the ray starts at eye + radius (s right + t
 * up) with (s, t) uniform over the aperture (a disc, or a regular polygon of blade_count corners on
 * the unit circle, the first at angle blade_rotation_rad from right towards up), and passes through
 * eye + focus_distance * (forward + a right + b up): what is sharp is a plane. */
struct plan_camera {
    uint32_t type;
    float eye[3], right[3], up[3], forward[3];
    float half_width, half_height; /* at distance 1, or scene units when orthographic */
    float centre_x, centre_y;      /* where forward meets the image: -1 left or bottom, 0 middle */
    float aperture_radius;         /* scene units; 0: a pinhole */
    float focus_distance;          /* scene units along forward; > 0 with a lens */
    uint32_t blade_count;          /* 0: round; else 3 .. LIMIT_LENS_BLADES */
    float blade_rotation_rad;
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
 * the half-side; docs/reconstruction.md, Receiver coordinates). A rectangle emits to the side of
 * half_u x half_v. */
struct plan_light {
    uint32_t type;
    uint32_t profile;
    float position[3];  /* centre of a rectangle */
    float direction[3]; /* unit; the way the light travels; a rectangle's normal */
    float half_u[3], half_v[3];
    float color[3];
    float cos_inner, cos_outer;
    float range;              /* scene units; 0: none */
    float power;              /* relative, for the environment's share; > 0 */
    uint32_t strata_per_axis; /* l; 1 for lights without area */
};

/* Light from infinitely far around. A map is latitude-longitude: u = 0.5 + atan2(z, x)/2 pi, v =
 * acos(y)/pi from the top row, of the direction after turning the world by -rotation_rad about +y
 * (the map turns by +rotation_rad: what it shows along +x then lies along (cos, 0, sin)). */
enum environment_kind { ENVIRONMENT_NONE = 0, ENVIRONMENT_CONSTANT = 1, ENVIRONMENT_MAP = 2 };
struct plan_environment {
    uint32_t kind;
    struct digest map;  /* blob of proto/scene/environment.h; zero unless MAP */
    float radiance[3];  /* CONSTANT: from everywhere; MAP: factor of the texels */
    float rotation_rad; /* of a map */
    float power;        /* relative to the lights'; > 0 unless NONE */
};

/* What paths leave out of the light that reaches the first surface directly, since light fields of
 * pixel centres bring it: nothing; whatever the diffuse lobe sends on; what it sends on of the
 * plan's lights. Where all is left there is no environment, and indirect light of that lobe is left
 * out, too, if there are bounces. */
enum direct_left { DIRECT_LEFT_NONE = 0, DIRECT_LEFT_ALL = 1, DIRECT_LEFT_LISTED = 2 };

/* What the first surface's diffuse lobe would send on and paths leave to the indirect planes: none;
 * light that was scattered before; that, and the environment's soft share (PLAN_SKY_SOFT_TIMES). */
enum indirect_left { INDIRECT_LEFT_NONE = 0, INDIRECT_LEFT_SCATTERED = 1, INDIRECT_LEFT_SKY = 2 };

/* The path tracer: `spp` paths a pixel, each through its own point of the pixel filter (a box: the
 * pixel; a tent: two pixels wide, falling off linearly from the centre) and of the lens, with up to
 * `bounces` scatterings after the first. A frame's paths are traced in passes, tile by tile: pass
 * 0, then 1 and so on of each tile, so that sums grow in one order whatever the machines. */
enum pixel_filter { PIXEL_FILTER_BOX = 0, PIXEL_FILTER_TENT = 1 };
struct plan_paths {
    uint32_t spp;          /* 0: no paths */
    uint32_t pixel_filter; /* enum pixel_filter: where paths leave around the pixel's centre */
    float emitter_power;   /* of all mesh emitters together, relative to the lights'; 0: none */
    uint32_t without_diffuse_indirect; /* enum indirect_left */
    uint32_t without_glossy_indirect;  /* 1: the same of the glossy lobe of surfaces that have one
                                          (worker/shade/glossy.h), which the glossy planes bring;
                                          only beside the above */
    uint32_t without_diffuse_direct;   /* enum direct_left. Unless it is none, paths leave out
                                          surfaces that the camera sees shine, too */
    uint32_t edge_digits; /* pixels at edges (worker/trace/field/edge_pixels.h) have 2^edge_digits
                             times as many paths, whose sums are those of `spp`; only where there
                             are mixed pixels */
};

/* The largest plan_paths.edge_digits. */
#define PLAN_EDGE_DIGITS_MAX 4u

/* How light fields of rectangle lights become pictures; of reconstruction, not of tracing. */
enum shadow_filter {
    SHADOW_FILTER_NONE = 0, /* the plain average */
    SHADOW_FILTER_AXIS_ALIGNED = 1,
    SHADOW_FILTER_SHEARED = 2
};

/* How the light field of diffuse indirect light (and of ambient occlusion) becomes a picture; of
 * reconstruction, not of tracing. docs/reconstruction.md, Indirect light. */
enum indirect_filter {
    INDIRECT_FILTER_NONE = 0,     /* the plain average */
    INDIRECT_FILTER_CONSTANT = 1, /* axis-aligned, rule A: weighted means */
    INDIRECT_FILTER_LINEAR = 2,   /* axis-aligned, rule B: local linear fits */
    INDIRECT_FILTER_BLEND = 3,    /* axis-aligned, four widths, by variance */
    INDIRECT_FILTER_ADAPTIVE = 4, /* axis-aligned, after a second set of rays (plan_adaptive) */
    INDIRECT_FILTER_SHEARED = 5   /* four passes over the v-plane */
};

/* For INDIRECT_FILTER_ADAPTIVE; else all 0. After the schedule each pixel gets a second set of
 * bounce rays, and of rays of its glossy lobe, by what the first set met. */
struct plan_adaptive {
    float mu;          /* 0 .. LIMIT_FILTER_MU: rays grow with it, widths shrink */
    uint32_t rays_max; /* of a pixel, of each kind, in both sets, to LIMIT_SPP */
};

/* The least alpha of facets whose lobe is a glossy one. */
#define GLOSSY_ALPHA_MIN 0.01f

/* How the light of paths becomes a picture; of reconstruction, not of tracing. */
enum residual_filter {
    RESIDUAL_FILTER_NONE = 0,
    RESIDUAL_FILTER_HALVES = 1, /* non-local means over two halves of the samples */
    RESIDUAL_FILTER_OIDN = 2    /* Open Image Denoise, over the whole frame */
};

/* How the light field of glossy lobes becomes a picture; of reconstruction, not of tracing.
 * docs/reconstruction.md, Glossy lobes. */
enum glossy_filter {
    GLOSSY_FILTER_NONE = 0,        /* the plain average */
    GLOSSY_FILTER_VIRTUAL_HIT = 1, /* by what the neighbours' lobes see of the same points */
    GLOSSY_FILTER_BANDLIMIT = 2,   /* axis-aligned, by the lobes' bandlimits */
    GLOSSY_FILTER_SG = 3,          /* by how alike lobes are, each a spherical Gaussian */
    GLOSSY_FILTER_SG_MIXTURE = 4,  /* ... a mixture of these */
    GLOSSY_FILTER_ASG = 5,         /* ... an anisotropic one */
    GLOSSY_FILTER_LAST = GLOSSY_FILTER_ASG
};

/* How the light field of the lens becomes a picture; of reconstruction, not of tracing.
 * docs/reconstruction.md, Lens layers. */
enum lens_filter {
    LENS_FILTER_NONE = 0, /* the plain average of a pixel's lens samples */
    LENS_FILTER_AXIS_ALIGNED = 1,
    LENS_FILTER_SHEARED = 2
};

/* Which light of the points that lens samples see comes from light fields of pixel centres. These
 * are traced from the middle of the lens and filtered. A sample whose point no pixel centre shows
 * keeps its path's light. Tracing and reconstruction both go by it. docs/reconstruction.md, Light
 * through the lens. */
enum lens_relight {
    LENS_RELIGHT_OWN = 0,      /* none: every sample is lit by its own path */
    LENS_RELIGHT_INDIRECT = 1, /* what diffuse lobes send on of light that was scattered before */
    LENS_RELIGHT_DIFFUSE = 2, /* all that diffuse lobes send on, where all surfaces are pure Lambert
                               and lights are of the list */
    LENS_RELIGHT_SKY = 3 /* INDIRECT, and what they send on of the environment itself, but for parts
                            so bright that their shadows are sharp */
};

/* Slopes (PLANE_LENS_SLOPE) from here on are lit by their own paths. */
#define LENS_RELIGHT_SLOPE_MAX 24.0f

/* Where an environment is above this many times its mean luminance, it is a sun, not soft light. */
#define PLAN_SKY_SOFT_TIMES 12.0f

/* The most mirrors that a camera ray is followed through. */
#define PLAN_LENS_MIRRORS 4

/* What is traced of a picture that a photograph is composed with, each with the same random
 * numbers: the virtual objects, where the camera sees them; catchers as the objects shade and light
 * them, though the camera looks through the objects; catchers as they are without the objects.
 * Holdouts hide what is behind them in all three, and show nothing. worker/trace/hit/query_view.h.
 */
enum plan_view { PLAN_VIEW_OBJECTS = 0, PLAN_VIEW_WITH = 1, PLAN_VIEW_WITHOUT = 2 };
#define PLAN_VIEWS 3u

/* What objects of a composite see where rays meet what the camera sees: an environment's blob,
 * stretched over the picture, or scaled until it covers it. */
enum photograph_fit { PHOTOGRAPH_NONE = 0, PHOTOGRAPH_STRETCHED = 1, PHOTOGRAPH_COVERS = 2 };
struct plan_photograph {
    uint32_t fit, is_linear; /* is_linear 1: what was decoded as sRGB is to be encoded again */
    struct digest blob;      /* zero without one */
};

/* What a worker can do; bits are append-only. A coordinator gives no tile whose plan needs more. */
enum capability {
    CAPABILITY_DIRECT = 1u << 0,
    CAPABILITY_INDIRECT = 1u << 1,
    CAPABILITY_VISIBILITY = 1u << 2, /* visibility bits and slopes */
    CAPABILITY_STRATA = 1u << 3,     /* indirect radiance per stratum */
    CAPABILITY_PATHS = 1u << 4,      /* the path tracer, with passes */
    CAPABILITY_ENVIRONMENT = 1u << 5,
    CAPABILITY_LENS = 1u << 6,
    CAPABILITY_STRATA_MAPS = 1u << 7, /* second sets, by strata maps */
    CAPABILITY_VIEWS = 1u << 8,       /* enum plan_view */
    CAPABILITY_SHUTTER = 1u << 9,     /* samples have times */
};

/* plan.def has the fields in the order of the wire. */
struct plan {
    struct digest scene;
    int32_t width_px, height_px;
    int32_t tile_px;
    struct pattern pattern;
    struct plan_camera camera; /* half way through the shutter, where there is one */
    uint32_t pose_count; /* SHUTTER_STEPS: samples have times of their own while the shutter is
                            open; 0: they are of one moment */
    struct plan_camera poses[SHUTTER_STEPS]; /* the camera's, of its projection and lens */
    uint32_t light_count;
    struct plan_light lights[LIMIT_LIGHTS];
    struct plan_environment environment;
    struct plan_paths paths;
    float target_error; /* of the picture's RMS error over its mean luminance: after the passes that
                           plan_pass_count tells of, tiles get more samples until it is reached; 0:
                           none */
    uint32_t spp_max;   /* of paths, and of bounce rays, a pixel; 0 without a target */
    float occlusion_distance; /* scene units; ambient occlusion counts hits nearer; 0: none */
    uint32_t shadow_filter;   /* enum shadow_filter */
    uint32_t indirect_filter; /* enum indirect_filter */
    uint32_t residual_filter; /* enum residual_filter: of what paths bring */
    uint32_t glossy_filter;   /* enum glossy_filter */
    uint32_t lens_filter;     /* enum lens_filter */
    uint32_t temporal;        /* frames on each side whose samples the residual filter uses, too; 0:
                                 none, of reconstruction */
    float mu;                 /* > 0, to LIMIT_FILTER_MU: scales filter widths; 1: as they are */
    struct plan_adaptive adaptive;
    uint64_t planes;       /* of PLANE_BIT, samples.h */
    uint32_t light_planes; /* bits of enum light_plane_id; plan_light_planes says whose */
    uint32_t sub_samples;  /* anti-aliasing rays a pixel, 0 .. LIMIT_SUB_SAMPLES */
    uint32_t bounces;      /* 0 .. LIMIT_INDIRECT_BOUNCES */
    uint32_t indirect_strata_per_axis; /* l; 0 without indirect planes of the light field; l^2 rays
                                          of glossy lobes, too */
    uint32_t field_halved; /* 1: these leave one pixel of four, and some others (half_field.h) */
    uint32_t lens_strata_per_axis; /* l; 0 without planes of lens samples. lens_pattern.h says
                                      where sample row * l + column lies */
    uint32_t lens_relight;         /* enum lens_relight */
    uint32_t lens_extra;   /* most paths a pixel, in the mean, of second sets through the lens:
                              PLAN_LENS_EXTRA_STRATA squared go where they are needed most */
    uint32_t lens_mirrors; /* most reflections at flat mirrors that pixel centres and lens samples
                              look through (path/mirrors.h); 0 .. PLAN_LENS_MIRRORS */
    uint32_t lens_lobes_only; /* 1: lens samples hold lobes' reflection alone, which reconstruction
                                 may share among them; else it may have sharp shadows, too */
    uint32_t composite;       /* 1: each pass of the schedule is traced once for each plan_view, in
                                 their order; only of paths, without rounds */
    struct plan_photograph photograph; /* only of composites */
    float radiance_scale;              /* a power of two: radiance * scale fits a half float */
    float length_unit;     /* a power of two near the scene's radius: lengths / unit fit one */
    uint32_t capabilities; /* what a worker needs, enum capability */
};

void plan_encode(struct bytes_writer *w, const struct plan *plan);

/* Reads a plan. Returns 0 or ERR_TRUNCATED, ERR_TRAILING, ERR_LIMIT, ERR_RANGE, ERR_NOT_FINITE;
 * *fault names the field. A decoded plan is safe to trace: camera and light vectors finite and not
 * degenerate, all counts within limits.h, planes consistent with bounces and sub_samples. */
int plan_decode(const void *data, size_t size_bytes, struct plan *out, struct fault *fault);

/* Checks all that plan_decode demands of a plan whose light_count is within limits. ERR_RANGE,
 * ERR_LIMIT or ERR_NOT_FINITE; *fault names the field. */
int plan_check(const struct plan *plan, struct fault *fault);

/* Check a camera and a light as plan_decode does, for other readers of such fields. They must be
 * finite and within limits.h, axes orthonormal, areas and cones not degenerate. `place`
 * ("cameras[2]") precedes the field in *fault; a light's power and strata are not checked. */
int plan_camera_check(const struct plan_camera *camera, const char *place, struct fault *fault);
int plan_light_check(const struct plan_light *light, const char *place, struct fault *fault);

/* Returns those of light_planes that a light has. A rectangle has strata, from which a shadow
 * filter makes its irradiance. A light without area has irradiance alone. */
uint32_t plan_light_planes(const struct plan *plan, uint32_t light);

/* Computes the camera as it is at a time, 0..1, while the shutter is open. */
void plan_camera_at(const struct plan *plan, float time, struct plan_camera *out);

/* Computes the camera ray through the continuous pixel position (px, py). The direction is unit. */
void plan_camera_ray(const struct plan *plan, float px, float py, float origin[3],
                     float direction[3]);

/* Computes it for another camera of the plan's image. */
void plan_camera_ray_of(const struct plan *plan, const struct plan_camera *camera, float px,
                        float py, float origin[3], float direction[3]);

/* Returns how many views (enum plan_view) a plan has, 1 of an ordinary picture. Pass p of a plan
 * with several is pass p / views of the view p % views, and has its samples and planes. */
static inline uint32_t plan_views(const struct plan *plan)
{
    return plan->composite ? PLAN_VIEWS : 1;
}

/* Returns the plan of one view. */
static inline struct plan plan_of_view(const struct plan *plan)
{
    struct plan one = *plan;
    one.composite = 0;
    return one;
}

/* Returns the number of passes of the frame, 1 without paths. Pass p traces samples first .. first
 * + count - 1 of every pixel (none beyond the last pass, and none without paths); the schedule (16,
 * 16, 32, then LIMIT_PASS_SPP each, the last cut) is a function of the plan alone, so that the
 * picture forms early and leases stay short. All planes but those of paths belong to pass 0. */
uint32_t plan_pass_count(const struct plan *plan);
void plan_pass_range(const struct plan *plan, uint32_t pass, uint32_t *first, uint32_t *count);

/* What a pass of a tile traces. */
struct plan_pass {
    uint32_t number;           /* of the tile's passes */
    uint32_t first, count;     /* samples of every pixel: first .. first + count - 1 */
    uint32_t strata;           /* l of the bounce rays, and of those of glossy lobes; 0: none */
    const uint8_t *strata_map; /* of a second set: each pixel's own l, row by row of the tile;
                                  `strata` is the largest. NULL: all pixels have l. Borrowed */
    const uint8_t *lobes; /* the same of rays of the pixels' glossy lobes, which `strata` is not
                             below either; NULL unless plan_strata_maps says that there are both */
};

/* The largest l of a pixel in a second set. */
#define PLAN_STRATA_MAX UINT8_MAX

/* l of all pixels that have a second set through the lens. */
#define PLAN_LENS_EXTRA_STRATA 6u

/* Returns the pass that the schedule has under a number below plan_pass_count. */
struct plan_pass plan_scheduled_pass(const struct plan *plan, uint32_t number);

/* The parts of a pass that PATH_HALF_DIFFERENCE2 cuts into halves: `count` of them from sample
 * `first` on, each `length` samples, a power of two at least 2 and the largest of which the pass
 * has a whole multiple. Such parts of the path tracer's sequence are stratified in themselves, and
 * so are their halves (pattern_path.h). All 0 for a pass too short. */
struct plan_split {
    uint32_t first, length, count;
};
struct plan_split plan_pass_split(const struct plan_pass *pass);

/* Returns whether lens samples, lit by their own paths alone, are the plan's paths: each is added
 * to the planes of paths, too. */
static inline bool plan_lens_has_paths(const struct plan *plan)
{
    return plan->lens_strata_per_axis > 0 && plan->lens_relight == LENS_RELIGHT_OWN &&
           plan->paths.spp > 0;
}

/* Returns whether lens sample `sample` of l x l is in half a: every second stratum of the lens, as
 * on a chessboard, so that both halves look from the lens's middle. Half a is the smaller one. */
static inline bool plan_lens_half(uint32_t l, uint32_t sample)
{
    return (sample / l + sample % l) % 2 == 1;
}

/* Returns whether tiles get passes after the schedule: under a target, under
 * INDIRECT_FILTER_ADAPTIVE, and with second sets through the lens. */
bool plan_has_rounds(const struct plan *plan);

/* Returns whether fields of bounce rays bring the soft share of the environment, too. */
bool plan_sky_in_fields(const struct plan *plan);

/* Returns 0, or ERR_RANGE or ERR_LIMIT for a pass that a plan cannot have. A pass within the
 * schedule must be the schedule's. A later one has samples, at most LIMIT_PASS_SPP, an even l, and
 * only samples that the plan has planes for. INDIRECT_FILTER_ADAPTIVE and lens_extra have one pass
 * after the schedule, the second set, which alone has strata maps. */
int plan_pass_check(const struct plan *plan, const struct plan_pass *pass);

/* Returns how many strata maps second sets have: one of bounce rays, and one of rays of glossy
 * lobes where the plan asks how far these see; or one of paths through the lens. Without sets 0. */
uint32_t plan_strata_maps(const struct plan *plan);

/* Checks strata maps of `area` pixels. ERR_RANGE for maps that are not the pass's: above its
 * strata, or all below. */
int plan_strata_map_check(const struct plan_pass *pass, size_t area);

/* Returns the planes that a pass has (bits of enum plane_id): all of the plan's in pass 0, those of
 * paths in other passes, and after the schedule what bounce rays measure, too. */
uint64_t plan_pass_planes(const struct plan *plan, uint32_t number);

/* Returns whether the frame's samples have times of their own. */
static inline bool plan_has_shutter(const struct plan *plan)
{
    return plan->pose_count > 0;
}

/* Returns the samples of a pixel in passes 0 .. passes - 1 of one view; 0 without paths. */
uint32_t plan_pass_spp(const struct plan *plan, uint32_t passes);

/* Returns the world size of a pixel at `distance` along a unit camera ray (constant when
 * orthographic). */
float plan_pixel_size(const struct plan *plan, float distance);
