#include "worker/scene/light_table.h"

#include <math.h>

/* A recognised emitter's triangles lie this far at most from the rectangle that stands for them: a
 * part of its shorter half side, and the rounding of its coordinates. */
#define CLEARANCE_PART (1.0f / 8192)
#define CLEARANCE_ULPS 0x1p-20f

/* The mean of a Gaussian rectangle's profile: plan_powers.c. */
#define GAUSSIAN_MEAN 0.357735f

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
    light->radius = sqrtf(u * u + v * v);
    light->power *= light->area * (p->profile == PROFILE_GAUSSIAN ? GAUSSIAN_MEAN : 1.0f);
}

static void light_init(struct light *light, const struct plan_light *p)
{
    const float *c = p->color;
    *light = (struct light){.plan = p};
    light->power = 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
    if (p->type == LIGHT_RECTANGLE) rectangle_init(light, p);
    float edge = p->cos_inner - p->cos_outer;
    light->cone_scale = 1.0f / (edge > CONE_EDGE_MIN ? edge : CONE_EDGE_MIN);
    light->inverse_range = p->range > 0.0f ? 1.0f / p->range : 0.0f;
}

/* Returns the environment's part of the plan's powers. */
static float environment_part(const struct plan *plan, bool emitters)
{
    if (plan->environment.kind != ENVIRONMENT_MAP) return 0.0f;
    double others = emitters ? (double)plan->paths.emitter_power : 0.0;
    for (uint32_t i = 0; i < plan->light_count; i++) others += (double)plan->lights[i].power;
    if (!(others > 0.0)) return 1.0f;
    const double power = (double)plan->environment.power;
    return (float)(power / (power + others));
}

void light_table_init(struct light_table *t, const struct plan *plan,
                      const struct emitter_tree *emitters)
{
    t->count = plan->light_count;
    t->points = 0;
    for (uint32_t i = 0; i < t->count; i++) {
        light_init(&t->lights[i], &plan->lights[i]);
        t->points += light_is_point(&t->lights[i]) ? 1 : 0;
        t->lights[i].is_net = !pattern_lattice_init(
            &plan->pattern, pattern_light_dimension(i, plan->lights[i].strata_per_axis),
            &t->lights[i].lattice);
    }
    t->emitters = plan->paths.emitter_power > 0.0f ? emitters : NULL;
    t->environment_probability = environment_part(plan, t->emitters != NULL);
}

bool light_table_is_empty(const struct light_table *t)
{
    return t->count == 0 && !t->emitters && !(t->environment_probability > 0.0f);
}
