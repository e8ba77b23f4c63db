/* What filters, and sampling for them, ask of a plan. */
#include "proto/plan_internal.h"

#include <math.h>
#include <stdbool.h>

#include "proto/samples.h"

#define PLANES_GEOMETRY (PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL))

/* A filter makes a rectangle's irradiance anew, from what it is told of surfaces and strata. */
static int check_shadow_filter(const struct plan_field *at, const struct plan *plan)
{
    if (plan->shadow_filter == SHADOW_FILTER_NONE) return 0;
    if (plan->paths.spp > 0 && !plan->paths.without_diffuse_direct)
        return plan_field_refuse(at, ERR_RANGE, "shadow_filter",
                                 "filters a picture that is made of paths",
                                 (double)plan->shadow_filter);
    if ((plan->planes & PLANES_GEOMETRY) != PLANES_GEOMETRY)
        return plan_field_refuse(at, ERR_RANGE, "planes",
                                 "lacks the depth and normal that filters read",
                                 (double)plan->planes);
    if ((plan->light_planes & LIGHT_PLANES_STRATA) != LIGHT_PLANES_STRATA)
        return plan_field_refuse(at, ERR_RANGE, "light_planes",
                                 "lacks the visibility and slopes that filters read",
                                 (double)plan->light_planes);
    return 0;
}

/* Checks second sets of rays. They add to means, and their size follows from the first set's
 * distances. Such means have no known error, and a target cannot ask for more rays. */
static int check_rate(const struct plan_field *at, const struct plan *plan)
{
    const struct plan_adaptive *adaptive = &plan->adaptive;
    const bool second = plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE;
    const uint32_t l = plan->indirect_strata_per_axis;
    const uint64_t others =
        PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(GLOSSY_HALF);
    if ((adaptive->mu > 0.0f) != second || (adaptive->rays_max > 0) != second)
        return plan_field_refuse(at, ERR_RANGE, "adaptive.mu",
                                 "belongs to one filter, which needs it", (double)adaptive->mu);
    if (!second) return 0;
    if (l > LIMIT_PLANE_STRATA_PER_AXIS || adaptive->rays_max < l * l)
        return plan_field_refuse(at, ERR_RANGE, "adaptive.rays_max",
                                 "is less than the first rays are", (double)adaptive->rays_max);
    if (plan->planes & others || plan->target_error > 0.0f)
        return plan_field_refuse(at, ERR_RANGE, "indirect_filter",
                                 "knows means alone, and no errors", (double)plan->indirect_filter);
    return 0;
}

/* Checks the planes of filters of indirect light: surfaces, bounce distances, and single rays for
 * the sheared filter. */
static int check_indirect_filter(const struct plan_field *at, const struct plan *plan)
{
    const bool sheared = plan->indirect_filter == INDIRECT_FILTER_SHEARED;
    const bool adaptive = plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE;
    const uint64_t needs = PLANES_GEOMETRY | PLANE_BIT(ID) | PLANE_BIT(BOUNCE_DISTANCE_MIN) |
                           (sheared ? PLANE_BIT(INDIRECT_STRATA) : 0) |
                           (adaptive ? PLANE_BIT(BOUNCE_DISTANCE_MAX) : 0);
    if (plan->indirect_filter == INDIRECT_FILTER_NONE) return 0;
    if (!(plan->planes & PLANES_BOUNCE_RAYS))
        return plan_field_refuse(at, ERR_RANGE, "indirect_filter", "has nothing to filter",
                                 (double)plan->indirect_filter);
    if ((plan->planes & needs) != needs)
        return plan_field_refuse(at, ERR_RANGE, "planes",
                                 "lacks what filters of indirect light read", (double)plan->planes);
    return 0;
}

/* Second sets of glossy lobes go by surfaces, and by what the first ones measured. */
static int check_span(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t needs = PLANES_GEOMETRY | PLANE_BIT(ID) | PLANES_GLOSSY_LIGHT;
    if (plan_strata_maps(plan) < 2 || (plan->planes & needs) == needs) return 0;
    return plan_field_refuse(at, ERR_RANGE, "planes", "lacks what second sets of lobes go by",
                             (double)plan->planes);
}

/* Checks the planes of the filter of glossy lobes: surfaces, and all that their rays have measured.
 *  */
static int check_glossy_filter(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t needs = PLANES_GEOMETRY | PLANE_BIT(ID) | PLANES_GLOSSY_LIGHT;
    if (plan->glossy_filter == GLOSSY_FILTER_NONE) return 0;
    if ((plan->planes & needs) != needs)
        return plan_field_refuse(at, ERR_RANGE, "planes", "lacks what filters of glossy lobes read",
                                 (double)plan->planes);
    return 0;
}

