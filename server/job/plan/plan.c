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
    plan_choose(job, source, plan, report);
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
