#pragma once
/* Reads, checks and writes job documents. A fault has the JSON pointer of its member, and defaults
 * are filled in.
 *
 * Each field below has its meaning, unit, range and default. openapi.yaml has the schema, and
 * docs/job-document.md explains it. The members are:
 *
 *   scene     {asset, files: {"relative name": sha256}, camera, lights: bool,
 *              variant: name or null, animation: name or null, time_s: seconds or null,
 *              moves: [{node, translation, rotation_deg}],
 *              default_light: bool,
 *              default_camera: "front" | "three_quarter"}; asset is required
 *             camera: name, index, {eye, target, up, yfov_deg} or null for the scene's own
 *   image     {width, height, pixel_type: "float" | "half", pixel_filter: "box" | "tent",
 *              exr_compression: "none" | "zips" | "zip" | "piz" | "dwaa",
 *              view: "linear" | "filmic" | "agx", exposure: stops, png_bits: 8 | 16,
 *              png_alpha: bool}
 *   lights    [{type: rectangle | directional | point | spot, ...}]; see openapi.yaml
 *   environment {asset, intensity, rotation_deg}, {radiance} or null
 *   camera    {shutter: a fraction of a frame, {fraction, centre} or null}
 *   lens      {aperture_radius, focus_distance, blades, blade_rotation_deg} or null
 *   effects   {indirect_bounces, ambient_occlusion: false | {distance}}
 *   sampling  {spp, light_spp, indirect_spp, lens_spp, lens_extra, field_scale,
 *             target_error, max_spp, seed, tile_px}
 *   filter    {method, environment, indirect, glossy, lens, residual, mu}
 *   layers    [names]; frames {first, last} or "1-10,20-40x2"; fps; start_time_s; priority;
 *             live: bool
 *   backplate, rgbd, catchers, holdouts, composite: see job_composite.h
 *   name, comment: text or null; labels [texts]; webhook: {url} or null
 *
 * A member of a later version is refused with ERR_UNSUPPORTED and its pointer, never ignored. */
#include <jansson.h>
#include <stdbool.h>

#include "proto/digest.h"
#include "proto/error.h"
#include "proto/exr_codec.h"
#include "proto/job/job_composite.h"
#include "proto/job/job_marks.h"
#include "proto/job/job_moves.h"
#include "proto/json.h"
#include "proto/plan.h"
#include "proto/scene/relative_path.h"
#include "proto/view_curve.h"

/* A file that the scene's main file refers to by a relative name. */
struct job_file {
    char *path; /* owned; relative, no "..", no leading "/"; at most LIMIT_PATH_BYTES */
    struct digest asset;
};

enum job_camera_kind { JOB_CAMERA_DEFAULT, JOB_CAMERA_NAME, JOB_CAMERA_INDEX, JOB_CAMERA_LOOK_AT };

/* Cameras of our making, for scenes that have none: in front of all of it and a little above, or
 * from the right and above, as near as the picture's shape allows. */
enum job_view { JOB_VIEW_FRONT, JOB_VIEW_THREE_QUARTER };

struct job_camera {
    enum job_camera_kind kind;
    char name[LIMIT_NAME_BYTES];
    uint32_t index;
    float eye[3], target[3], up[3]; /* up: default 0 1 0; not along the view */
    float yfov_deg;                 /* (0, 179]; default 45 */
};

enum filter_method {
    FILTER_AUTO,
    FILTER_SHEARED,
    FILTER_AXIS_ALIGNED,
    FILTER_AVERAGE, /* unfiltered light fields, the baseline of the filters */
    FILTER_NONE     /* paths alone */
};

/* filter.indirect says how diffuse indirect light and ambient occlusion of light fields are
 * filtered. From average on, the values of this and the next two enums have the order of the
 * plan's, where average is NONE. */
enum indirect_method {
    INDIRECT_AUTO, /* by the number of samples */
    INDIRECT_AVERAGE,
    INDIRECT_CONSTANT,
    INDIRECT_LINEAR,
    INDIRECT_BLEND,
    INDIRECT_ADAPTIVE,
    INDIRECT_SHEARED
};

/* filter.environment says what brings the environment's light to the surfaces that the camera sees:
 * paths, or the light field of indirect light, as far as it casts no sharp shadows. */
