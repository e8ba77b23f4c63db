#pragma once
/* The plan's lights, prepared for tracing with their areas, clearances and what bounds the light
 * that they send. */
#include <stdbool.h>

#include "proto/plan.h"
#include "worker/scene/emitter_tree.h"

struct light {
    const struct plan_light *plan;
    float area;       /* of a rectangle */
    float clearance;  /* scene units in front of a rectangle at which its shadow rays end, so that
                         the emitter's own geometry does not block them */
    float cone_scale; /* 1 / (cos_inner - cos_outer) */
    float inverse_range; /* 0: no range */
    bool is_net;         /* where its strata lie: a net's jitters, or those of the lattice */
    struct pattern_lattice lattice;
    float power;  /* luminance of its color; of a rectangle times the area, as mesh emitters' */
    float radius; /* of a sphere around a rectangle; else 0 */
};

/* What a light sample may choose: a light of the plan by its number, a group of mesh emitters
 * behind these, or the environment. */
#define LIGHT_CHOICES            (LIMIT_LIGHTS + EMITTER_GROUPS_MAX)
#define LIGHT_CHOICE_EMITTERS    LIMIT_LIGHTS
#define LIGHT_CHOICE_ENVIRONMENT LIGHT_CHOICES

/* At most this many lights without extent are all sampled at a camera path's first surface. */
#define LIGHTS_FEW 8u

struct light_table {
    uint32_t count;
    uint32_t points; /* of these, lights without extent */
    struct light lights[LIMIT_LIGHTS];
    const struct emitter_tree *emitters; /* borrowed; NULL: no mesh is chosen */
    float environment_probability; /* of an environment map; what is the same from everywhere is
                                      never chosen: scattering finds it better */
};

/* Prepares the lights of a plan, which must outlive the table, as must the emitters. Without them
 * (NULL) no mesh is chosen, whatever its power in the plan. */
void light_table_init(struct light_table *t, const struct plan *plan,
                      const struct emitter_tree *emitters);

/* Returns whether there is anything to choose. */
bool light_table_is_empty(const struct light_table *t);

/* Returns whether it is a light without extent: a point, a spot or a directional one. */
static inline bool light_is_point(const struct light *light)
{
    return light->plan->type != LIGHT_RECTANGLE;
}

/* Returns whether there is a single light of the plan, and nothing to choose. */
static inline bool light_table_is_single(const struct light_table *t)
{
    return t->count == 1 && !t->emitters && !(t->environment_probability > 0.0f);
}

/* Returns whether surfaces that `depth` scatterings have led to take a sample of each light without
 * extent, beside one of all others. */
static inline bool light_table_takes_points(const struct light_table *t, uint32_t depth)
{
    return depth == 0 && t->points > 0 && t->points <= LIGHTS_FEW && !light_table_is_single(t);
}

/* Returns whether there are other lights than those. */
static inline bool light_table_has_extended(const struct light_table *t)
{
    return t->count > t->points || t->emitters || t->environment_probability > 0.0f;
}
