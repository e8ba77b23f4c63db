/* Lists the scene's lights and the job's, without those that cannot matter. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "server/job/plan/plan_parts.h"

/* A white surface that sends so much on is white in any view. */
#define TOO_BRIGHT 8.0

static double normal_of(const struct plan_light *light, double n[3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = (double)light->half_u[j] * (double)light->half_v[k] -
               (double)light->half_u[k] * (double)light->half_v[j];
    }
    return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

/* Returns whether all corners of the scene's bounds lie behind a rectangle. */
static bool faces_away(const struct plan_light *light, const struct scene_info *info)
{
    for (int corner = 0; corner < 8; corner++) {
        double along = 0;
        for (int i = 0; i < 3; i++) {
            float at = corner >> i & 1 ? info->bounds_max[i] : info->bounds_min[i];
            along += ((double)at - (double)light->position[i]) * (double)light->direction[i];
        }
        if (along > 0) return false;
    }
    return true;
}

static bool out_of_range(const struct plan_light *light, const struct scene_info *info)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        double p = (double)light->position[i], below = (double)info->bounds_min[i] - p,
               above = p - (double)info->bounds_max[i];
        double gap = below > above ? below : above;
        sum += gap > 0 ? gap * gap : 0;
    }
    return sum > (double)light->range * (double)light->range;
}

/* Returns why a light cannot change the picture, or NULL if it may. */
static const char *why_without_effect(const struct plan_light *light, const struct scene_info *info)
{
    double n[3];
    if (!(light->color[0] > 0 || light->color[1] > 0 || light->color[2] > 0))
        return "its colour is black";
    if (light->type == LIGHT_SPOT && !(light->cos_outer < light->cos_inner))
        return "its cone is empty";
    if (light->type == LIGHT_RECTANGLE && !(normal_of(light, n) > 0)) return "it has no area";
    if (light->type == LIGHT_RECTANGLE && faces_away(light, info))
        return "it faces away from the whole scene";
    if (light->range > 0 && light->type <= LIGHT_SPOT && out_of_range(light, info))
        return "its range ends before the scene begins";
    return NULL;
}

static void set_normal(struct plan_light *light)
{
    double n[3], length = normal_of(light, n);
    if (length > 0)
        for (int i = 0; i < 3; i++) light->direction[i] = (float)(n[i] / length);
}

static void from_scene(const struct scene_light *in, struct plan_light *out)
{
    *out = (struct plan_light){.type = in->type,
                               .profile = in->profile,
                               .cos_inner = in->cos_inner,
                               .cos_outer = in->cos_outer,
                               .range = in->range};
    memcpy(out->position, in->position, sizeof out->position);
    memcpy(out->direction, in->direction, sizeof out->direction);
    memcpy(out->half_u, in->half_u, sizeof out->half_u);
    memcpy(out->half_v, in->half_v, sizeof out->half_v);
    memcpy(out->color, in->color, sizeof out->color);
}

static int add(struct plan_light *light, const struct plan_light_source *source,
               const struct scene *scene, struct plan *plan, struct plan_report *report,
               struct fault *fault)
{
    struct fault inner = {0};
    char what[64], place[48];
    if (source->of_scene)
        snprintf(place, sizeof place, "scene light %u", source->index);
    else
        snprintf(place, sizeof place, "/lights/%u", source->index);
    if (light->type == LIGHT_RECTANGLE) set_normal(light);
    const char *why = why_without_effect(light, scene->info);
    if (why) {
        snprintf(what, sizeof what, "light %s", place);
        /* Room is left for what the rest of the plan leaves out. */
        if (report->skip_count < LIMIT_LIGHTS) plan_skip(report, what, "%s", why);
        return 0;
    }
    if (plan->light_count == LIMIT_LIGHTS)
        return fault_set(fault, ERR_LIMIT, "/lights",
                         "the scene's lights and the job's are more than %d", LIMIT_LIGHTS);
    if (plan_light_check(light, "", &inner) != 0)
        return fault_set(fault, inner.code, source->of_scene ? "/scene/asset" : place, "%s: %s: %s",
                         place, inner.pointer, inner.detail);
    report->lights[plan->light_count] = *source;
    plan->lights[plan->light_count++] = *light;
    return 0;
}

static int add_scene_lights(const struct scene *scene, struct plan *plan,
                            struct plan_report *report, struct fault *fault)
{
    for (uint64_t i = 0; i < scene->count[SCENE_LIGHTS]; i++) {
        struct plan_light light;
        struct plan_light_source source = {.of_scene = true, .index = (uint32_t)i};
        snprintf(source.name, sizeof source.name, "%.63s",
                 scene_name(scene, scene->lights[i].name));
        from_scene(&scene->lights[i], &light);
        int error = add(&light, &source, scene, plan, report, fault);
        if (error) return error;
    }
    return 0;
}

static double strongest(const float c[3])
{
    return (double)fmaxf(c[0], fmaxf(c[1], c[2]));
}

/* Returns the radiance that a white surface sends on of the light, at a tenth of the scene's radius
 * or more, and of rectangles at a thousandth, since small ones may have any radiance. */