enum environment_method { ENVIRONMENT_AUTO, ENVIRONMENT_AVERAGE, ENVIRONMENT_AXIS_ALIGNED };

/* filter.glossy says how the light field of glossy lobes is filtered. */
enum glossy_method {
    GLOSSY_AUTO,
    GLOSSY_AVERAGE,
    GLOSSY_VIRTUAL_HIT,
    GLOSSY_BANDLIMIT,
    GLOSSY_SG,
    GLOSSY_SG_MIXTURE,
    GLOSSY_ASG
};

/* filter.residual says how the light of paths is filtered. */
enum residual_method { RESIDUAL_AUTO, RESIDUAL_NONE, RESIDUAL_HALVES, RESIDUAL_OIDN };

/* filter.temporal says how many frames on each side lend a frame their samples. */
enum temporal_method {
    TEMPORAL_AUTO, /* as many as pay */
    TEMPORAL_NONE,
    TEMPORAL_ONE,
    TEMPORAL_TWO
};

/* sampling.field_scale says how many pixels the rays of light fields leave, an axis. */
enum field_scale {
    FIELD_SCALE_AUTO, /* as pays */
    FIELD_SCALE_FULL,
    FIELD_SCALE_HALF
};

/* filter.lens says how the light field of the lens is filtered. */
enum lens_method {
    LENS_AUTO, /* as filter.method says, and under its auto along the slopes */
    LENS_AVERAGE,
    LENS_AXIS_ALIGNED,
    LENS_SHEARED
};

/* Output layers; bits. */
enum layer {
    LAYER_BEAUTY = 1u << 0,
    LAYER_DIRECT = 1u << 1,
    LAYER_INDIRECT = 1u << 2,
    LAYER_ALBEDO = 1u << 3,
    LAYER_NORMAL = 1u << 4,
    LAYER_DEPTH = 1u << 5,
    LAYER_SAMPLES = 1u << 6,    /* per pixel: light and bounce rays, or paths */
    LAYER_VISIBILITY = 1u << 7, /* mean over the area lights' strata */
    LAYER_SLOPE_MIN = 1u << 8,
    LAYER_SLOPE_MAX = 1u << 9,
    LAYER_EMISSION = 1u << 10,
    LAYER_ID = 1u << 11,
    LAYER_FILTER_WIDTH = 1u << 12, /* sigma in pixels, largest over all filters; 0: not filtered */
    LAYER_ERROR = 1u << 13,        /* estimated standard error of beauty, rgb */
    LAYER_OCCLUSION = 1u << 14,    /* share of the hemisphere that is open, by cosine */
    LAYER_DIFFUSE_DIRECT = 1u << 15,   /* demodulated: PLANE_PATH_DIFFUSE_DIRECT */
    LAYER_DIFFUSE_INDIRECT = 1u << 16, /* PLANE_PATH_DIFFUSE_INDIRECT, or filtered light fields */
    LAYER_MOTION_BACKWARD = 1u << 17,  /* pixels to where it was a frame before: x right, y down */
    LAYER_MOTION_FORWARD = 1u << 18,   /* and to where it is a frame later */
    LAYER_COMPOSITE = 1u << 19,        /* the photograph with the objects */
    LAYER_CATCHER = 1u << 20, /* what multiplies the photograph behind them, or is added to it */
    LAYER_OVERLAY = 1u << 21, /* objects and grey shadows, to be laid over any photograph */
    LAYER_CRYPTO_OBJECT = 1u << 22, /* Cryptomatte's ids of objects (proto/scene/matte.h) */
    LAYER_CRYPTO_MATERIAL = 1u << 23,
    LAYER_BACKPLATE = 1u << 24, /* the photograph, as large as the picture */
};
#define LAYERS_COMPOSITE (LAYER_COMPOSITE | LAYER_CATCHER | LAYER_OVERLAY | LAYER_BACKPLATE)
#define LAYERS_CRYPTO    (LAYER_CRYPTO_OBJECT | LAYER_CRYPTO_MATERIAL)
#define LAYERS_MOTION    (LAYER_MOTION_BACKWARD | LAYER_MOTION_FORWARD)
#define LAYERS_AVAILABLE                                                                           \
    (LAYER_BEAUTY | LAYER_DIRECT | LAYER_INDIRECT | LAYER_ALBEDO | LAYER_NORMAL | LAYER_DEPTH |    \
     LAYER_SAMPLES | LAYER_VISIBILITY | LAYER_SLOPE_MIN | LAYER_SLOPE_MAX | LAYER_EMISSION |       \
     LAYER_ID | LAYER_FILTER_WIDTH | LAYER_ERROR | LAYER_OCCLUSION | LAYER_DIFFUSE_DIRECT |        \
     LAYER_DIFFUSE_INDIRECT | LAYERS_MOTION | LAYERS_COMPOSITE | LAYERS_CRYPTO)

