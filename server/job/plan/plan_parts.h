#pragma once
/* The parts of plan_make, in their order, and what they share. Other rooms include plan.h. */
#include "server/job/plan/plan.h"

/* Adds a line; what does not fit is dropped. */
void plan_skip(struct plan_report *report, const char *what, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void plan_warn(struct plan_report *report, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

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

/* The residual filter of a plan with paths and their number, and the planes that it reads; else why
 * not. Before plan_paths' own planes. */
void plan_residual(const struct job *job, struct plan *plan, struct plan_report *report);
/* Whether it may run on paths of the job. */
bool plan_residual_possible(const struct job *job, const struct plan_report *report);
/* There are no paths. */
void plan_residual_none(struct plan_report *report);
const char *plan_residual_filter_name(uint32_t filter);

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
