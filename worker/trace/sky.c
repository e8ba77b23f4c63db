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

struct sky_view sky_find(const struct sky *sky, const float direction[3])
{
    struct sky_view view = {.spot = {0.0f, 0.0f}};
    if (sky->kind != ENVIRONMENT_MAP) return view;
    turn_back(sky, direction, view.direction);
    view.spot = environment_find(sky->map, view.direction);
    return view;
}

float sky_radiance(const struct sky *sky, const struct sky_view *view, float radiance[3])
{
    memcpy(radiance, sky->radiance, 3 * sizeof radiance[0]);
    if (sky->kind != ENVIRONMENT_MAP) return 1.0f;
    environment_read(sky->map, view->spot, radiance);
    const float bright = 0.2126f * radiance[0] + 0.7152f * radiance[1] + 0.0722f * radiance[2];
    for (int c = 0; c < 3; c++) radiance[c] *= sky->radiance[c];
    return bright > sky->soft_most ? sky->soft_most / bright : 1.0f;
}

float sky_pdf(const struct sky *sky, const struct sky_view *view)
{
    return environment_density(sky->map, view->direction, view->spot);
}

void sky_expect(const struct sky *sky, float choice, const float u[2])
{
    environment_expect(sky->map, choice, u);
}

uint32_t sky_choose(const struct sky *sky, float choice, const float u[2])
{
    return environment_choose(sky->map, choice, u);
}

void sky_place(const struct sky *sky, uint32_t chosen, const float u[2], float direction[3],
               float *pdf)
{
    float turned[3];
    environment_place(sky->map, chosen, u, turned, pdf);
    direction[0] = sky->cosine * turned[0] - sky->sine * turned[2];
    direction[1] = turned[1];
    direction[2] = sky->sine * turned[0] + sky->cosine * turned[2];
}
