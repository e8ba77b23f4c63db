#pragma once
/* The parts of plan_make, in their order, and what they share. Other rooms include plan.h. */
#include "server/job/plan/plan.h"

/* Adds a skip to the report, which drops what does not fit. */
void plan_skip(struct plan_report *report, const char *what, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void plan_warn(struct plan_report *report, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

int plan_resolve_camera(const struct job *job, const struct scene *scene, struct plan_camera *out,
                        struct plan_report *report, struct fault *fault);
/* Finds the camera's poses while the shutter is open. Returns whether it moves. */
bool plan_find_poses(const struct job *job, const struct scene *scene, struct plan *plan);
/* Plans whether samples have times of their own, once the camera is found; or reports why not. */
void plan_shutter(const struct job *job, const struct scene *scene, struct plan *plan,
                  struct plan_report *report);
int plan_gather_lights(const struct job *job, const struct scene *scene, struct plan *plan,
                       struct plan_report *report, struct fault *fault);
/* Sets radiance_scale and length_unit, given the environment's mean radiance. */
void plan_set_scales(const struct scene *scene, const float environment_mean[3], struct plan *plan);
/* Warns of lights as files of other units have them, and says which exposure shows them. */
void plan_tell_brightness(const struct job *job, const struct scene *scene, const struct plan *plan,
                          struct plan_report *report);
void plan_find_emitters(const struct scene *scene, struct plan_emitters *out);

/* Sets the environment. *mean is its radiance averaged over all directions, 0 without one. */
int plan_set_environment(const struct job *job, const struct plan_source *source, struct plan *plan,
                         struct plan_report *report, float mean[3], struct fault *fault);

/* Returns whether the job wants the environment's soft share from light fields, and there is one.
 */
bool plan_asks_for_sky(const struct job *job, const struct plan *plan);
/* Returns whether fields that bring it, without a lens, are to be left unfiltered. */
bool plan_sky_is_averaged(const struct job *job, const struct plan *plan);
/* Warns if fields that are asked for do not bring it. */
void plan_tell_sky(const struct job *job, const struct plan *plan, struct plan_report *report);

/* Sets the probabilities by which a path chooses among lights, mesh emitters and environment. They
 * are shares of the flux into the scene (W, by luminance), each at least a thousandth. */
void plan_set_powers(const struct scene *scene, const struct plan_emitters *emitters,
                     const float environment_mean[3], struct plan *plan);

/* Returns whether the picture's error is to be estimated. */
bool plan_wants_error(const struct job *job);

/* Chooses the integrator; the report says why not the others. */
void plan_choose(const struct job *job, const struct plan_source *source, struct plan *plan,
                 struct plan_report *report);

#define PLAN_WHY_BYTES sizeof(((struct plan_skip *)0)->why)

/* Returns whether light fields may have a part in a pinhole's picture. If not, `why` says so in a
 * sentence. */
bool plan_light_field_possible(const struct job *job, const struct scene *scene,
                               char why[PLAN_WHY_BYTES]);
/* Returns whether light fields that have a part give all of the picture. If not, `why` says why. */
bool plan_light_field_covers(const struct job *job, const struct scene *scene,
                             const struct plan *plan, const struct plan_emitters *emitters,
                             char why[PLAN_WHY_BYTES]);
/* Chooses the shadow filter of a plan of light fields (enum shadow_filter), with a sentence that
 * says why. No filter runs without a light that has area, or where its strata are too many to
 * travel. Else it is the job's. Under auto it is the sheared filter, which has the least error at
 * all numbers of samples (docs/reconstruction.md, Which filter answers), unless it would cost more
 * than four times what tracing does. */
uint32_t plan_choose_filter(const struct job *job, const struct plan *plan,
                            char why[PLAN_FILTER_WHY_BYTES]);
void plan_filter(const struct job *job, struct plan *plan, struct plan_report *report);
void plan_filter_none(const struct job *job, const char *why, struct plan_report *report);

/* Returns whether light fields and paths divide a pinhole's light that fields alone do not cover.
 * The report says how. */
bool plan_divides(const struct job *job, const struct plan *plan, struct plan_report *report);

/* Returns whether the material has layers or lobes beyond glTF's core: a coat, a film, a sheen,
 * diffuse transmission. `surely`: at all points, whatever its textures are. */
bool plan_has_layers(const struct scene_material *m, bool surely);

/* Returns whether some surface has a normal map. */
bool plan_has_bumps(const struct scene *scene);

/* Returns what brings and cleans each kind of light, for the report: a row for diffuse lobes, and
 * one for others where some surface may have them. */
json_t *plan_light_filters(const struct plan *plan, const struct plan_report *report);

/* Returns whether some surface encloses a volume, which dims what is seen through it. */
bool plan_has_volumes(const struct scene *scene);

/* Returns whether some light of the list is a rectangle. */
bool plan_has_rectangle(const struct plan *plan);

/* Returns whether there is any source of light. */
bool plan_is_lit(const struct plan *plan, const struct plan_report *report);
void plan_bounces(const struct job *job, struct plan *plan, struct plan_report *report);
/* Chooses the filter of a plan with bounces and planes (enum indirect_filter), with a sentence that
 * says why. It is what filter.indirect asks for. Under auto the number of bounce rays decides,
 * unless filter.method is average. */
uint32_t plan_choose_indirect_filter(const struct job *job, const struct plan *plan,
                                     char why[PLAN_FILTER_WHY_BYTES]);
const char *plan_indirect_filter_name(uint32_t filter);
/* Plans the planes of indirect light and of occlusion, the surfaces that they need, and their
 * filter. */
void plan_indirect(const struct job *job, struct plan *plan, struct plan_report *report);
/* Reports that no filter of indirect light runs, because of `why`. */
void plan_indirect_none(const struct job *job, const char *why, struct plan_report *report);
extern const char plan_nothing_to_filter[]; /* a why */

/* Plans the planes of glossy lobes and their filter, beside paths and planes of indirect light, if
 * the scene has a surface with such a lobe. If not, it reports why. It runs after plan_indirect. */
void plan_glossy(const struct job *job, const struct scene *scene, struct plan *plan,
                 struct plan_report *report);
const char *plan_glossy_filter_name(uint32_t filter);

/* Plans the residual filter of a plan with paths and their number, and the planes that it reads, or
 * reports why not. It runs before the planes of plan_paths. */
void plan_residual(const struct job *job, struct plan *plan, struct plan_report *report);
/* Returns whether it may run on paths of the job. */
bool plan_residual_possible(const struct job *job, const struct plan_report *report);
/* Reports that there are no paths. */
void plan_residual_none(struct plan_report *report);
const char *plan_residual_filter_name(uint32_t filter);

/* Returns whether the job lets fields have half the resolution, if their filter does. */
bool plan_may_halve(const struct job *job);
/* Plans whether fields of bounce rays and of glossy lobes have half the resolution, once these are
 * planned. */
void plan_half_field(const struct job *job, struct plan *plan, struct plan_report *report);

/* Returns whether frames are of whole paths because these are all that frames lend each other. If
 * so, `why` says it in a sentence. It comes before all that chooses light fields. */
bool plan_prefers_window(const struct job *job, const struct plan *plan,
                         const struct plan_report *report, char why[PLAN_WHY_BYTES]);
/* Plans temporal filtering, and the planes that find points in other frames, once all else is
 * planned; or reports why not. */
void plan_temporal(const struct job *job, struct plan *plan, struct plan_report *report);

/* Plans the list of lone sub-samples (proto/lone.h), once all other planes are planned. Pixels must
 * have sub-samples and light fields for them, and no lens. If not, it reports why. */
void plan_lone(struct plan *plan, struct plan_report *report);

/* Plans the list of mixed pixels (proto/mixed.h), where light fields light sub-samples without
 * paths beside them, or where whole paths are filtered. If not, it reports why. */
void plan_mixed(struct plan *plan, struct plan_report *report);

/* Plan what else light fields and paths need. They keep what plan_indirect and plan_glossy have
 * planned. */
void plan_light_field(const struct job *job, struct plan *plan, struct plan_report *report);
void plan_paths(const struct job *job, struct plan *plan, struct plan_report *report);

/* Returns whether the light field of the lens makes the picture. If not, `why` says why. */
bool plan_lens_possible(const struct job *job, const struct plan *plan, char why[PLAN_WHY_BYTES]);
/* Chooses the filter of the lens (enum lens_filter), with a sentence that says why. It is what
 * filter.lens asks for, under its auto what filter.method does, and under that auto the sheared
 * filter. */
uint32_t plan_choose_lens_filter(const struct job *job, char why[PLAN_FILTER_WHY_BYTES]);
const char *plan_lens_filter_name(uint32_t filter);
/* Returns the bytes per pixel of the job's lens samples on the wire. With `surfaces` they have the
 * surfaces that they meet, so that light fields can light them. Second sets count if there may be
 * any. */
uint64_t plan_lens_bytes(const struct job *job, bool surfaces);
/* Reports that there are no lens samples, because of `why`. */
void plan_lens_none(const struct job *job, const char *why, struct plan_report *report);
void plan_lens(const struct job *job, struct plan *plan, struct plan_report *report);
/* Takes second sets through the lens out of the plan, because of `why`. Only the lens has such
 * sets. */
void plan_lens_one_set(const char *why, struct plan *plan, struct plan_report *report);
/* Returns whether the residual filter may clean lens samples that no field lights. */
bool plan_lens_paths_possible(const struct job *job);
const char *plan_lens_relight_name(uint32_t light);
/* Plans the planes of the fields that light lens samples, and their filters, or none. It runs
 * before plan_lens. */
void plan_lens_relight(const struct job *job, const struct scene *scene, struct plan *plan,
                       struct plan_report *report);

/* Drops strata that no layer shows: a path takes one point of one light. */
void plan_path_lights(const struct job *job, struct plan *plan, struct plan_report *report);
void plan_path_effects(struct plan *plan, struct plan_report *report);
/* Plans the planes of the lights, for direct light of light fields. It runs after the shadow filter
 * is chosen. */
void plan_direct(struct plan *plan, struct plan_report *report);
/* Plans the planes of surfaces at pixel centres and sub-samples, for an anti-aliased resolve. */
void plan_surfaces(struct plan *plan, struct plan_report *report);
/* Plans the light planes that the filter and the layers visibility and slopes need. It reports each
 * that is left out. */
void plan_strata_planes(struct plan *plan, struct plan_report *report);
double plan_luminance(const float color[3]);
double plan_scene_radius(const struct scene *scene); /* of a sphere around its bounds; > 0 */
