#pragma once
/* The environment as a plan places it: turned, scaled, or the same from everywhere. Directions are
 * the world's. */
#include <stdbool.h>

#include "proto/plan.h"
#include "worker/scene/environment.h"

struct sky {
    uint32_t kind; /* enum environment_kind */
    const struct environment *map;
    float radiance[3];  /* or the map's factor */
    float cosine, sine; /* of the map's rotation */
    float soft_most;    /* luminance of the map's lookups above which light is not soft */
    bool hard;          /* some lookup is above */
};

/* `map` is the plan's, NULL when it has none; borrowed. */
void sky_init(struct sky *sky, const struct plan_environment *plan, const struct environment *map);

/* A unit direction as a map has it, found ahead of what is asked of it (environment.h: who looks
 * at several directions finds all of them first). */
struct sky_view {
    float direction[3];
    struct environment_spot spot;
};
struct sky_view sky_find(const struct sky *sky, const float direction[3]);

/* Radiance from there; returns which share of it is soft: up to so many times the map's mean that
 * what fills a small solid angle w brings no more than SKY_SOFT_TIMES w/4pi of all light, however
 * bright it is. Shadows of the rest may be as sharp as those of a sun. */
#define SKY_SOFT_TIMES PLAN_SKY_SOFT_TIMES
float sky_radiance(const struct sky *sky, const struct sky_view *view, float radiance[3]);

/* Of a map: the density per solid angle with which directions are sampled. */
float sky_pdf(const struct sky *sky, const struct sky_view *view);

/* Of a map: a direction by three uniform numbers, its density per solid angle (0: none), in the
 * steps of environment.h. */
void sky_expect(const struct sky *sky, float choice, const float u[2]);
uint32_t sky_choose(const struct sky *sky, float choice, const float u[2]);
void sky_place(const struct sky *sky, uint32_t chosen, const float u[2], float direction[3],
               float *pdf);
