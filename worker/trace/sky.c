#include "worker/trace/sky.h"

#include <string.h>

#include "worker/shade/elementary.h"

void sky_init(struct sky *sky, const struct plan_environment *plan, const struct environment *map)
{
    *sky = (struct sky){.kind = plan->kind, .map = map, .cosine = 1.0f};
    memcpy(sky->radiance, plan->radiance, sizeof sky->radiance);
    if (plan->kind != ENVIRONMENT_MAP) return;
    sky->cosine = elementary_cos(plan->rotation_rad);
    sky->sine = elementary_sin(plan->rotation_rad);
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
    float turned[3];
    memcpy(radiance, sky->radiance, 3 * sizeof radiance[0]);
    if (sky->kind != ENVIRONMENT_MAP) return;
    turn_back(sky, direction, turned);
    environment_lookup(sky->map, turned, radiance);
    for (int c = 0; c < 3; c++) radiance[c] *= sky->radiance[c];
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
