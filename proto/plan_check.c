/* What makes a plan safe to trace. */
#include "proto/plan_internal.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#include "proto/samples.h"

/* Floats that were orthonormal before they were rounded, or came from a decimal text. */
#define ORTHONORMAL_TOLERANCE 1e-3

/* A rectangle whose sides enclose a smaller sine has no usable normal. */
#define SINE_MIN 1e-6

/* Side, at distance 1, of the widest and the narrowest view: 179.99 degrees and a millionth. */
#define VIEW_MIN        1e-8f
#define VIEW_MAX        1e5f
#define VIEW_CENTRE_MAX 4.0f /* half images off the middle */

/* Powers are compared with each other, so they must not vanish or overflow in a sum. */
#define POWER_MIN 1e-37f
#define POWER_MAX 1e37f

#define CAPABILITIES_KNOWN                                                                         \
    (CAPABILITY_DIRECT | CAPABILITY_INDIRECT | CAPABILITY_VISIBILITY | CAPABILITY_STRATA |         \
     CAPABILITY_PATHS | CAPABILITY_ENVIRONMENT | CAPABILITY_LENS | CAPABILITY_STRATA_MAPS |        \
     CAPABILITY_VIEWS | CAPABILITY_SHUTTER)
#define PLANES_KNOWN ((PLANE_BIT(ID_COUNT) - 1) | PLANE_BIT(LONE) | PLANE_BIT(MIXED))
#define PLANES_SUB                                                                                 \
    (PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) | PLANE_BIT(SUB_ID))
#define LIGHT_PLANES_KNOWN ((1u << LIGHT_PLANE_COUNT) - 1)

static double dot(const float a[3], const float b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

static void cross(const float a[3], const float b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = (double)a[j] * (double)b[k] - (double)a[k] * (double)b[j];
    }
}

int plan_field_unit(const struct plan_field *at, const char *field, const float v[3], float min,
                    float max)
{
    const int error = plan_field_vector(at, field, v, min, max);
    if (error) return error;
    const double length = sqrt(dot(v, v));
    if (fabs(length - 1.0) > ORTHONORMAL_TOLERANCE)
        return plan_field_refuse(at, ERR_RANGE, field, "is its length, which must be 1", length);
    return 0;
}

/* The axes are unit vectors. */
static int check_axes(const struct plan_field *at, const struct plan_camera *c)
{
    const double skew = dot(c->right, c->up);
    if (fabs(skew) > ORTHONORMAL_TOLERANCE)
        return plan_field_refuse(at, ERR_RANGE, "up", "is its part along right, which must be 0",
                                 skew);
    double back[3];
    cross(c->right, c->up, back);
    for (int i = 0; i < 3; i++)
        if (fabs(back[i] + (double)c->forward[i]) > 2 * ORTHONORMAL_TOLERANCE)
            return plan_field_refuse(at, ERR_RANGE, "forward", "is not up x right",
                                     (double)c->forward[i]);
    return 0;
}

/* A lens needs something in focus; without one its other fields travel all the same. */
static int check_lens(const struct plan_field *at, const struct plan_camera *c)
{
    if (c->blade_count > 0 && c->blade_count < 3)
        return plan_field_refuse(at, ERR_RANGE, "blade_count", "is too small",
                                 (double)c->blade_count);
    if (!(c->aperture_radius > 0.0f)) return 0;
    if (c->type != CAMERA_PERSPECTIVE)
        return plan_field_refuse(at, ERR_RANGE, "aperture_radius", "is a lens before parallel rays",
                                 (double)c->aperture_radius);
    if (!(c->focus_distance > 0.0f))
        return plan_field_refuse(at, ERR_RANGE, "focus_distance", "is no distance to focus on",
                                 (double)c->focus_distance);
    return 0;
}

/* Accepts any value of a field. */
#define plan_field_any(at, name, value, from, to) 0