static double sent_on(const struct plan_light *light, double radius)
{
    const double strength = strongest(light->color), away = radius / 10, beside = radius / 1000;
    double n[3];
    if (light->type == LIGHT_DIRECTIONAL) return strength / M_PI;
    if (light->type != LIGHT_RECTANGLE) return strength / (M_PI * away * away);
    return strength * fmin(1, 4 * normal_of(light, n) / (M_PI * beside * beside));
}

/* Returns a power of two that scales the strongest expected radiance to 256. The largest half float
 * is 256 times that, the radiance of a light sixteen times as near; more is clipped. The smallest
 * normal one is 22 powers of two below. */
static float radiance_scale(const struct scene *scene, const float environment_mean[3],
                            const struct plan *plan)
{
    /* Were all of the environment's light to come from one side, a white surface would send so much
     * of it on. */
    double most = 4 * strongest(environment_mean), radius = plan_scene_radius(scene);
    for (uint64_t i = 0; i < scene->count[SCENE_MATERIALS]; i++) {
        const struct scene_material *m = &scene->materials[i];
        most = fmax(most, strongest(m->emission));
        if (m->flags & MATERIAL_UNLIT) most = fmax(most, 1);
    }
    for (uint32_t k = 0; k < plan->light_count; k++)
        most = fmax(most, sent_on(&plan->lights[k], radius));
    if (!(most > 0) || !isfinite(most)) return 1;
    int exponent = 8 - (int)ceil(log2(most));
    return ldexpf(1, exponent < -60 ? -60 : exponent > 60 ? 60 : exponent);
}

static float length_unit(const struct scene *scene)
{
    int exponent = (int)lround(log2(plan_scene_radius(scene)));
    return ldexpf(1, exponent < -60 ? -60 : exponent > 60 ? 60 : exponent);
}

int plan_gather_lights(const struct job *job, const struct scene *scene, struct plan *plan,
                       struct plan_report *report, struct fault *fault)
{
    int error = 0;
    plan->light_count = 0;
    if (job->scene_lights)
        error = add_scene_lights(scene, plan, report, fault);
    else if (scene->count[SCENE_LIGHTS] > 0)
        plan_skip(report, "scene lights", "scene.lights is false");
    for (uint32_t i = 0; !error && i < job->light_count; i++) {
        struct plan_light light = job->lights[i];
        for (int c = 0; c < 3; c++)
            light.position[c] = (float)((double)light.position[c] - scene->info->origin[c]);
        struct plan_light_source source = {.index = i};
        error = add(&light, &source, scene, plan, report, fault);
    }
    if (error) return error;
    uint32_t l = job_strata_per_axis(job->light_spp ? job->light_spp : job->spp);
    for (uint32_t k = 0; k < plan->light_count; k++)
        plan->lights[k].strata_per_axis = plan->lights[k].type == LIGHT_RECTANGLE ? l : 1;
    return 0;
}

/* Returns the radiance that a white surface in the scene's middle, or a fourth of its radius away,
 * sends on of all lights. */
static double middle_radiance(const struct scene *scene, const struct plan *plan)
{
    const double nearest = plan_scene_radius(scene) / 4;
    double sum = 0;
    for (uint32_t k = 0; k < plan->light_count; k++) {
        const struct plan_light *light = &plan->lights[k];
        const double strength = strongest(light->color);
        double along = 0;
        double n[3], square = nearest * nearest, away = 0;
        for (int c = 0; c < 3; c++) {
            const double centre =
                ((double)scene->info->bounds_min[c] + scene->info->bounds_max[c]) / 2;
            const double way = centre - (double)light->position[c];
            away += way * way;
            along += way * (double)light->direction[c];
        }
        if (light->type == LIGHT_RECTANGLE && along <= 0) continue;
        if (light->type == LIGHT_SPOT && along < (double)light->cos_outer * sqrt(away)) continue;
        square = fmax(square, away);
        if (light->type == LIGHT_DIRECTIONAL)
            sum += strength / M_PI;
        else if (light->type == LIGHT_RECTANGLE)
            sum += strength * fmin(1, 4 * normal_of(light, n) / (M_PI * square));
        else
            sum += strength / (M_PI * square);
    }
    return sum;
}

void plan_tell_brightness(const struct job *job, const struct scene *scene, const struct plan *plan,
                          struct plan_report *report)
{
    const double shown = middle_radiance(scene, plan) * exp2((double)job->exposure);
    if (!(shown > TOO_BRIGHT) || !isfinite(shown)) return;
    const int stops = (int)lround(log2(shown));
    const double exposure = (double)job->exposure - stops;
    if (exposure >= (double)-LIMIT_EXPOSURE_EV)
        plan_warn(report,
                  "the lights make white surfaces some %d stops brighter than white: "
                  "image.exposure %g shows them",
                  stops, exposure);
    else
        plan_warn(report, "the lights make white surfaces some %d stops brighter than white",
                  stops);
}

void plan_set_scales(const struct scene *scene, const float environment_mean[3], struct plan *plan)
{
    plan->radiance_scale = radiance_scale(scene, environment_mean, plan);
    plan->length_unit = length_unit(scene);
}