/* Open Image Denoise sees a frame once, as a whole, and tells no error. */
static int check_oidn(const struct plan_field *at, const struct plan *plan)
{
    const bool fits = !(plan->target_error > 0.0f) && plan->lens_strata_per_axis == 0 &&
                      plan->paths.spp > 0 && !plan->composite;
    if (!fits)
        return plan_field_refuse(at, ERR_RANGE, "residual_filter",
                                 "has no paths of one picture of unknown error to filter",
                                 (double)plan->residual_filter);
    if ((plan->planes & PLANES_OIDN_READ) != PLANES_OIDN_READ)
        return plan_field_refuse(at, ERR_RANGE, "planes", "lacks what Open Image Denoise reads",
                                 (double)plan->planes);
    return 0;
}

/* Halves of the paths, and what their weights look at. */
static int check_residual_filter(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t finds = PLANES_GEOMETRY | PLANE_BIT(ID);
    if (plan->temporal > 0 && (plan->residual_filter != RESIDUAL_FILTER_HALVES ||
                               plan->lens_strata_per_axis > 0 || plan_has_rounds(plan)))
        return plan_field_refuse(at, ERR_RANGE, "temporal",
                                 "belongs to the residual filter of a pinhole without rounds",
                                 (double)plan->temporal);
    if (plan->temporal > 0 && (plan->planes & finds) != finds)
        return plan_field_refuse(at, ERR_RANGE, "planes",
                                 "lacks the surfaces that other frames are asked for",
                                 (double)plan->planes);
    if (plan->residual_filter == RESIDUAL_FILTER_OIDN) return check_oidn(at, plan);
    if (plan->residual_filter == RESIDUAL_FILTER_NONE) return 0;
    if ((plan->planes & PLANES_RESIDUAL_READ) != PLANES_RESIDUAL_READ)
        return plan_field_refuse(at, ERR_RANGE, "planes", "lacks what the residual filter reads",
                                 (double)plan->planes);
    if ((plan->planes >> PLANE_PATH_DIFFUSE_INDIRECT & 1u) !=
        (plan->planes >> PLANE_PATH_HALF_INDIRECT & 1u))
        return plan_field_refuse(at, ERR_RANGE, "planes",
                                 "has one of path_diffuse_indirect and path_half_indirect",
                                 (double)plan->planes);
    return 0;
}

/* Lens samples have their planes, and filters of them the slopes. */
static int check_lens_planes(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t planes = plan->planes & PLANES_LENS;
    const bool has_radiance = planes & PLANE_BIT(LENS_RADIANCE);
    int error =
        plan_field_count(at, "lens_strata_per_axis", plan->lens_strata_per_axis,
                         has_radiance ? 1 : 0, has_radiance ? LIMIT_PLANE_STRATA_PER_AXIS : 0);
    if (error) return error;
    if (plan_lens_has_paths(plan) &&
        plan->paths.spp != plan->lens_strata_per_axis * plan->lens_strata_per_axis)
        return plan_field_refuse(at, ERR_RANGE, "paths.spp",
                                 "differs from the lens samples, which are the paths",
                                 (double)plan->paths.spp);
    if (planes && !has_radiance)
        return plan_field_refuse(at, ERR_RANGE, "planes",
                                 "asks for lens samples without their radiance",
                                 (double)plan->planes);
    if (planes && !(plan->camera.aperture_radius > 0.0f))
        return plan_field_refuse(at, ERR_RANGE, "planes", "asks for lens samples of a pinhole",
                                 (double)plan->planes);
    if (planes && plan->target_error > 0.0f)
        return plan_field_refuse(at, ERR_RANGE, "target_error",
                                 "is a target for a lens of unknown error",
                                 (double)plan->target_error);
    if (plan->lens_filter != LENS_FILTER_NONE && !(planes & PLANE_BIT(LENS_SLOPE)))
        return plan_field_refuse(at, ERR_RANGE, "planes",
                                 "lacks the slopes that filters of lenses read",
                                 (double)plan->planes);
    return 0;
}

/* Light fields light what lens samples tell of, from surfaces at pixel centres. */
static int check_lens_relight(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t surface = plan->planes & PLANES_LENS_SURFACE;
    const uint64_t field = PLANES_GEOMETRY | PLANE_BIT(LENS_SLOPE);
    const bool bounces = plan->planes & PLANES_BOUNCE_LIGHT;
    if (surface != (plan->lens_relight == LENS_RELIGHT_OWN ? 0 : PLANES_LENS_SURFACE))
        return plan_field_refuse(at, ERR_RANGE, "planes",
                                 surface ? "tells of surfaces of lens samples that nothing lights"
                                         : "lacks the surfaces of lens samples",
                                 (double)plan->planes);
    if (plan->planes & PLANE_BIT(LENS_LOBE) &&
        (!(surface && bounces) || plan->lens_relight == LENS_RELIGHT_DIFFUSE ||
         plan->glossy_filter == GLOSSY_FILTER_NONE))
        return plan_field_refuse(at, ERR_RANGE, "planes",
                                 "tells of lobes of lens samples that nothing lights",
                                 (double)plan->planes);
    if (plan->lens_relight == LENS_RELIGHT_OWN) return 0;
    if ((plan->planes & field) != field || (!bounces && plan->lens_relight != LENS_RELIGHT_DIFFUSE))
        return plan_field_refuse(at, ERR_RANGE, "planes", "lacks the light fields of lens samples",
                                 (double)plan->planes);
    if (plan->lens_relight == LENS_RELIGHT_SKY && plan->environment.kind == ENVIRONMENT_NONE)
        return plan_field_refuse(at, ERR_RANGE, "lens_relight", "asks for light of no environment",
                                 (double)plan->lens_relight);
    return 0;
}

