#pragma once
/* What a frame needs, decided once: who makes the picture, which effects run, which planes travel,
 * what is left out and why.
 *
 * filter.method none is the path tracer. All others are light fields as far as these go: alone
 * where they cover all that scene and job ask for (pure Lambert surfaces, lights of the list alone,
 * a pinhole, layers that they give), with the shadow filter that is asked for or that auto chooses;
 * else beside paths, to which they bring diffuse indirect light and ambient occlusion. Both have
 * the filter of indirect light that filter.indirect asks for. With a lens it is the lens's light
 * field, of paths that are sorted by where they pass the lens, with the filter that filter.lens
 * asks for. What none can do (without a lens a tent and surfaces that let light through by their
 * alpha; with one layers besides the picture, more samples than travel one by one; the layer
 * error), what has nothing indirect, and what has so many samples that paths alone show little
 * noise is the path tracer, too, which nothing filters.
 *
 * A pure function of the job and what it names; any thread. Everything that a person may ask about
 * the decision is in struct plan_report. */
#include <jansson.h>
#include <stdbool.h>

#include "proto/job/job.h"
#include "proto/plan.h"
#include "proto/scene/environment.h"
#include "proto/scene/scene.h"

/* Effects that a plan may run; bits. */
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
};
#define EFFECT_COUNT 10

/* Who makes the picture. */
enum plan_integrator {
    INTEGRATOR_LIGHT_FIELD,
    INTEGRATOR_PATHS,
    INTEGRATOR_PATHS_AND_LIGHT_FIELD, /* of diffuse indirect light and of occlusion */
    INTEGRATOR_LENS_FIELD
};

/* What is skipped ("plane reflector", "light /lights/2"), and why, as sentences. */
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

/* What shines among the placed meshes. */
struct plan_emitters {
    uint64_t instances; /* that shine and are no light of the list */
    double flux;        /* luminance that leaves them all, W */
    bool any_seen;      /* something shines towards the camera: these, recognised lights, unlit */
    bool any_unlit;
};

/* What a plan is made from; all of it is borrowed for the call. */
struct plan_source {
    const struct scene *scene;
    struct digest scene_blob;
    const struct environment_header *map; /* of the job's map; NULL when it has none */
    struct digest map_blob;
};

struct plan_report {
    enum plan_integrator integrator;
    struct plan_emitters emitters;
    uint32_t effects;
    bool soft_sky;             /* the environment has no sun: nothing far above its mean */
    uint32_t layers;           /* enum layer */
    enum filter_method method; /* that runs: not auto */
    char filter_why[PLAN_FILTER_WHY_BYTES];
    char indirect_filter_why[PLAN_FILTER_WHY_BYTES];
    char glossy_filter_why[PLAN_FILTER_WHY_BYTES];
    char lens_filter_why[PLAN_FILTER_WHY_BYTES];
    char lens_light_why[PLAN_FILTER_WHY_BYTES]; /* "" without lens samples */
    uint32_t skip_count;
    struct plan_skip skipped[PLAN_SKIPS];
    uint32_t warning_count;
    char warnings[LIMIT_WARNINGS][LIMIT_DETAIL_BYTES];
    struct plan_light_source lights[LIMIT_LIGHTS]; /* of the plan's lights, in order */
    char camera_name[64];
    uint32_t camera_count; /* of the scene's, listed */
    char cameras[LIMIT_CAMERAS_LISTED][64];
    bool camera_is_default; /* the importer made it, because the file has none */
};

/* Plans one frame; frames of a job differ in plan->pattern.frame alone. ERR_LIMIT, ERR_NOT_FOUND,
 * ERR_RANGE with *fault pointing into the job document. */
int plan_make(const struct job *job, const struct plan_source *source, int32_t frame,
              struct plan *plan, struct plan_report *report, struct fault *fault);

/* {integrator, effects, layers, planes, light_planes, filter, filter_why, indirect_filter,
 * indirect_filter_why, glossy_filter, glossy_filter_why, lens_filter, lens_filter_why, lens_light,
 * lens_light_why, skipped:
 * [{what, why}], lights, environment, emitters, camera, samples, tiles, warnings}. New reference;
 * NULL on failed allocation. */
json_t *plan_report_json(const struct plan *plan, const struct plan_report *report);

