#pragma once
/* The plan's lights, prepared for tracing: areas, clearances, probabilities. */
#include "proto/plan.h"

struct light {
    const struct plan_light *plan;
    float area;       /* of a rectangle */
    float clearance;  /* scene units in front of a rectangle at which its shadow rays end, so that
                         the emitter's own geometry does not block them */
    float cone_scale; /* 1 / (cos_inner - cos_outer) */
    float inverse_range;    /* 0: no range */
    float probability;      /* of being chosen at a bounce */
    float probability_upto; /* sum of this light's and all before it */
};

struct light_table {
    uint32_t count;
    struct light lights[LIMIT_LIGHTS];
};

/* `plan` must outlive the table. */
void light_table_init(struct light_table *t, const struct plan *plan);

/* The light that x in [0, 1) chooses, each with its probability. The table must not be empty. */
uint32_t light_table_choose(const struct light_table *t, float x);