/* Frames first, first + step, ..., to last at most. */
struct job_frame_run {
    int32_t first, last; /* 0..2^30 */
    int32_t step;        /* 1 or more */
};

enum pixel_type { PIXEL_FLOAT, PIXEL_HALF };

struct job_environment {
    enum environment_kind kind; /* default none */
    struct digest asset;        /* MAP: of the .hdr or .exr file */
    float radiance[3];          /* CONSTANT */
    float intensity;            /* MAP: factor, 0 .. LIMIT_RADIANCE; default 1 */
    float rotation_deg;         /* MAP; default 0 */
};

#define JOB_MAX_SPP 1024
/* With fewer samples in the first round their spread and halves give no usable error. */
#define JOB_TARGET_SPP_MIN 4

struct job {
    struct digest scene;    /* asset of the main file */
    struct job_file *files; /* owned; in order of their paths */
    uint32_t file_count;
    char variant[LIMIT_NAME_BYTES];   /* of the scene's materials; "": as they are */
    char animation[LIMIT_NAME_BYTES]; /* of the scene, that plays; "": all of them */
    bool stands;                      /* all frames show the scene at time_s; default false */
    double time_s;                    /* else the time of the frame that is prepared */
    struct job_moves moves;           /* of the scene's nodes; default none */
    struct job_camera camera;
    int32_t width_px, height_px;    /* 1..LIMIT_IMAGE_SIDE_PX; default 720 x 720 */
    enum pixel_type pixel_type;     /* of the EXR; default float */
    enum pixel_filter pixel_filter; /* of paths; default box. A tent asks for paths */
    enum exr_codec exr_compression; /* default zip */
    enum view_curve view;           /* of PNG files and the viewer; default agx */
    float exposure;                 /* stops, LIMIT_EXPOSURE_EV either way; default 0 */
    uint32_t png_bits;              /* of a sample, 8 or 16; default 8 */
    bool png_alpha;                 /* default false: over black */
    uint32_t light_count;
    struct plan_light lights[LIMIT_LIGHTS]; /* strata_per_axis and power are set by the plan */
    bool scene_lights;                      /* use the scene's own lights; default true */
    enum job_view default_camera;           /* of a scene without one; default front */
    bool default_light; /* a studio light where nothing lights the scene; default true */
    struct job_environment environment;
    float aperture_radius;     /* 0: no lens */
    float focus_distance;      /* > 0 with a lens */
    uint32_t blades;           /* 0: round; else 3..LIMIT_LENS_BLADES */
    float blade_rotation_deg;  /* default 0 */
    float occlusion_distance;  /* ambient occlusion; 0: none */
    uint32_t indirect_bounces; /* 0..LIMIT_INDIRECT_BOUNCES; default 1 */
    uint32_t spp;              /* 1..LIMIT_SPP, rounded up to a square; default 9 */
    uint32_t light_spp, indirect_spp, lens_spp; /* 0: spp */
    uint32_t lens_extra; /* paths a pixel, in the mean, of second sets through the lens; 0: none */
    float target_error;  /* sampling goes on until the estimated error, as its RMS over pixels and
                            channels over the picture's mean luminance, is at most this; 0: none */
    uint32_t max_spp; /* most paths, and most bounce rays, of a pixel; 0 without a target; with one
                         up to LIMIT_SPP, default JOB_MAX_SPP */
    enum field_scale field_scale;                  /* default auto */
    uint64_t seed;                                 /* 0..2^53; default 1 */
    enum filter_method method;                     /* default auto */
    enum environment_method environment_filter;    /* default auto */
    enum indirect_method indirect;                 /* default auto */
    enum residual_method residual;                 /* default auto */
    enum temporal_method temporal;                 /* default auto */
    enum glossy_method glossy;                     /* default auto */
    enum lens_method lens;                         /* default auto */
    float mu;                                      /* (0, 100]; default 1 */
    uint32_t layers;                               /* default beauty */
    struct job_frame_run frames[LIMIT_FRAME_RUNS]; /* in order; default frame 1 alone */
    uint32_t frame_run_count;
    double fps;             /* 0.001..1000; default 24 */
    double start_time_s;    /* of frame 1, whether or not the job has it; default 0 */
    float shutter_fraction; /* of a frame, 0..1, for which the shutter is open; default 0: what
                               moves stands in each frame */
    float shutter_centre;   /* when it is half way, in frames from the frame's time, -1..1; default
                               0 */
    int32_t priority;       /* -LIMIT_PRIORITY..LIMIT_PRIORITY; default 0; higher goes first */
    int32_t tile_px;        /* LIMIT_TILE_SIDE_MIN_PX..LIMIT_TILE_SIDE_PX; default 64 */
    bool live; /* camera and nodes are moved while it is open (job_view_read); default false */
    struct job_composite composite; /* default none */
    struct job_marks marks;         /* default none */
};