/* Checks mirrors of lens samples. Light fields light what mirrors show as they light lens samples,
 * and each reflection is a bounce. The sheared filter of indirect light would use directions of the
 * mirror image. */
static int check_lens_mirrors(const struct plan_field *at, const struct plan *plan)
{
    const uint32_t light = plan->lens_relight;
    const bool lit = light == LENS_RELIGHT_INDIRECT || light == LENS_RELIGHT_SKY;
    const bool sheared = plan->indirect_filter == INDIRECT_FILTER_SHEARED;
    const bool lobes = (plan->planes & PLANE_BIT(LENS_LOBE)) != 0;
    const uint32_t most = plan->bounces < PLAN_LENS_MIRRORS ? plan->bounces : PLAN_LENS_MIRRORS;
    const int error =
        plan_field_count(at, "lens_mirrors", plan->lens_mirrors, 0, lit && !sheared ? most : 0);
    return error ? error
                 : plan_field_count(at, "lens_lobes_only", plan->lens_lobes_only, 0, lobes ? 1 : 0);
}

/* Second sets go to pixels that slopes tell of, beside filters that work with both. */
static int check_lens_extra(const struct plan_field *at, const struct plan *plan)
{
    const bool more = plan->lens_extra > 0;
    if (more != ((plan->planes & PLANE_BIT(LENS_SECOND_SET)) != 0))
        return plan_field_refuse(at, ERR_RANGE, "planes", "has to have what second sets bring",
                                 (double)plan->planes);
    if (more && plan->lens_filter != LENS_FILTER_SHEARED)
        return plan_field_refuse(at, ERR_RANGE, "lens_extra", "belongs to the sheared filter",
                                 (double)plan->lens_extra);
    if (more && plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE)
        return plan_field_refuse(at, ERR_RANGE, "lens_extra",
                                 "asks for a second set where bounce rays have one",
                                 (double)plan->lens_extra);
    return 0;
}

/* What paths leave to fields is there. */
static int check_sky(const struct plan_field *at, const struct plan *plan)
{
    const uint32_t left = plan->paths.without_diffuse_indirect;
    if (left != INDIRECT_LEFT_SKY || plan->environment.kind != ENVIRONMENT_NONE) return 0;
    return plan_field_refuse(at, ERR_RANGE, "paths.without_diffuse_indirect",
                             "leaves out an environment, of which there is none", (double)left);
}

/* At half resolution filters of one width take what pixels lend each other; whoever counts a
 * pixel's own rays cannot. */
static int check_half_field(const struct plan_field *at, const struct plan *plan)
{
    const uint32_t filter = plan->indirect_filter;
    const bool takes = filter == INDIRECT_FILTER_CONSTANT || filter == INDIRECT_FILTER_LINEAR;
    if (!plan->field_halved) return 0;
    if (takes && !(plan->planes & (PLANES_LENS_ALL | PLANE_BIT(INDIRECT_STRATA))) &&
        !plan_has_rounds(plan))
        return 0;
    return plan_field_refuse(at, ERR_RANGE, "field_halved",
                             "asks for half resolution of a field that needs all of its rays", 1.0);
}

int plan_filters_check(const struct plan_field *at, const struct plan *plan)
{
    if (!(plan->mu > 0.0f))
        return plan_field_refuse(at, ERR_RANGE, "mu", "makes filters of no width",
                                 (double)plan->mu);
    int error = check_sky(at, plan);
    if (!error) error = check_shadow_filter(at, plan);
    if (!error) error = check_indirect_filter(at, plan);
    if (!error) error = check_rate(at, plan);
    if (!error) error = check_half_field(at, plan);
    if (!error) error = check_span(at, plan);
    if (!error) error = check_glossy_filter(at, plan);
    if (!error) error = check_residual_filter(at, plan);
    if (!error) error = check_lens_planes(at, plan);
    if (!error) error = check_lens_relight(at, plan);
    if (!error) error = check_lens_mirrors(at, plan);
    return error ? error : check_lens_extra(at, plan);
}