int plan_camera_check(const struct plan_camera *camera, const char *place, struct fault *fault)
{
    const struct plan_field at = {place, fault};
    int error = 0;
#define CAMERA(type, name, check, from, to)                                                        \
    if (!error) error = plan_field_##check(&at, #name, camera->name, from, to);
#include "proto/plan.def"
    const float max = camera->type == CAMERA_ORTHOGRAPHIC ? LIMIT_COORDINATE : VIEW_MAX;
    if (!error) error = plan_field_number(&at, "half_width", camera->half_width, VIEW_MIN, max);
    if (!error) error = plan_field_number(&at, "half_height", camera->half_height, VIEW_MIN, max);
    if (!error) error = check_axes(&at, camera);
    return error ? error : check_lens(&at, camera);
}

static int check_rectangle(const struct plan_field *at, const struct plan_light *light)
{
    double n[3];
    cross(light->half_u, light->half_v, n);
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const double sides =
        sqrt(dot(light->half_u, light->half_u) * dot(light->half_v, light->half_v));
    /* Four times it is the area that the tracer computes in float. */
    if (!(length >= 1e-30))
        return plan_field_refuse(at, ERR_RANGE, "half_u", "is a quarter of the area: too small",
                                 length);
    if (length < SINE_MIN * sides)
        return plan_field_refuse(at, ERR_RANGE, "half_v", "is its sine to half_u: parallel",
                                 length / sides);
    const double along = (n[0] * (double)light->direction[0] + n[1] * (double)light->direction[1] +
                          n[2] * (double)light->direction[2]) /
                         length;
    if (along < 1.0 - ORTHONORMAL_TOLERANCE)
        return plan_field_refuse(at, ERR_RANGE, "direction", "is its cosine to half_u x half_v",
                                 along);
    return 0;
}

static int check_cone(const struct plan_field *at, const struct plan_light *light)
{
    int error = plan_field_number(at, "cos_inner", light->cos_inner, 0.0f, 1.0f);
    if (!error) error = plan_field_number(at, "cos_outer", light->cos_outer, 0.0f, 1.0f);
    if (!error && !(light->cos_inner > light->cos_outer))
        error = plan_field_refuse(at, ERR_RANGE, "cos_inner", "is not above cos_outer",
                                  (double)light->cos_inner);
    return error;
}

static int check_shape(const struct plan_field *at, const struct plan_light *light)
{
    int error = 0;
    if (light->type == LIGHT_POINT) return 0;
    error = plan_field_unit(at, "direction", light->direction, -2.0f, 2.0f);
    if (!error && light->type == LIGHT_SPOT) error = check_cone(at, light);
    if (!error && light->type == LIGHT_RECTANGLE) error = check_rectangle(at, light);
    return error;
}

/* Fields that the type does not use travel all the same, so they must at least be numbers. */
int plan_light_check(const struct plan_light *light, const char *place, struct fault *fault)
{
    const struct plan_field at = {place, fault};
    int error = 0;
#define LIGHT(type, name, check, from, to)                                                         \
    if (!error) error = plan_field_##check(&at, #name, light->name, from, to);
#include "proto/plan.def"
    return error ? error : check_shape(&at, light);
}

static int check_light_sampling(const struct plan *plan, const struct plan_light *light,
                                const char *prefix, struct fault *fault)
{
    const struct plan_field at = {prefix, fault};
    const bool has_area = light->type == LIGHT_RECTANGLE;
    const bool per_stratum = has_area && (plan->light_planes & LIGHT_PLANES_STRATA);
    const int64_t max =
        !has_area ? 1 : (per_stratum ? LIMIT_PLANE_STRATA_PER_AXIS : LIMIT_STRATA_PER_AXIS);
    const int error = plan_field_number(&at, "power", light->power, POWER_MIN, POWER_MAX);
    if (error) return error;
    return plan_field_count(&at, "strata_per_axis", light->strata_per_axis, 1, max);
}

