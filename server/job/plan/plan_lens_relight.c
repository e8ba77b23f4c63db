/* Plans which light of lens samples comes from light fields of pixel centres, and these fields'
 * planes. */
#include <inttypes.h>
#include <stdio.h>

#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"
#include "server/reconstruct/block.h"

/* The planes that a resolve of sub-samples reads. Lens samples make the picture without them. */
#define PLANES_RESOLVE                                                                             \
    (PLANE_BIT(ALBEDO) | PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) |    \
     PLANE_BIT(SUB_ID))

static bool is_indirect_filtered(const struct job *job, const struct plan *plan)
{
    const bool averaged = job->indirect == INDIRECT_AVERAGE ||
                          (job->indirect == INDIRECT_AUTO && job->method == FILTER_AVERAGE);
    return plan->bounces > 0 && !averaged;
}

/* Returns a bound of the memory that a thread needs at least to light samples of the lens. */
static uint64_t block_bytes(const struct job *job, const struct plan *plan)
{
    char unused[PLAN_FILTER_WHY_BYTES];
    struct plan lit = *plan;
    lit.lens_relight = LENS_RELIGHT_DIFFUSE;
    lit.lens_strata_per_axis = job_strata_per_axis(job->lens_spp ? job->lens_spp : job->spp);
    lit.lens_filter = plan_choose_lens_filter(job, unused);
    lit.planes |= PLANES_LENS_ALL | PLANES_GLOSSY_LIGHT | PLANES_BOUNCE_LIGHT | PLANE_BIT(DEPTH) |
                  PLANE_BIT(NORMAL);
    lit.light_planes = LIGHT_PLANES_STRATA;
    lit.indirect_strata_per_axis =
        job_strata_per_axis(job->indirect_spp ? job->indirect_spp : job->spp);
    if (job->indirect == INDIRECT_SHEARED &&
        lit.indirect_strata_per_axis <= LIMIT_PLANE_STRATA_PER_AXIS)
        lit.planes |= PLANE_BIT(INDIRECT_STRATA);
    lit.shadow_filter = plan_choose_filter(job, &lit, unused);
    lit.indirect_filter = plan_choose_indirect_filter(job, &lit, unused);
    return block_patch_bytes_min(&lit);
}

/* Returns whether fields could light lens samples at all. If not, `why` says why. */
static bool is_possible(const struct job *job, const struct scene *scene, const struct plan *plan,
                        char why[PLAN_WHY_BYTES])
{
    char unused[PLAN_FILTER_WHY_BYTES];
    const uint64_t bytes =
        plan_lens_bytes(job, true) * (uint64_t)plan->width_px * (uint64_t)plan->height_px;
    if (plan_choose_lens_filter(job, unused) == LENS_FILTER_NONE)
        snprintf(why, PLAN_WHY_BYTES, "no filter of the lens runs: its samples are averaged");
    else if (job->indirect == INDIRECT_ADAPTIVE)
        snprintf(why, PLAN_WHY_BYTES, "filter.indirect is adaptive, which has no place for a lens");
    else if (bytes > LIMIT_LENS_BYTES)
        snprintf(why, PLAN_WHY_BYTES,
                 "%" PRIu64 " bytes of lens samples with their surfaces are above %llu", bytes,
                 LIMIT_LENS_BYTES);
    else if (block_bytes(job, plan) > LIMIT_PATCH_BYTES)
        snprintf(why, PLAN_WHY_BYTES,
                 "a block's lens samples with their surfaces are above %llu bytes",
                 LIMIT_PATCH_BYTES);
    else
        return plan_light_field_possible(job, scene, why);
    return false;
}

/* Returns whether the job names a filter of light fields. */
static bool asks_for_fields(const struct job *job)
{
    return job->indirect != INDIRECT_AUTO || job->glossy != GLOSSY_AUTO || job->indirect_spp > 0;
}

/* Chooses which light fields light the lens samples (enum lens_relight), with a sentence that says
 * why. They do where a filter of the lens runs and one of light fields would. Where fields cover
 * the scene these are shadows and indirect light, else indirect light alone.
 *
 * Under fields of indirect light alone direct light stays noise. psnr_db of blocks under a
 * rectangle, of glTF's default material, at 4 and 16 samples: fields 34.6, 42.7, the residual
 * filter 38.2, 42.5 for half the rays. Where a sky shines fields bring part of that, too: blocks
 * 44.7, 50.4 and 42.7, 47.7; metal balls 33.5, 37.9 and 33.8, 37.7; living room 23.4, 27.2 and
 * 23.1, 26.5. */
