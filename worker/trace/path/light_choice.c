#include "worker/trace/path/light_choice.h"

#include "worker/trace/path/path_kernels.h"

/* The largest number below 1. */
#define BELOW_ONE 0x1.fffffffffffffp-1

/* Lets the plan's lights count by the surfaces' shares, and the environment for as much more. */
static void weigh_listed(const struct light_table *t, struct path_vertex *v)
{
    struct light_weights *w = &v->weights;
    const uint32_t groups = t->emitters ? t->emitters->root_groups : 0;
    for (int i = 0; i < LANES; i++) {
        const float sky = v->sky_share[i], before = w->total[i];
        float total = 0.0f;
        for (uint32_t k = 0; k < t->count; k++) total += w->of[k][i] *= v->listed[i];
        for (uint32_t g = 0; g < groups; g++) total += w->of[LIGHT_CHOICE_EMITTERS + g][i];
        w->total[i] = total;
        const float rest = before > 0.0f ? (1.0f - sky) * (total / before) : 0.0f;
        v->sky_share[i] = sky > 0.0f ? sky / (sky + rest) : 0.0f;
    }
}

void light_choice_weigh(const struct path_context *c, struct path_vertex *v)
{
    const struct surface *s = &v->surface;
    const float sky = c->lights->environment_probability;
    const bool points = !light_table_takes_points(c->lights, v->depth);
    c->kernels->weigh_lights(c->lights, points, &s->origin, &s->normal, &v->weights);
    for (int i = 0; i < LANES; i++)
        v->sky_share[i] = sky > 0.0f && !(v->weights.total[i] > 0.0f) ? 1.0f : sky;
    if ((c->skip & SKIP_LISTED) && v->depth == 0) weigh_listed(c->lights, v);
}

/* Chooses one of a node's groups by *x, which becomes its place within that. Returns its chance. */
static float choose_group(const struct emitter_groups *node, const float *weight, float total,
                          uint32_t *group, double *x)
{
    const double target = *x * (double)total;
    float upto = 0.0f, before = 0.0f, of = 0.0f;
    for (uint32_t g = 0; g < node->count; g++) {
        const bool takes = weight[g] > 0.0f;
        before = takes ? upto : before;
        of = takes ? weight[g] : of;
        *group = takes ? g : *group;
        upto += weight[g];
        if (target < (double)upto) break;
    }
    if (!(of > 0.0f)) return 0.0f;
    const double within = (target - (double)before) / (double)of;
    *x = within > 0.0 ? (within < BELOW_ONE ? within : BELOW_ONE) : 0.0;
    return of / total;
}

struct light_leaf light_choice_descend(const struct path_context *c, const struct lanes3 *origin,
                                       const struct lanes3 *normal, int i, uint32_t group, double x)
{
    const struct emitter_tree *t = c->lights->emitters;
    uint32_t at = t->nodes[group / EMITTER_GROUPS].groups.below[group % EMITTER_GROUPS];
    float chance = 1.0f;
    while (!(at & EMITTER_LEAF)) {
        const struct emitter_groups *node = &t->nodes[at].groups;
        _Alignas(LANES_ALIGN) float weight[EMITTER_GROUPS];
        const float total = c->kernels->weigh_node(node, origin, normal, i, weight);
        const float one = choose_group(node, weight, total, &group, &x);
        if (!(one > 0.0f)) return (struct light_leaf){0, 0.0f};
        chance *= one;
        at = node->below[group];
    }
    return (struct light_leaf){at & ~EMITTER_LEAF, chance};
}

float light_choice_chance(const struct path_context *c, const struct lanes3 *origin,
                          const struct lanes3 *normal, int i, uint32_t leaf, float *weight)
{
    const struct emitter_tree *t = c->lights->emitters;
    struct emitter_place place = t->leaves[leaf].place;
    float chance = 1.0f;
    for (;; place = t->nodes[place.node].place) {
        _Alignas(LANES_ALIGN) float weights[EMITTER_GROUPS];
        const float total =
            c->kernels->weigh_node(&t->nodes[place.node].groups, origin, normal, i, weights);
        *weight = weights[place.group];
        if (place.node < t->root_nodes) return chance;
        chance *= total > 0.0f ? *weight / total : 0.0f;
    }
}
