#include "server/job/plan/plan_parts.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "proto/link/message.h"
#include "proto/samples.h"

/* Scene units between which pictures are sure to be right. */
#define RADIUS_MIN 1e-6
#define RADIUS_MAX 1e12

/* Bounce rays beside as many paths are not worth their while: the first pass traces them all. */
#define SAMPLES_BESIDE_MAX 256

void plan_skip(struct plan_report *report, const char *what, const char *format, ...)
{
    va_list args;
    if (report->skip_count == PLAN_SKIPS) return;
    struct plan_skip *skip = &report->skipped[report->skip_count++];
    snprintf(skip->what, sizeof skip->what, "%s", what);
    va_start(args, format);
    vsnprintf(skip->why, sizeof skip->why, format, args);
    va_end(args);
}

void plan_warn(struct plan_report *report, const char *format, ...)
{
    va_list args;
    if (report->warning_count == LIMIT_WARNINGS) return;
    va_start(args, format);
    vsnprintf(report->warnings[report->warning_count++], LIMIT_DETAIL_BYTES, format, args);
    va_end(args);
}

/* The importer's warnings are the job's, too. */
void plan_copy_warnings(const char *sentences, size_t size_bytes, struct plan_report *report)
{
    const char *at = sentences, *end = sentences ? sentences + size_bytes : sentences;
    while (at < end) {
        size_t length = strnlen(at, (size_t)(end - at));
        if (length > 0) plan_warn(report, "%.*s", (int)(length < 500 ? length : 500), at);
        at += length + 1;
    }
}

/* Visibility and slopes, for the filter that reads them and the layers that show them. */
void plan_strata_planes(struct plan *plan, struct plan_report *report)
{
    static const char no_reader[] = "no filter or layer of this plan reads it";
    static const char no_area[] = "no light has area";
    bool area = false, filtered = plan->shadow_filter != SHADOW_FILTER_NONE;
    for (uint32_t k = 0; k < plan->light_count; k++)
        area = area || plan->lights[k].type == LIGHT_RECTANGLE;
    if (area && (filtered || (report->layers & LAYER_VISIBILITY)))
        plan->light_planes |= 1u << LIGHT_PLANE_VISIBILITY;
    else
        plan_skip(report, "plane visibility", "%s", area ? no_reader : no_area);
    if (area && (filtered || (report->layers & (LAYER_SLOPE_MIN | LAYER_SLOPE_MAX))))
        plan->light_planes |= 1u << LIGHT_PLANE_SLOPES;
    else
        plan_skip(report, "plane slopes", "%s", area ? no_reader : no_area);
    if (plan->light_planes & ~(1u << LIGHT_PLANE_IRRADIANCE))
        plan->capabilities |= CAPABILITY_VISIBILITY;
}

static int check_strata(const struct job *job, const struct plan *plan, struct fault *fault)
{
    uint32_t l = job_strata_per_axis(job->light_spp ? job->light_spp : job->spp);
    if (plan->light_planes <= 1u << LIGHT_PLANE_IRRADIANCE || l <= LIMIT_PLANE_STRATA_PER_AXIS)
        return 0;
    return fault_set(fault, ERR_LIMIT, job->light_spp ? "/sampling/light_spp" : "/sampling/spp",
                     "%u samples a light: the layers visibility and slope_* take at most %d", l * l,
                     LIMIT_PLANE_STRATA_PER_AXIS * LIMIT_PLANE_STRATA_PER_AXIS);
}

/* Shrinks tiles until their samples fit one frame on the wire, as with many lights. Lone
 * sub-samples are shaded by squares of LIMIT_TILE_SIDE_MIN_PX, which tiles must not cut. */