static int check_lights(const struct plan *plan, struct fault *fault)
{
    for (uint32_t k = 0; k < plan->light_count; k++) {
        char prefix[32];
        snprintf(prefix, sizeof prefix, "lights[%u]", k);
        int error = plan_light_check(&plan->lights[k], prefix, fault);
        if (!error) error = check_light_sampling(plan, &plan->lights[k], prefix, fault);
        if (error) return error;
    }
    return 0;
}

/* Errors are known where halves of the samples, or their spread, tell of them. */
static int check_target(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t paths = PLANE_BIT(PATH_M2) | PLANE_BIT(PATH_HALF_DIFFERENCE2);
    if ((plan->target_error > 0.0f) != (plan->spp_max > 0))
        return plan_field_refuse(at, ERR_RANGE, "spp_max",
                                 "belongs to a target, and every target has it",
                                 (double)plan->spp_max);
    if (!(plan->target_error > 0.0f)) return 0;
    if (plan->paths.spp > 0 && (plan->planes & paths) != paths)
        return plan_field_refuse(at, ERR_RANGE, "target_error",
                                 "is a target for paths of unknown error",
                                 (double)plan->target_error);
    if ((plan->planes & (PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_STRATA))) ||
        ((plan->planes & PLANES_GLOSSY) && !(plan->planes & PLANE_BIT(GLOSSY_HALF))) ||
        ((plan->planes & PLANE_BIT(INDIRECT_HALVES)) &&
         !(plan->planes & PLANE_BIT(BOUNCE_DISTANCE_MIN))))
        return plan_field_refuse(at, ERR_RANGE, "target_error",
                                 "is a target for bounces of unknown error",
                                 (double)plan->target_error);
    return 0;
}

static int refuse_planes(const struct plan_field *at, uint64_t planes, const char *text)
{
    return plan_field_refuse(at, ERR_RANGE, "planes", text, (double)planes);
}

/* Paths are traced for their planes, and planes are made from paths. */
static int check_path_planes(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t planes = plan->planes;
    const bool open = planes & (PLANE_BIT(PATH_VISIBILITY) | PLANE_BIT(AMBIENT_VISIBILITY));
    if ((planes & PLANES_PATH_ALL) && plan->paths.spp == 0)
        return refuse_planes(at, planes, "asks for paths, of which there are none");
    if (!(planes & PLANES_PATH) && plan->paths.spp > 0)
        return refuse_planes(at, planes, "has no place for what the paths bring");
    if ((planes & PLANE_BIT(PATH_M2)) && !(planes & PLANE_BIT(PATH_RADIANCE)))
        return refuse_planes(at, planes, "has path_m2 without path_radiance");
    if (plan->paths.without_diffuse_indirect && !(planes & PLANES_BOUNCE_LIGHT))
        return refuse_planes(at, planes, "has no place for indirect light that paths omit");
    if (plan->paths.without_glossy_indirect &&
        (planes & PLANES_GLOSSY_LIGHT) != PLANES_GLOSSY_LIGHT)
        return refuse_planes(at, planes, "has no place for glossy light that paths omit");
    if (open != (plan->occlusion_distance > 0.0f))
        return refuse_planes(at, planes,
                             open ? "asks for occlusion without a distance"
                                  : "has a distance of occlusion but no plane of it");
    return 0;
}

/* Lone sub-samples are found by what is seen, and shaded as pixel centres are. */
static int check_lone(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t planes = plan->planes;
    if (!(planes & PLANE_BIT(LONE))) return 0;
    if (plan->sub_samples == 0 || (planes & PLANES_COMPARED) != PLANES_COMPARED)
        return refuse_planes(at, planes, "lacks what lone sub-samples are found by");
    if (plan->camera.aperture_radius > 0.0f)
        return refuse_planes(at, planes, "asks for lone sub-samples with a lens");
    if (lone_parts(plan) == 0)
        return refuse_planes(at, planes, "has no light fields for lone sub-samples");
    if (plan->tile_px % LIMIT_TILE_SIDE_MIN_PX != 0)
        return plan_field_refuse(at, ERR_RANGE, "tile_px",
                                 "cuts the squares that lone sub-samples are shaded by",
                                 (double)plan->tile_px);
    return 0;
}