/* Adds a line; what does not fit is dropped. */
void plan_skip(struct plan_report *report, const char *what, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void plan_warn(struct plan_report *report, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The parts of plan_make, in their order. */
int plan_resolve_camera(const struct job *job, const struct scene *scene, struct plan_camera *out,
                        struct plan_report *report, struct fault *fault);
int plan_gather_lights(const struct job *job, const struct scene *scene, struct plan *plan,
                       struct plan_report *report, struct fault *fault);
/* radiance_scale and length_unit; with the environment's mean radiance. */
void plan_set_scales(const struct scene *scene, const float environment_mean[3], struct plan *plan);
void plan_find_emitters(const struct scene *scene, struct plan_emitters *out);

/* *mean: radiance averaged over all directions, 0 without an environment. */
int plan_set_environment(const struct job *job, const struct plan_source *source, struct plan *plan,
                         struct plan_report *report, float mean[3], struct fault *fault);

/* By what a path chooses among lights, mesh emitters and environment: shares of the flux into the
 * scene (W, by luminance), each at least a thousandth. */
void plan_set_powers(const struct scene *scene, const struct plan_emitters *emitters,
                     const float environment_mean[3], struct plan *plan);

/* Whether the picture's error is to be estimated. */
bool plan_wants_error(const struct job *job);

#define PLAN_WHY_BYTES sizeof(((struct plan_skip *)0)->why)

/* Whether light fields may have a part in a pinhole's picture; else why not, a sentence. */
bool plan_light_field_possible(const struct job *job, const struct scene *scene,
                               char why[PLAN_WHY_BYTES]);
/* Where they may: whether they give all of it; else why not. */
bool plan_light_field_covers(const struct job *job, const struct scene *scene,
                             const struct plan *plan, const struct plan_emitters *emitters,
                             char why[PLAN_WHY_BYTES]);
/* Of a plan of light fields, enum shadow_filter, and a sentence that says why: none without a light
 * that has area, and where its strata are too many to travel; what the job asks for; and where it
 * asks for auto the sheared filter, which has the least error at all numbers of samples
 * (docs/reconstruction.md, Which filter answers), unless it would cost more than four times what
 * tracing does. */
uint32_t plan_choose_filter(const struct job *job, const struct plan *plan,
                            char why[PLAN_FILTER_WHY_BYTES]);
void plan_filter(const struct job *job, struct plan *plan, struct plan_report *report);
void plan_filter_none(const struct job *job, const char *why, struct plan_report *report);

/* Anything that light comes from. */
bool plan_is_lit(const struct plan *plan, const struct plan_report *report);
void plan_bounces(const struct job *job, struct plan *plan, struct plan_report *report);
/* Of a plan with bounces and planes: enum indirect_filter, and a sentence that says why: what
 * filter.indirect asks for, and under auto by the number of bounce rays, unless filter.method is
 * average. */
uint32_t plan_choose_indirect_filter(const struct job *job, const struct plan *plan,
                                     char why[PLAN_FILTER_WHY_BYTES]);
const char *plan_indirect_filter_name(uint32_t filter);
/* Planes of indirect light and of occlusion, with the surfaces that they need, and their filter. */
void plan_indirect(const struct job *job, struct plan *plan, struct plan_report *report);
/* No filter of indirect light runs, because of `why`. */
void plan_indirect_none(const struct job *job, const char *why, struct plan_report *report);
extern const char plan_nothing_to_filter[]; /* a why */

/* Planes of glossy lobes and their filter, beside paths and planes of indirect light, where the
 * scene has a surface with such a lobe; else why not. After plan_indirect. */
void plan_glossy(const struct job *job, const struct scene *scene, struct plan *plan,
                 struct plan_report *report);
const char *plan_glossy_filter_name(uint32_t filter);

/* Of a plan with all its other planes: the list of lone sub-samples (proto/lone.h), where pixels
 * without a lens have sub-samples and light fields for them; else why not. */
void plan_lone(struct plan *plan, struct plan_report *report);

/* What plan_indirect and plan_glossy have planned stays. */
void plan_light_field(const struct job *job, struct plan *plan, struct plan_report *report);
void plan_paths(const struct job *job, struct plan *plan, struct plan_report *report);

/* Of a plan with a lens: whether its light field makes the picture; else why not. */
bool plan_lens_possible(const struct job *job, const struct plan *plan, char why[PLAN_WHY_BYTES]);
/* enum lens_filter, and a sentence that says why: what filter.lens asks for, under its auto what
 * filter.method does, and under that auto the sheared filter. */
uint32_t plan_choose_lens_filter(const struct job *job, char why[PLAN_FILTER_WHY_BYTES]);
const char *plan_lens_filter_name(uint32_t filter);
/* Bytes a pixel that lens samples of the job travel in, with the surfaces that they meet, where
 * light fields are to light them, and with second sets if there may be any. */
uint64_t plan_lens_bytes(const struct job *job, bool surfaces);
/* No lens samples, because of `why`. */
void plan_lens_none(const struct job *job, const char *why, struct plan_report *report);
void plan_lens(const struct job *job, struct plan *plan, struct plan_report *report);
/* No second sets through the lens after all, because of `why`; nothing else has such sets. */
void plan_lens_one_set(const char *why, struct plan *plan, struct plan_report *report);
/* Of a plan of lens samples with its bounces: enum lens_light, and a sentence that says why. Light
 * fields light them where a filter of the lens runs and one of light fields would: of shadows and
 * of indirect light where fields cover the scene, else of indirect light alone. */
uint32_t plan_choose_lens_light(const struct job *job, const struct scene *scene,
                                const struct plan *plan, const struct plan_emitters *emitters,
                                char why[PLAN_FILTER_WHY_BYTES]);
const char *plan_lens_light_name(uint32_t light);
/* Light of lens samples, before plan_lens: planes of fields and their filters, or none. */
void plan_lens_light(const struct job *job, const struct scene *scene, struct plan *plan,
                     struct plan_report *report);

/* What those parts share. */
/* Lights keep strata only for the layers that show them: a path takes one point of one light. */
void plan_path_lights(const struct job *job, struct plan *plan, struct plan_report *report);
void plan_path_effects(struct plan *plan, struct plan_report *report);
/* Direct light of light fields, after plan_filter: planes of the lights. */
void plan_direct(struct plan *plan, struct plan_report *report);
/* Planes of the surfaces at pixel centres and beside them, for an anti-aliased resolve. */
void plan_surfaces(struct plan *plan, struct plan_report *report);
/* Light planes for the filter and the layers visibility and slopes, with a line for each that is
 * left out. */
void plan_strata_planes(struct plan *plan, struct plan_report *report);
double plan_luminance(const float color[3]);
double plan_scene_radius(const struct scene *scene); /* of a sphere around its bounds; > 0 */
