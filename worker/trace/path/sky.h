#pragma once
/* The environment as a plan places it: turned, scaled, or the same from everywhere. Directions are
 * the world's. */
#include <stdbool.h>

#include "proto/plan.h"
#include "worker/scene/environment.h"
#include "worker/shade/lanes.h"

struct sky {
    uint32_t kind; /* enum environment_kind */
    const struct environment *map;
    float radiance[3];   /* or the map's factor */
    float cosine, sine;  /* of the map's rotation */
    float width, height; /* of the map, in texels */
    float soft_most;     /* luminance of the map's lookups above which light is not soft */
    bool hard;           /* some lookup is above */
};

/* `map` is the plan's, NULL when it has none; borrowed. */
void sky_init(struct sky *sky, const struct plan_environment *plan, const struct environment *map);

/* Unit directions as a map has them, sixteen side by side: path_kernels' find_sky sets them. Who
 * reads several asks for all of them first. */
struct sky_view {
    struct lanes3 direction;
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES]; /* struct environment_spot */
};
void sky_ask(const struct sky *sky, const struct sky_view *view, int lane);

/* Radiance from there; returns which share of it is soft: up to so many times the map's mean that
 * what fills a small solid angle w brings no more than SKY_SOFT_TIMES w/4pi of all light, however
 * bright it is. Shadows of the rest may be as sharp as those of a sun. */
#define SKY_SOFT_TIMES PLAN_SKY_SOFT_TIMES
float sky_radiance(const struct sky *sky, const struct sky_view *view, int lane, float radiance[3]);

/* Of a map: the density per solid angle with which directions are sampled. */
float sky_pdf(const struct sky *sky, const struct sky_view *view, int lane);

/* Texels of a map from which directions are sampled, sixteen side by side. */
struct sky_texels {
    _Alignas(LANES_ALIGN) double near[LANES], far[LANES]; /* struct environment_texel */
    _Alignas(LANES_ALIGN) float column[LANES], density[LANES];
    struct lanes_mask below;
};

/* Of a map: a direction by three uniform numbers, its density per solid angle (0: none), in the
 * steps of environment.h; path_kernels' place_sky places it. */
void sky_expect(const struct sky *sky, float choice, const float u[2]);
uint32_t sky_choose(const struct sky *sky, float choice, const float u[2]);
void sky_look(const struct sky *sky, uint32_t chosen, int lane, struct sky_texels *out);