/* Mixed pixels are found by what is seen through pixels, and lit as sub-samples are; beside paths,
 * by pixel centres alone. */
static int check_mixed(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t planes = plan->planes;
    const bool more = plan->paths.edge_digits > 0;
    if (more && (plan->paths.spp == 0 || !(planes & PLANE_BIT(MIXED))))
        return plan_field_refuse(at, ERR_RANGE, "paths.edge_digits",
                                 "asks for paths of pixels that nothing finds",
                                 (double)plan->paths.edge_digits);
    if (!(planes & PLANE_BIT(MIXED))) return 0;
    const uint64_t needed = plan->paths.spp > 0 ? PLANES_CENTRE : PLANES_COMPARED;
    if ((plan->paths.spp == 0 && plan->sub_samples == 0) || (planes & needed) != needed)
        return refuse_planes(at, planes, "lacks what mixed pixels are found by");
    if (plan->camera.aperture_radius > 0.0f)
        return refuse_planes(at, planes, "asks for mixed pixels with a lens");
    return 0;
}

/* Planes and what they are made from. */
static int check_planes(const struct plan_field *at, const struct plan *plan)
{
    const uint64_t planes = plan->planes;
    if ((planes & (PLANES_SUB | PLANE_BIT(SUB_REFLECTANCE))) && plan->sub_samples == 0)
        return refuse_planes(at, planes, "asks for sub-samples, of which there are none");
    if ((planes & PLANE_BIT(SUB_DEPTH)) && !(planes & PLANE_BIT(DEPTH)))
        return refuse_planes(at, planes, "has sub_depth without depth");
    if ((planes & (PLANES_BOUNCE_LIGHT | PLANES_GLOSSY)) && plan->bounces == 0)
        return refuse_planes(at, planes, "asks for indirect light without bounces");
    if ((planes & PLANE_BIT(GLOSSY_HALF)) && (planes & PLANES_GLOSSY_LIGHT) != PLANES_GLOSSY_LIGHT)
        return refuse_planes(at, planes, "has half of what it lacks the whole of");
    if ((planes & PLANES_GLOSSY_AXES) && (planes & PLANES_GLOSSY_LIGHT) != PLANES_GLOSSY_LIGHT)
        return refuse_planes(at, planes, "has axes of lobes that it lacks");
    int error = check_lone(at, plan);
    if (!error) error = check_mixed(at, plan);
    return error ? error : check_path_planes(at, plan);
}

/* Bounce rays and rays of lobes have strata; paths bounce without. */
static int check_strata(const struct plan_field *at, const struct plan *plan)
{
    const bool per_stratum = plan->planes & PLANE_BIT(INDIRECT_STRATA);
    const bool has_strata = plan->planes & (PLANES_BOUNCE_RAYS | PLANES_GLOSSY);
    const int64_t max = !has_strata   ? 0
                        : per_stratum ? LIMIT_PLANE_STRATA_PER_AXIS
                                      : LIMIT_STRATA_PER_AXIS;
    return plan_field_count(at, "indirect_strata_per_axis", plan->indirect_strata_per_axis,
                            has_strata ? 1 : 0, max);
}

/* Checks each field by itself. */
static int check_fields(const struct plan_field *at, const struct plan *plan)
{
    int error = 0;
#define FIELD(type, name, check, from, to)                                                         \
    if (!error) error = plan_field_##check(at, #name, plan->name, from, to);
#include "proto/plan.def"
    return error;
}

/* Returns the most of enum direct_left that light fields may bring. */
static uint32_t direct_left_max(const struct plan *plan)
{
    const bool fields = plan->paths.spp > 0 && !plan->paths.without_glossy_indirect &&
                        plan->camera.aperture_radius == 0.0f &&
                        plan->paths.pixel_filter == PIXEL_FILTER_BOX &&
                        (plan->planes & PLANE_BIT(ALBEDO));
    const bool all = plan->environment.kind == ENVIRONMENT_NONE &&
                     (plan->paths.without_diffuse_indirect || plan->bounces == 0);
    if (!fields) return DIRECT_LEFT_NONE;
    return plan->paths.without_diffuse_direct == DIRECT_LEFT_ALL && !all ? DIRECT_LEFT_NONE
                                                                         : DIRECT_LEFT_LISTED;
}