static int fit_tile(struct plan *plan, struct plan_report *report, struct fault *fault)
{
    struct samples_layout layout;
    int32_t asked = plan->tile_px;
    while (samples_layout_init(&layout, plan, 0, plan->tile_px, plan->tile_px) != 0) {
        plan->tile_px /= 2;
        if (plan->tile_px < LIMIT_TILE_SIDE_MIN_PX)
            return fault_set(fault, ERR_LIMIT, "/sampling/spp",
                             "the samples of the smallest tile do not fit a message");
    }
    if (plan->planes & PLANE_BIT(LONE)) plan->tile_px -= plan->tile_px % LIMIT_TILE_SIDE_MIN_PX;
    if (plan->tile_px < asked - asked % LIMIT_TILE_SIDE_MIN_PX)
        plan_warn(report, "tiles of %d px would hold too many samples; they are %d px", asked,
                  plan->tile_px);
    return 0;
}

/* Checks memory. All samples of a frame with rounds stay until the last round. A frame is not
 * refused because of second sets through the lens; it loses them. */
static int fit_memory(struct plan *plan, struct plan_report *report, struct fault *fault)
{
    char why[PLAN_WHY_BYTES];
    struct samples_layout layout;
    const int32_t side = LIMIT_TILE_SIDE_MIN_PX;
    const char *place = plan->target_error > 0.0f ? "/sampling/target_error" : "/filter/indirect";
    if (!plan_has_rounds(plan)) return 0;
    if (samples_layout_init(&layout, plan, 0, side, side) != 0) return 0;
    const uint64_t each = layout.total_bytes / (LIMIT_TILE_SIDE_MIN_PX * LIMIT_TILE_SIDE_MIN_PX);
    const uint64_t pixels = (uint64_t)plan->width_px * (uint64_t)plan->height_px;
    if (each * pixels <= LIMIT_TARGET_BYTES) return 0;
    snprintf(why, sizeof why,
             "%" PRIu64 " pixels keep %" PRIu64
             " bytes each until all their samples are known: above %llu in all",
             pixels, each, LIMIT_TARGET_BYTES);
    if (plan->lens_extra == 0) return fault_set(fault, ERR_LIMIT, place, "%s", why);
    plan_lens_one_set(why, plan, report);
    return 0;
}

/* Paths alone: no filter runs. `indirect_why` is said of indirect light, `why` of light fields. */
static void choose_paths(const struct job *job, const char *filter_why, const char *indirect_why,
                         const char *why, struct plan_report *report)
{
    report->integrator = INTEGRATOR_PATHS;
    plan_filter_none(job, filter_why, report);
    plan_indirect_none(job, indirect_why, report);
    plan_skip(report, "light fields", "%s", why);
}

/* Returns whether there are so many paths, and unfiltered bounce rays beside them, that paths alone
 * are better: they converge in passes, over whole pixels and not at their centres. */
static bool has_enough_paths(const struct job *job, const struct plan *plan,
                             char why[PLAN_WHY_BYTES])
{
    const uint32_t l = job_strata_per_axis(job->spp), most = SAMPLES_BESIDE_MAX;
    const bool asked = job->indirect != INDIRECT_AUTO || job->method == FILTER_AVERAGE ||
                       plan_asks_for_sky(job, plan) ||
                       (job->indirect_spp > 0 && job->indirect_spp <= most);
    if (asked || l * l <= most) return false;
    snprintf(why, PLAN_WHY_BYTES, "%u samples a pixel are above %u: paths alone show little noise",
             l * l, most);
    return true;
}

/* Returns whether the residual filter makes more of whole paths than of paths beside light
 * fields of indirect light, which double the rays and have samples of their own. psnr_db at 4
 * samples beside fields, of whole paths, and of whole paths at 9, which cost the same: blocks
 * 40.5, 40.8, 44.2; under the sky 43.5, 44.1, 47.3; living room 23.6, 24.3, 26.2. What is asked
 * for by name, runs. */