/* Parses and checks a document. On failure *fault has the code, the JSON pointer and a sentence,
 * and *out needs no fini. On success the caller owns *out and calls job_fini. */
int job_read(const char *text, size_t size_bytes, struct job *out, struct fault *fault);
void job_fini(struct job *job);
/* Copies it with its files. ERR_MEMORY: *out is empty. */
int job_copy(const struct job *job, struct job *out);

/* Writes the document with every default spelled out, as GET answers it and the store keeps it.
 * job_read of it gives the same job. Returns a new reference; NULL on failed allocation. */
json_t *job_write(const struct job *job);

/* Write the members camera and lens; no lens is null. Return a new reference; NULL on failed
 * allocation. */
json_t *job_camera_write(const struct job_camera *camera);
json_t *job_lens_write(const struct job *job);

/* Reads {"camera": ..., "lens": ..., "moves": ...} over a copy of a job, to change what a live one
 * shows. A member replaces the whole of the job's and has the same form. An absent one stays, but
 * one is required. On failure *fault has the code, the JSON pointer and a sentence. The files stay
 * the job's. */
int job_view_read(const char *text, size_t size_bytes, struct job *job, struct fault *fault);

/* Count a job's frames, number them and find their numbers, in order. */
uint32_t job_frame_run_count(const struct job_frame_run *run);
uint32_t job_frame_count(const struct job *job);
int32_t job_frame_number(const struct job *job, uint32_t index);
bool job_frame_find(const struct job *job, int32_t number, uint32_t *index);

/* Returns whether each frame has the one before it or the one after it beside it. */
bool job_frames_follow(const struct job *job);

/* Returns whether frames may use samples of others, as far as the document tells. */
bool job_may_be_temporal(const struct job *job);

/* Returns the time in the scene that a frame shows: when its shutter is half way. */
double job_frame_time_s(const struct job *job, int32_t number);

/* Returns how long the shutter is open, in seconds of the scene; 0: a frame shows one moment. */
double job_shutter_s(const struct job *job);

/* Reads the frames of a document alone; the job's other members are 0. Needs no job_fini. */
int job_frames_of(const json_t *document, struct job *out);

/* Returns the strata per axis of an spp, the least l with l*l >= spp. */
uint32_t job_strata_per_axis(uint32_t spp);

/* Returns the layer's name, such as "beauty"; NULL for an unknown bit. */
const char *layer_name(enum layer layer);
/* Returns the bit of a name, or 0. */
uint32_t layer_from_name(const char *name);
/* Finds the view of a name, such as "agx". False for another text. */
bool view_curve_from_name(const char *name, enum view_curve *out);
const char *view_curve_name(enum view_curve curve);
const char *filter_method_name(enum filter_method method);
const char *environment_method_name(enum environment_method method);
const char *indirect_method_name(enum indirect_method method);
const char *residual_method_name(enum residual_method method);
const char *temporal_method_name(enum temporal_method method);
const char *glossy_method_name(enum glossy_method method);
const char *lens_method_name(enum lens_method method);
