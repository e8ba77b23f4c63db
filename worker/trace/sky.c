#include "worker/trace/sky.h"

#include <math.h>
#include <string.h>

#include "worker/shade/elementary.h"

void sky_init(struct sky *sky, const struct plan_environment *plan, const struct environment *map)
{
    *sky = (struct sky){.kind = plan->kind, .map = map, .cosine = 1.0f, .soft_most = INFINITY};
    memcpy(sky->radiance, plan->radiance, sizeof sky->radiance);
    if (plan->kind != ENVIRONMENT_MAP) return;
    sky->cosine = elementary_cos(plan->rotation_rad);
    sky->sine = elementary_sin(plan->rotation_rad);
    sky->soft_most = SKY_SOFT_TIMES * environment_mean(map);
    sky->hard = environment_most(map) > sky->soft_most;
}

/* From the world to the map. */
static void turn_back(const struct sky *sky, const float in[3], float out[3])
{
    out[0] = sky->cosine * in[0] + sky->sine * in[2];
    out[1] = in[1];
    out[2] = sky->cosine * in[2] - sky->sine * in[0];
}

void sky_radiance(const struct sky *sky, const float direction[3], float radiance[3])
{
    sky_radiance_soft(sky, direction, radiance);
}

float sky_radiance_soft(const struct sky *sky, const float direction[3], float radiance[3])
{
    float turned[3];
    memcpy(radiance, sky->radiance, 3 * sizeof radiance[0]);
    if (sky->kind != ENVIRONMENT_MAP) return 1.0f;
    turn_back(sky, direction, turned);
    environment_lookup(sky->map, turned, radiance);
    const float bright = 0.2126f * radiance[0] + 0.7152f * radiance[1] + 0.0722f * radiance[2];
    for (int c = 0; c < 3; c++) radiance[c] *= sky->radiance[c];
    return bright > sky->soft_most ? sky->soft_most / bright : 1.0f;
}

void sky_sample(const struct sky *sky, float choice, const float u[2], float direction[3],
                float *pdf)
{
    float turned[3];
    environment_sample(sky->map, choice, u, turned, pdf);
    direction[0] = sky->cosine * turned[0] - sky->sine * turned[2];
    direction[1] = turned[1];
    direction[2] = sky->sine * turned[0] + sky->cosine * turned[2];
}

float sky_pdf(const struct sky *sky, const float direction[3])
{
    float turned[3];
    turn_back(sky, direction, turned);
    return environment_pdf(sky->map, turned);
}