static bool does_without_fields(const struct job *job, const struct plan *plan,
                                const struct plan_report *report, char why[PLAN_WHY_BYTES])
{
    const bool asked = plan_asks_for_sky(job, plan) || job->indirect != INDIRECT_AUTO ||
                       job->glossy != GLOSSY_AUTO || job->indirect_spp > 0 ||
                       job->method == FILTER_AVERAGE;
    if (asked || !plan_residual_possible(job, report)) return false;
    snprintf(why, PLAN_WHY_BYTES,
             "the residual filter cleans whole paths for fewer rays than light fields beside them");
    return true;
}

/* Light fields cannot do it alone. */
static void choose_beside(const struct job *job, const struct plan *plan, const char *why,
                          struct plan_report *report)
{
    char filter_why[PLAN_FILTER_WHY_BYTES], enough_paths[PLAN_WHY_BYTES];
    bool indirect = job->indirect_bounces > 0 && plan_is_lit(plan, report);
    bool occlusion = (report->layers & LAYER_OCCLUSION) != 0;
    if (plan_divides(job, plan, report)) {
        report->integrator = INTEGRATOR_PATHS_AND_LIGHT_FIELD;
        plan_skip(report, "light fields alone", "%s", why);
        return;
    }
    if (!indirect && !occlusion) {
        snprintf(filter_why, sizeof filter_why,
                 "paths make the picture, because light fields cannot: %s", why);
        choose_paths(job, filter_why, plan_nothing_to_filter, why, report);
        return;
    }
    if (has_enough_paths(job, plan, enough_paths)) {
        choose_paths(job, enough_paths, enough_paths, enough_paths, report);
        return;
    }
    report->whole_paths = !indirect || does_without_fields(job, plan, report, enough_paths);
    if (report->whole_paths && !occlusion) {
        plan_skip(report, "light fields of lights", "%s", why);
        choose_paths(job, enough_paths, enough_paths, enough_paths, report);
        return;
    }
    report->integrator = INTEGRATOR_PATHS_AND_LIGHT_FIELD;
    snprintf(filter_why, sizeof filter_why, "direct light comes along paths, unfiltered: %s", why);
    plan_filter_none(job, filter_why, report);
    plan_skip(report, "light fields of lights", "%s", why);
}

/* There is a lens. */
static void choose_lens(const struct job *job, const struct plan *plan, struct plan_report *report)
{
    char why[PLAN_WHY_BYTES], filter_why[PLAN_FILTER_WHY_BYTES];
    if (!plan_lens_possible(job, plan, why)) {
        snprintf(filter_why, sizeof filter_why,
                 "paths make the picture, because light fields cannot: %s", why);
        choose_paths(job, filter_why, filter_why, why, report);
        plan_lens_none(job, why, report);
        return;
    }
    report->integrator = INTEGRATOR_LENS_FIELD;
}

/* Frames use each other's paths. Occlusion, which is no light, has bounce rays all the same. */
static void choose_window(const struct job *job, const char *why, struct plan_report *report)
{
    report->whole_paths = true;
    if (!(report->layers & LAYER_OCCLUSION)) {
        choose_paths(job, why, why, why, report);
        return;
    }
    report->integrator = INTEGRATOR_PATHS_AND_LIGHT_FIELD;
    plan_filter_none(job, why, report);
    plan_skip(report, "light fields of lights", "%s", why);
}

/* Without one. */
static void choose_pinhole(const struct job *job, const struct scene *scene,
                           const struct plan *plan, struct plan_report *report)
{
    char why[PLAN_WHY_BYTES], filter_why[PLAN_FILTER_WHY_BYTES];
    plan_lens_none(job, "the camera is a pinhole", report);
    if (!plan_light_field_possible(job, scene, why)) {
        snprintf(filter_why, sizeof filter_why,
                 "paths make the picture, because light fields cannot: %s", why);
        choose_paths(job, filter_why, filter_why, why, report);
    } else if (plan_prefers_window(job, plan, report, why)) {
        choose_window(job, why, report);
    } else if (!plan_light_field_covers(job, scene, plan, &report->emitters, why)) {
        report->bumpy = plan_has_bumps(scene);
        report->volumes = plan_has_volumes(scene);
        choose_beside(job, plan, why, report);
    } else {
        report->integrator = INTEGRATOR_LIGHT_FIELD;
        plan_skip(report, "paths", "light fields cover the scene and the layers");
    }
}

