#include "worker/scene/light_table.h"

#include <math.h>

/* A recognised emitter's triangles lie this far at most from the rectangle that stands for them: a
 * part of its shorter half side, and the rounding of its coordinates. */
#define CLEARANCE_PART (1.0f / 8192)
#define CLEARANCE_ULPS 0x1p-20f

/* A cone's soft edge is at least this wide (as a cosine), so that its slope stays finite. */
#define CONE_EDGE_MIN 1e-6f

static float length(const float v[3])
{
    return sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void rectangle_init(struct light *light, const struct plan_light *p)
{
    float u = length(p->half_u), v = length(p->half_v), magnitude = 0.0f;
    for (int i = 0; i < 3; i++) {
        float reach = fabsf(p->position[i]) + fabsf(p->half_u[i]) + fabsf(p->half_v[i]);
        magnitude = reach > magnitude ? reach : magnitude;
    }
    light->area = 4.0f * u * v; /* the halves are orthogonal: plan_decode checks */
    float shorter = u < v ? u : v;
    float part = shorter * CLEARANCE_PART, rounding = magnitude * CLEARANCE_ULPS;
    light->clearance = part > rounding ? part : rounding;
}

static void light_init(struct light *light, const struct plan_light *p, double power)
{
    *light = (struct light){.plan = p};
    if (p->type == LIGHT_RECTANGLE) rectangle_init(light, p);
    float edge = p->cos_inner - p->cos_outer;
    light->cone_scale = 1.0f / (edge > CONE_EDGE_MIN ? edge : CONE_EDGE_MIN);
    light->inverse_range = p->range > 0.0f ? 1.0f / p->range : 0.0f;
    light->probability = (float)((double)p->power / power); /* every power is positive */
}

static double total_power(const struct plan *plan, bool emitters)
{
    double power = emitters ? (double)plan->paths.emitter_power : 0.0;
    if (plan->environment.kind == ENVIRONMENT_MAP) power += (double)plan->environment.power;
    for (uint32_t i = 0; i < plan->light_count; i++) power += (double)plan->lights[i].power;
    return power;
}

void light_table_init(struct light_table *t, const struct plan *plan, bool emitters)
{
    double power = total_power(plan, emitters), upto = 0.0;
    t->count = plan->light_count;
    t->emitters_probability = t->environment_probability = 0.0f;
    for (uint32_t i = 0; i < t->count; i++) {
        light_init(&t->lights[i], &plan->lights[i], power);
        t->lights[i].is_net = !pattern_lattice_init(
            &plan->pattern, pattern_light_dimension(i, plan->lights[i].strata_per_axis),
            &t->lights[i].lattice);
        upto += (double)plan->lights[i].power;
        t->lights[i].probability_upto = (float)(upto / power);
    }
    if (emitters && plan->paths.emitter_power > 0.0f)
        t->emitters_probability = (float)((double)plan->paths.emitter_power / power);
    if (plan->environment.kind == ENVIRONMENT_MAP)
        t->environment_probability = (float)((double)plan->environment.power / power);
}

bool light_table_is_empty(const struct light_table *t)
{
    return t->count == 0 && !(t->emitters_probability > 0.0f) &&
           !(t->environment_probability > 0.0f);
}

uint32_t light_table_choose(const struct light_table *t, float x)
{
    bool emitters = t->emitters_probability > 0.0f;
    bool environment = t->environment_probability > 0.0f;
    uint32_t last = environment ? LIGHT_CHOICE_ENVIRONMENT : emitters ? LIGHT_CHOICE_EMITTERS : 0;
    if (last == 0) last = t->count - 1;
    for (uint32_t i = 0; i < t->count; i++)
        if (x < t->lights[i].probability_upto) return i;
    if (emitters && x < 1.0f - t->environment_probability) return LIGHT_CHOICE_EMITTERS;
    return last;
}
