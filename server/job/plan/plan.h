#pragma once
/* Plans a frame once: what makes its picture, which effects run, which planes travel, and what is
 * left out and why.
 *
 * filter.method none means the path tracer. All others mean light fields, as far as these go. They
 * stand alone where they cover all that scene and job ask for: pure Lambert surfaces, only lights
 * of the list, a pinhole, and layers that they have. Then a shadow filter runs, the one that is
 * asked for or that auto chooses. Where some surface has other lobes besides, fields bring what
 * diffuse lobes send on, and paths what the others do. Elsewhere whole paths bring all the light.
 * The residual filter cleans what paths bring, or Open Image Denoise where a job asks for it. Only
 * where a job names a filter of indirect light or of lobes, wants no residual filter, or asks for
 * occlusion do light fields of indirect light or occlusion stand beside these. A lens has a light
 * field of its own, paths sorted by where they pass the lens, and filter.lens chooses its filter.
 *
 * The path tracer also takes what no light field can do. Without a lens that is a tent and surfaces
 * that let light through by their alpha. With one it is layers besides the picture, more samples
 * than travel one by one, and the layer error. It takes pictures without indirect light, too, and
 * those with so many samples that paths show little noise.
 *
 * Planning is a pure function of the job and what it names, for any thread. Whatever a user may ask
 * about the decision is in struct plan_report. */
#include <jansson.h>
#include <stdbool.h>

#include "proto/job/job.h"
#include "proto/plan.h"
#include "proto/scene/environment.h"
#include "proto/scene/scene.h"

/* Effects that a plan may run, as bits. */
enum plan_effect {
    EFFECT_PRIMARY = 1u << 0,
    EFFECT_ANTIALIAS = 1u << 1,
    EFFECT_DIRECT = 1u << 2,
    EFFECT_SHADOWS = 1u << 3,
    EFFECT_INDIRECT = 1u << 4,
    EFFECT_EMISSION = 1u << 5,
    EFFECT_ENVIRONMENT = 1u << 6,
    EFFECT_LENS = 1u << 7,
    EFFECT_OCCLUSION = 1u << 8,
    EFFECT_EMITTERS = 1u << 9, /* meshes that no light of the list stands for */
    EFFECT_MOTION_BLUR = 1u << 10,
};
#define EFFECT_COUNT 11

/* The integrator that makes the picture. */
enum plan_integrator {
    INTEGRATOR_LIGHT_FIELD,
    INTEGRATOR_PATHS,
    INTEGRATOR_PATHS_AND_LIGHT_FIELD, /* of diffuse lobes, or of their indirect light and occlusion
                                       */
    INTEGRATOR_LENS_FIELD
};

/* What is skipped, such as "plane bounce_distance_min" or "light /lights/2", and why, as a
 * sentence. */
struct plan_skip {
    char what[64];
    char why[128];
};
#define PLAN_SKIPS (LIMIT_LIGHTS + 48)

#define PLAN_FILTER_WHY_BYTES 192

struct plan_light_source {
    bool of_scene;  /* else of the job */
    uint32_t index; /* there */
    char name[64];  /* cut; "" for none */
};

/* The placed meshes that emit light. */
struct plan_emitters {
    uint64_t instances; /* that shine and are no light of the list */
    double flux;        /* luminance that leaves them all, W */
    bool any_seen;      /* something shines towards the camera: these, recognised lights, unlit */
    bool any_unlit;
};

/* What a plan is made from. The call borrows all of it. */
struct plan_source {
    const struct scene *scene;
    struct digest scene_blob;
    const struct environment_header *map; /* of the job's map; NULL when it has none */
    const char *map_warnings;             /* its sentences, as its header counts them */
    struct digest map_blob;
    struct plan_photograph photograph;       /* of a composite */
    const struct environment_header *studio; /* of the light where there is none; NULL: none */
    struct digest studio_blob;
    bool camera_stands; /* from the frame before to the one after, as far as is known */
    const struct environment_header *estimate; /* of the scene's sky; NULL: it has none */
    struct digest estimate_blob;
};

struct plan_report {
    enum plan_integrator integrator;
    struct plan_emitters emitters;
    uint32_t effects;
    bool whole_paths;          /* all indirect light comes along paths, though fields might do */
    bool bumpy;                /* some surface has a normal map */
    bool volumes;              /* or encloses a volume */
    bool by_lobe;              /* fields bring diffuse lobes' light, paths that of other lobes */
    bool by_light;             /* beside by_lobe: of direct light, that of the list alone */
    bool studio_light;         /* nothing else lights the scene */
    bool estimated_light;      /* the environment is estimated from frames */
    bool soft_sky;             /* the environment has no sun: nothing far above its mean */
    uint32_t layers;           /* enum layer */
    enum filter_method method; /* that runs: not auto */
    char filter_why[PLAN_FILTER_WHY_BYTES];
    char indirect_filter_why[PLAN_FILTER_WHY_BYTES];
    char glossy_filter_why[PLAN_FILTER_WHY_BYTES];
    char residual_filter_why[PLAN_FILTER_WHY_BYTES];
    char temporal_why[PLAN_FILTER_WHY_BYTES];
    char lens_filter_why[PLAN_FILTER_WHY_BYTES];
    char lens_relight_why[PLAN_FILTER_WHY_BYTES]; /* "" without lens samples */
    uint32_t skip_count;
    struct plan_skip skipped[PLAN_SKIPS];
    uint32_t warning_count;
    char warnings[LIMIT_WARNINGS][LIMIT_DETAIL_BYTES];
    struct plan_light_source lights[LIMIT_LIGHTS]; /* of the plan's lights, in order */
    double origin[3]; /* of the plan's positions, in the scene's coordinates */
    char camera_name[64];
    uint32_t camera_count; /* of the scene's, listed */
    char cameras[LIMIT_CAMERAS_LISTED][64];
    bool camera_is_default; /* the importer made it, because the file has none */
};

/* Returns whether plan_make might light a scene by the studio light: unless lamps shine it will. */
bool plan_may_want_studio(const struct job *job, const struct scene *scene);

/* Finds the camera of a frame, as plan_make does but for its lens. */
int plan_find_camera(const struct job *job, const struct scene *scene, struct plan_camera *out,
                     struct fault *fault);

/* Adds sentences, NUL-terminated, of an import to a report. */
void plan_copy_warnings(const char *sentences, size_t size_bytes, struct plan_report *report);

/* Plans one frame; frames of a job differ in plan->pattern.frame alone. ERR_LIMIT, ERR_NOT_FOUND,
 * ERR_RANGE with *fault pointing into the job document. */
int plan_make(const struct job *job, const struct plan_source *source, int32_t frame,
              struct plan *plan, struct plan_report *report, struct fault *fault);

/* Takes samples of other frames out of a plan, because of `why`. */
void plan_temporal_none(const char *why, struct plan *plan, struct plan_report *report);

/* Returns the bytes that the frames of a window keep in memory at once; 0 without one. */
uint64_t plan_window_bytes(const struct plan *plan);

/* Writes the report: {integrator, effects, layers, planes, light_planes, filter, filter_why,
 * indirect_filter, indirect_filter_why, glossy_filter, glossy_filter_why, residual_filter,
 * residual_filter_why, temporal, temporal_why, lens_filter, lens_filter_why, lens_relight,
 * lens_relight_why, light_filters, skipped: [{what, why}], lights, environment, emitters, camera,
 * cameras, samples, tiles, warnings}. Returns a new reference; NULL on failed allocation. */
json_t *plan_report_json(const struct plan *plan, const struct plan_report *report);