/* The views of a composite must differ by the objects alone. */
static void choose_views(const struct job *job, const struct plan_source *source, struct plan *plan,
                         struct plan_report *report)
{
    static const char why[] = "the picture is composed with a photograph: its views are of paths";
    choose_paths(job, why, why, why, report);
    plan_lens_none(job, why, report);
    plan->composite = 1;
    /* Measured depth is too rough to look for points in a frame: errors grow by a third. */
    if (!job->composite.rgbd) plan->photograph = source->photograph;
    plan->capabilities |= CAPABILITY_VIEWS;
}

/* Chooses the integrator; the report says why not the others. */
static void choose(const struct job *job, const struct plan_source *source, struct plan *plan,
                   struct plan_report *report)
{
    static const char none[] = "filter.method is none: samples are averaged";
    static const char moves[] = "samples have times of their own while the shutter is open, which "
                                "light fields of pixel centres have not";
    if (job->composite.on) {
        choose_views(job, source, plan, report);
    } else if (job->method == FILTER_NONE) {
        choose_paths(job, none, none, "filter.method is none: every sample is a path", report);
        plan_lens_none(job, none, report);
    } else if (plan_has_shutter(plan)) {
        choose_paths(job, moves, moves, moves, report);
        plan_lens_none(job, moves, report);
    } else if (plan->camera.aperture_radius > 0) {
        choose_lens(job, plan, report);
    } else {
        choose_pinhole(job, source->scene, plan, report);
    }
}

/* Plans all that follows from the integrator. */
static void arrange(const struct job *job, const struct scene *scene, struct plan *plan,
                    struct plan_report *report)
{
    plan_bounces(job, plan, report);
    plan_residual_none(report);
    const enum plan_integrator integrator = report->integrator;
    if (integrator == INTEGRATOR_LIGHT_FIELD || integrator == INTEGRATOR_PATHS_AND_LIGHT_FIELD)
        plan_indirect(job, plan, report);
    if (integrator == INTEGRATOR_LENS_FIELD) plan_lens_relight(job, scene, plan, report);
    plan_glossy(job, scene, plan, report);
    if (integrator == INTEGRATOR_LIGHT_FIELD || report->by_lobe)
        plan_light_field(job, plan, report);
    if (integrator == INTEGRATOR_LENS_FIELD)
        plan_lens(job, plan, report);
    else if (integrator != INTEGRATOR_LIGHT_FIELD)
        plan_paths(job, plan, report);
    plan_half_field(job, plan, report);
    plan_lone(plan, report);
    plan_mixed(plan, report);
    plan_temporal(job, plan, report);
    plan_tell_sky(job, plan, report);
    if (report->layers & LAYER_CRYPTO_OBJECT) plan->planes |= PLANES_MATTE_OBJECTS;
    if (report->layers & LAYER_CRYPTO_MATERIAL) plan->planes |= PLANES_MATTE_MATERIALS;
    if ((report->layers & LAYER_FILTER_WIDTH) && plan->shadow_filter == SHADOW_FILTER_NONE &&
        plan->indirect_filter == INDIRECT_FILTER_NONE && plan->lens_filter == LENS_FILTER_NONE)
        plan_warn(report, "no filter runs: the layer filter_width is 0 everywhere");
}

static void tell_emitters(const struct job *job, struct plan_report *report)
{
    if (!(report->emitters.flux > 0)) {
        plan_skip(report, "effect emitters", "no mesh emits light besides the lights");
        return;
    }
    report->effects |= EFFECT_EMITTERS;
    if (!job->scene_lights)
        plan_warn(report,
                  "scene.lights is false, but meshes that shine and are no lights (%" PRIu64
                  " of them) light the scene all the same: their materials say so",
                  report->emitters.instances);
}

