#pragma once
/* The environment as a plan places it: turned, scaled, or the same from everywhere. Directions are
 * the world's. */
#include <stdbool.h>

#include "proto/plan.h"
#include "worker/scene/environment.h"
#include "worker/scene/sky_guide.h"
#include "worker/shade/lanes.h"

struct sky {
    uint32_t kind; /* enum environment_kind */
    const struct environment *map;
    const struct sky_guide *guide; /* of the map's samples */
    float radiance[3];             /* or the map's factor */
    float cosine, sine;            /* of the map's rotation */
    float width, height;           /* of the map, in texels */
    float soft_max; /* luminance of the map's lookups above which light is not soft */
    bool hard;      /* some lookup is above */
};

/* Sets the sky of a plan. `map` is the plan's, with a guide of it, borrowed; NULL when it has
 * none. */
void sky_init(struct sky *sky, const struct plan_environment *plan, const struct environment *map,
              const struct sky_guide *guide);

/* Sixteen unit directions in the map's frame, set by path_kernels' find_sky. sky_ask prefetches a
 * lane's texels: call it for all lanes before the first sky_radiance. */
struct sky_view {
    struct lanes3 direction;
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES]; /* struct environment_spot */
};
void sky_ask(const struct sky *sky, const struct sky_view *view, int lane);

/* Computes the radiance from a lane's direction and returns its soft share. Radiance counts as soft
 * up to SKY_SOFT_TIMES the map's mean, so that a small solid angle w brings at most
 * SKY_SOFT_TIMES w/4pi of all light. The rest may cast shadows as sharp as the sun's. */
#define SKY_SOFT_TIMES PLAN_SKY_SOFT_TIMES
float sky_radiance(const struct sky *sky, const struct sky_view *view, int lane, float radiance[3]);

/* Returns the density per solid angle with which a map's directions are sampled from a table of the
 * guide. */
float sky_pdf(const struct sky *sky, const struct sky_view *view, int lane, uint32_t table);

/* Sixteen texels of a map from which directions are sampled. */
struct sky_texels {
    _Alignas(LANES_ALIGN) double near[LANES], far[LANES]; /* struct environment_texel */
    _Alignas(LANES_ALIGN) float column[LANES], density[LANES];
    struct lanes_mask below;
};

/* Sample a direction of a map by three uniform numbers and a table of the guide, with its density
 * per solid angle (0: none), in the steps of environment.h. path_kernels' place_sky then computes
 * the direction. */
struct sky_choice {
    uint32_t bin;
    float probability, within; /* of the bin; the rest of the choice, within it */
};
struct sky_choice sky_expect(const struct sky *sky, uint32_t table, float choice, const float u[2]);
uint32_t sky_choose(const struct sky *sky, const struct sky_choice *choice, const float u[2]);
void sky_look(const struct sky *sky, const struct sky_choice *choice, uint32_t texel, int lane,
              struct sky_texels *out);
