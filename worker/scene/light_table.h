#pragma once
/* The plan's lights, prepared for tracing with their areas, clearances and probabilities. */
#include <stdbool.h>

#include "proto/plan.h"

struct light {
    const struct plan_light *plan;
    float area;       /* of a rectangle */
    float clearance;  /* scene units in front of a rectangle at which its shadow rays end, so that
                         the emitter's own geometry does not block them */
    float cone_scale; /* 1 / (cos_inner - cos_outer) */
    float inverse_range; /* 0: no range */
    bool is_net;         /* where its strata lie: a net's jitters, or those of the lattice */
    struct pattern_lattice lattice;
    float probability;      /* of being chosen */
    float probability_upto; /* sum of this light's and all before it */
};

/* The results of light_table_choose besides the numbers of lights. */
#define LIGHT_CHOICE_EMITTERS    LIMIT_LIGHTS
#define LIGHT_CHOICE_ENVIRONMENT (LIMIT_LIGHTS + 1)

struct light_table {
    uint32_t count;
    struct light lights[LIMIT_LIGHTS];
    float emitters_probability;    /* of choosing the mesh emitters; 0 without */
    float environment_probability; /* of an environment map; what is the same from everywhere is
                                      never chosen: scattering finds it better */
};

/* Prepares the lights of a plan, which must outlive the table. Without `emitters` no mesh is
 * chosen, whatever its power in the plan. */
void light_table_init(struct light_table *t, const struct plan *plan, bool emitters);

/* Returns whether there is anything to choose. */
bool light_table_is_empty(const struct light_table *t);

/* Returns the light that x in [0, 1) chooses, each with its probability, or LIGHT_CHOICE_EMITTERS
 * or _ENVIRONMENT. The table must not be empty. */
uint32_t light_table_choose(const struct light_table *t, float x);