static void tell_occlusion(const struct job *job, struct plan_report *report)
{
    if (report->layers & LAYER_OCCLUSION) return;
    plan_skip(report, "effect occlusion", "the layer occlusion is not asked for");
    if (job->occlusion_distance > 0)
        plan_warn(report, "effects.ambient_occlusion has a distance, but \"layers\" does not name "
                          "\"occlusion\": nothing shows it");
}

/* Embree's floats: a triangle's coordinates come to nothing when twice its area is below 1e-18, and
 * distances overflow with the cube of lengths. */
static void tell_scale(const struct scene *scene, struct plan_report *report)
{
    const double radius = plan_scene_radius(scene);
    if (radius >= RADIUS_MIN && radius <= RADIUS_MAX) return;
    plan_warn(report, "the scene's radius is %.3g units: %s; scale it to between %g and %g", radius,
              radius < RADIUS_MIN ? "triangles of this size would lose their normals and textures"
                                  : "rays would miss triangles of this size",
              RADIUS_MIN, RADIUS_MAX);
}

static void tell_darkness(struct plan_report *report)
{
    if (report->effects & (EFFECT_DIRECT | EFFECT_EMISSION)) return;
    plan_warn(report, "nothing lights this scene: the picture will be black; add \"lights\" or an "
                      "\"environment\"");
}

/* Plans all that precedes the choice of the integrator. */
static int gather(const struct job *job, const struct plan_source *source, struct plan *plan,
                  struct plan_report *report, float environment_mean[3], struct fault *fault)
{
    plan_copy_warnings(source->scene->warnings, source->scene->count[SCENE_WARNINGS], report);
    if (source->map && source->map_warnings)
        plan_copy_warnings(source->map_warnings, source->map->warning_bytes, report);
    memcpy(report->origin, source->scene->info->origin, sizeof report->origin);
    int error = plan_resolve_camera(job, source->scene, &plan->camera, report, fault);
    if (!error) plan_shutter(job, source->scene, plan, report);
    if (!error) error = plan_gather_lights(job, source->scene, plan, report, fault);
    plan_find_emitters(source->scene, &report->emitters);
    if (!error) error = plan_set_environment(job, source, plan, report, environment_mean, fault);
    if (error) return error;
    plan_set_scales(source->scene, environment_mean, plan);
    if (plan->camera.aperture_radius > 0) plan->capabilities |= CAPABILITY_LENS;
    tell_emitters(job, report);
    tell_occlusion(job, report);
    plan_tell_brightness(job, source->scene, plan, report);
    tell_scale(source->scene, report);
    return 0;
}

int plan_make(const struct job *job, const struct plan_source *source, int32_t frame,
              struct plan *plan, struct plan_report *report, struct fault *fault)
{
    struct fault inner = {0};
    float environment_mean[3];
    *plan = (struct plan){.scene = source->scene_blob,
                          .width_px = job->width_px,
                          .height_px = job->height_px,
                          .tile_px = job->tile_px,
                          .pattern = {.seed = job->seed, .frame = (uint32_t)frame},
                          .target_error = job->target_error,
                          .spp_max = job->max_spp,
                          .mu = job->mu};
    memset(report, 0, sizeof *report);
    report->layers = job->layers;
    int error = gather(job, source, plan, report, environment_mean, fault);
    if (error) return error;
    choose(job, source, plan, report);
    arrange(job, source->scene, plan, report);
    plan_set_powers(source->scene, &report->emitters, environment_mean, plan);
    tell_darkness(report);
    error = check_strata(job, plan, fault);
    if (!error) error = fit_tile(plan, report, fault);
    if (!error) error = fit_memory(plan, report, fault);
    if (!error && plan_check(plan, &inner) != 0)
        error = fault_set(fault, inner.code, "", "%s: %s", inner.pointer, inner.detail);
    return error;
}