static uint32_t choose_light(const struct job *job, const struct scene *scene,
                             const struct plan *plan, const struct plan_emitters *emitters,
                             char why[PLAN_FILTER_WHY_BYTES])
{
    const size_t n = PLAN_FILTER_WHY_BYTES;
    char unused[PLAN_FILTER_WHY_BYTES], but[PLAN_WHY_BYTES];
    if (job->residual == RESIDUAL_HALVES && plan_lens_paths_possible(job)) {
        snprintf(why, n, "filter.residual is halves, and takes all light along paths");
        return LENS_RELIGHT_OWN;
    }
    if (!is_possible(job, scene, plan, but)) {
        snprintf(why, n, "%s", but);
        return LENS_RELIGHT_OWN;
    }
    const bool covers = plan_light_field_covers(job, scene, plan, emitters, but);
    const bool indirect = is_indirect_filtered(job, plan);
    const bool residual = plan_lens_paths_possible(job);
    const bool shadows = plan_choose_filter(job, plan, unused) != SHADOW_FILTER_NONE;
    if (covers && (indirect || shadows)) {
        snprintf(why, n, "%s filtered first, at pixel centres",
                 !indirect ? "soft shadows are"
                 : shadows ? "soft shadows and indirect light are"
                           : "indirect light is");
        return LENS_RELIGHT_DIFFUSE;
    }
    if (!covers && indirect && plan->environment.kind != ENVIRONMENT_NONE) {
        snprintf(why, n, "fields bring indirect light and the sky's, paths the rest: %s", but);
        return LENS_RELIGHT_SKY;
    }
    if (!covers && indirect && !asks_for_fields(job) && residual) {
        snprintf(why, n, "the residual filter cleans lens samples, direct light and all: %s", but);
        return LENS_RELIGHT_OWN;
    }
    if (!covers && indirect) {
        snprintf(why, n, "indirect light is filtered first; direct comes along paths: %s", but);
        return LENS_RELIGHT_INDIRECT;
    }
    if (covers)
        snprintf(why, n, "there is neither a soft shadow nor indirect light to filter");
    else
        snprintf(why, n, "no indirect light to filter; direct comes along paths: %s", but);
    return LENS_RELIGHT_OWN;
}

const char *plan_lens_relight_name(uint32_t light)
{
    static const char *const names[] = {
        [LENS_RELIGHT_OWN] = "own",
        [LENS_RELIGHT_INDIRECT] = "indirect",
        [LENS_RELIGHT_DIFFUSE] = "diffuse",
        [LENS_RELIGHT_SKY] = "sky",
    };
    return names[light];
}

/* Plans that every lens sample is lit by its own path. */
static void plan_own(const struct job *job, struct plan *plan, struct plan_report *report)
{
    static const char each[] = "with a lens every sample is a path, with light of its own";
    const char *why = report->lens_relight_why;
    plan_filter_none(job, each, report);
    plan_indirect_none(job, each, report);
    plan_skip(report, "light fields of pixel centres", "%.*s", (int)PLAN_WHY_BYTES - 1, why);
    plan_path_lights(job, plan, report);
    if (job->indirect_spp)
        plan_skip(report, "sampling.indirect_spp", "each lens sample goes on as a path of its own");
}

/* Returns whether points of the material may be mirrors. worker/trace/path/mirrors.c decides at
 * each. */
static bool may_mirror(const struct scene_material *m)
{
    if (m->normal_texture.texture != SCENE_NONE || (m->flags & MATERIAL_UNLIT)) return false;
    if (m->emission[0] > 0 || m->emission[1] > 0 || m->emission[2] > 0) return false;
    return m->model == MODEL_MIRROR ||
           (m->model == MODEL_GLTF && m->metallic >= 1 && !(m->roughness > 0) &&
            !plan_has_layers(m, false) && m->metallic_roughness_texture.texture == SCENE_NONE);
}

static bool has_mirror(const struct scene *scene)
{
    for (uint64_t i = 0; i < scene->count[SCENE_INSTANCES]; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        if (may_mirror(&scene->materials[mesh->material])) return true;
    }
    return false;
}

/* Plans how many mirrors samples are followed through. */
static void plan_mirrors(const struct scene *scene, struct plan *plan, struct plan_report *report)
{
    const uint32_t shown = report->layers & (LAYER_DEPTH | LAYER_NORMAL | LAYER_ID);
    const char *why = NULL;
    if (!has_mirror(scene))
        why = "no material is a smooth mirror";
    else if (shown)
        why = "a layer shows the mirrors' own depth, normal or id";
    else if (plan->indirect_filter == INDIRECT_FILTER_SHEARED)
        why = "the sheared filter of indirect light knows no mirror image";
    if (why)
        plan_skip(report, "images in mirrors", "%s", why);
    else
        plan->lens_mirrors = plan->bounces < PLAN_LENS_MIRRORS ? plan->bounces : PLAN_LENS_MIRRORS;
}

void plan_lens_relight(const struct job *job, const struct scene *scene, struct plan *plan,
                       struct plan_report *report)
{
    plan->lens_relight =
        choose_light(job, scene, plan, &report->emitters, report->lens_relight_why);
    if (plan->lens_relight == LENS_RELIGHT_OWN) {
        plan_own(job, plan, report);
        return;
    }
    plan_indirect(job, plan, report);
    plan->planes &= ~PLANES_RESOLVE;
    plan->sub_samples = 0;
    plan->planes |= PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANES_LENS_SURFACE;
    plan_skip(report, "planes of sub-samples", "lens samples make the picture");
    if (plan->lens_relight == LENS_RELIGHT_DIFFUSE) {
        plan_filter(job, plan, report);
        plan_direct(plan, report);
        return;
    }
    plan_filter_none(job, "direct light comes along the paths of lens samples", report);
    plan_path_lights(job, plan, report);
    plan_mirrors(scene, plan, report);
}