/* Views have paths alone, all of which are in the schedule. */
static int check_composite(const struct plan_field *at, const struct plan *plan)
{
    const bool paths = plan->paths.spp > 0 && plan->paths.without_diffuse_direct == 0 &&
                       plan->paths.without_diffuse_indirect == 0 && plan->light_planes == 0 &&
                       plan->indirect_strata_per_axis == 0 && plan->lens_strata_per_axis == 0;
    const bool may = paths && !plan_has_rounds(plan);
    const struct plan_photograph *p = &plan->photograph;
    int error = plan_field_count(at, "composite", plan->composite, 0, may ? 1 : 0);
    if (!error && digest_is_zero(&p->blob) != (p->fit == PHOTOGRAPH_NONE))
        return plan_field_refuse(at, ERR_RANGE, "photograph.fit", "has no blob, or is none of one",
                                 (double)p->fit);
    if (!error && p->fit == PHOTOGRAPH_NONE)
        error = plan_field_count(at, "photograph.is_linear", p->is_linear, 0, 0);
    if (!error && !plan->composite) return plan_field_count(at, "photograph.fit", p->fit, 0, 0);
    if (error) return error;
    return plan_field_count(at, "paths.spp", plan->paths.spp, 1, LIMIT_COMPOSITE_SPP);
}

/* Times are of paths: fields of pixel centres are of one moment. */
static int check_shutter(const struct plan_field *at, const struct plan *plan)
{
    char place[24];
    const bool paths = plan->paths.spp > 0 && plan->paths.without_diffuse_direct == 0 &&
                       plan->paths.without_diffuse_indirect == 0 && plan->light_planes == 0 &&
                       plan->indirect_strata_per_axis == 0 && plan->lens_strata_per_axis == 0 &&
                       plan->paths.edge_digits == 0 && !(plan->planes & PLANE_BIT(MIXED));
    if (plan->pose_count == 0) return 0;
    int error = plan_field_count(at, "pose_count", plan->pose_count, paths ? SHUTTER_STEPS : 0,
                                 paths ? SHUTTER_STEPS : 0);
    for (uint32_t k = 0; k < plan->pose_count && !error; k++) {
        snprintf(place, sizeof place, "poses[%u]", k);
        error = plan_camera_check(&plan->poses[k], place, at->fault);
    }
    return error;
}

int plan_check(const struct plan *plan, struct fault *fault)
{
    const struct plan_field at = {"", fault};
    const float least_power = plan->environment.kind == ENVIRONMENT_NONE ? 0.0f : POWER_MIN;
    int error = check_fields(&at, plan);
    if (!error)
        error = plan_field_count(&at, "height_px", (int64_t)plan->width_px * plan->height_px, 1,
                                 LIMIT_IMAGE_PIXELS);
    if (!error) error = plan_camera_check(&plan->camera, "camera", fault);
    if (!error)
        error = plan_field_number(&at, "environment.power", plan->environment.power, least_power,
                                  POWER_MAX);
    if (!error)
        error = plan_field_count(&at, "paths.without_glossy_indirect",
                                 plan->paths.without_glossy_indirect, 0,
                                 plan->paths.without_diffuse_indirect);
    if (!error)
        error = plan_field_count(&at, "paths.without_diffuse_direct",
                                 plan->paths.without_diffuse_direct, 0, direct_left_max(plan));
    if (!error) error = check_target(&at, plan);
    if (!error) error = check_planes(&at, plan);
    if (!error) error = plan_filters_check(&at, plan);
    if (!error) error = check_strata(&at, plan);
    if (!error) error = check_composite(&at, plan);
    if (!error) error = check_shutter(&at, plan);
    return error ? error : check_lights(plan, fault);
}
