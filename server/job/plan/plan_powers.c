/* Estimates how much light each source sends into the scene. */
#include <math.h>

#include "server/job/plan/plan_parts.h"

/* The mean of exp(-2 (u^2 + v^2)) over the square [-1, 1]^2: (sqrt(pi / 2) erf(sqrt 2) / 2)^2. */
#define GAUSSIAN_MEAN 0.357735

/* A source that a path chose less often than this would return as rare bright samples. */
#define POWER_MIN 1e-3

double plan_luminance(const float color[3])
{
    return 0.2126 * (double)color[0] + 0.7152 * (double)color[1] + 0.0722 * (double)color[2];
}

double plan_scene_radius(const struct scene *scene)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        double side = (double)scene->info->bounds_max[i] - (double)scene->info->bounds_min[i];
        sum += side * side / 4;
    }
    return sum > 0 && isfinite(sum) ? sqrt(sum) : 1;
}

static double area_of(const struct plan_light *light)
{
    double n[3];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = (double)light->half_u[j] * (double)light->half_v[k] -
               (double)light->half_u[k] * (double)light->half_v[j];
    }
    return 4 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

/* Returns the luminance that a light sends into the scene. A directional light sends it through the
 * disc of the scene's bounding sphere. */
static double light_flux(const struct plan_light *light, double radius)
{
    double l = plan_luminance(light->color);
    switch (light->type) {
    case LIGHT_POINT:
        return 4 * M_PI * l;
    case LIGHT_SPOT:
        return 2 * M_PI * (1 - (double)light->cos_outer) * l;
    case LIGHT_DIRECTIONAL:
        return M_PI * radius * radius * l;
    default:
        return M_PI * area_of(light) * l * (light->profile == PROFILE_GAUSSIAN ? GAUSSIAN_MEAN : 1);
    }
}

/* Returns the environment's flux. It counts as a directional light with the irradiance pi times the
 * mean, which a surface in the open receives. */
static double environment_flux(const float mean[3], double radius)
{
    return M_PI * radius * radius * M_PI * plan_luminance(mean);
}

/* Returns a source's share of the sum, or 0 if it sends nothing. Without a finite sum all are
 * alike. */
static float share(double flux, double sum)
{
    if (!(flux > 0)) return 0;
    double part = isfinite(sum) ? flux / sum : 1;
    return (float)(part > POWER_MIN ? part : POWER_MIN);
}

void plan_set_powers(const struct scene *scene, const struct plan_emitters *emitters,
                     const float environment_mean[3], struct plan *plan)
{
    double radius = plan_scene_radius(scene), environment = 0, sum = emitters->flux;
    if (plan->environment.kind != ENVIRONMENT_NONE)
        environment = environment_flux(environment_mean, radius);
    sum += environment;
    for (uint32_t k = 0; k < plan->light_count; k++) sum += light_flux(&plan->lights[k], radius);
    for (uint32_t k = 0; k < plan->light_count; k++) {
        float power = share(light_flux(&plan->lights[k], radius), sum);
        plan->lights[k].power = power > 0 ? power : (float)POWER_MIN;
    }
    plan->environment.power = share(environment, sum);
    plan->paths.emitter_power = share(emitters->flux, sum);
}
