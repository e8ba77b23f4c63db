#pragma once
/* The inner loops of path_kernels that weigh all that a light sample may choose, and choose. */
#include "worker/trace/path/emitter_lanes.h"

/* Directional lights, which are often out of sight, weigh at most this many times as much as all
 * others. */
#define SUNS_MAX 15.0f

/* The bound does not hold where the others weigh less than this part of them. */
#define SUNS_FAINTEST 1e-20f

/* Weighs points and spots by the irradiance itself. A point's cone lets everything through. */
static void weigh_point(const struct light *light, const struct lanes3 *restrict origin,
                        const struct lanes3 *restrict normal, float *restrict weight)
{
    const struct plan_light *p = light->plan;
    const float at_x = p->position[0], at_y = p->position[1], at_z = p->position[2];
    const float along_x = p->direction[0], along_y = p->direction[1], along_z = p->direction[2];
    const float power = light->power, inverse_range = light->inverse_range;
    const float cos_outer = p->cos_outer, scale = light->cone_scale;
    const int has_cone = p->type == LIGHT_SPOT;
    for (int i = 0; i < LANES; i++) {
        const float x = at_x - origin->x[i], y = at_y - origin->y[i], z = at_z - origin->z[i];
        const float squared = x * x + y * y + z * z;
        const float over = 1.0f / sqrtf(squared > 0.0f ? squared : 1.0f);
        const float facing = (x * normal->x[i] + y * normal->y[i] + z * normal->z[i]) * over;
        const float cosine = -(x * along_x + y * along_y + z * along_z) * over;
        const float inside = positive((cosine - cos_outer) * scale);
        const float cone = has_cone & (inside < 1.0f) ? inside : 1.0f;
        const float ratio2 = squared * inverse_range * inverse_range;
        const float window = positive(1.0f - ratio2 * ratio2);
        weight[i] =
            at_max(power * cone * cone * window * positive(facing) * over * over, LIGHT_WEIGHT_MAX);
    }
}

/* Weighs a rectangle, a flat emitter: nothing arrives behind it. */
static void kernel_weigh_rectangle(const struct light *light, const struct lanes3 *restrict origin,
                                   const struct lanes3 *restrict normal, float *restrict weight)
{
    const struct plan_light *p = light->plan;
    const float at_x = p->position[0], at_y = p->position[1], at_z = p->position[2];
    const float axis_x = p->direction[0], axis_y = p->direction[1], axis_z = p->direction[2];
    const float power = light->power, radius = light->radius;
    for (int i = 0; i < LANES; i++) {
        const struct emitting from = {at_x - origin->x[i],
                                      at_y - origin->y[i],
                                      at_z - origin->z[i],
                                      radius,
                                      axis_x,
                                      axis_y,
                                      axis_z,
                                      1.0f,
                                      0.0f,
                                      power};
        const float height = from.x * axis_x + from.y * axis_y + from.z * axis_z;
        const float whole = bound_irradiance(from, normal->x[i], normal->y[i], normal->z[i]);
        weight[i] = height < 0.0f ? whole : 0.0f;
    }
}

static void weigh_sun(const struct light *light, const struct lanes3 *restrict normal,
                      float *restrict weight)
{
    const float x = light->plan->direction[0], y = light->plan->direction[1];
    const float z = light->plan->direction[2], power = light->power;
    for (int i = 0; i < LANES; i++)
        weight[i] = power * positive(-(x * normal->x[i] + y * normal->y[i] + z * normal->z[i]));
}

/* Bounds directional lights by what the others weigh. */
static void bound_suns(const struct light_table *t, const float *restrict suns,
                       struct light_weights *restrict out)
{
    _Alignas(LANES_ALIGN) float scale[LANES];
    for (int i = 0; i < LANES; i++) {
        const float most = SUNS_MAX * out->total[i];
        const bool bound = (suns[i] > most) & (out->total[i] > SUNS_FAINTEST * suns[i]);
        scale[i] = bound ? most / suns[i] : 1.0f;
        out->total[i] += suns[i] * scale[i];
    }
    for (uint32_t k = 0; k < t->count; k++) {
        if (t->lights[k].plan->type != LIGHT_DIRECTIONAL) continue;
        for (int i = 0; i < LANES; i++) out->of[k][i] *= scale[i];
    }
}

static void kernel_weigh_lights(const struct light_table *t, bool points,
                                const struct lanes3 *restrict origin,
                                const struct lanes3 *restrict normal,
                                struct light_weights *restrict out)
{
    _Alignas(LANES_ALIGN) float suns[LANES] = {0};
    bool any_sun = false;
    memset(out->total, 0, sizeof out->total);
    for (uint32_t k = 0; k < t->count; k++) {
        const struct light *light = &t->lights[k];
        const bool sun = light->plan->type == LIGHT_DIRECTIONAL;
        float *restrict weight = out->of[k], *restrict sum = sun ? suns : out->total;
        any_sun |= sun;
        if (light_is_point(light) && !points)
            memset(weight, 0, LANES * sizeof *weight);
        else if (sun)
            weigh_sun(light, normal, weight);
        else if (light->plan->type == LIGHT_RECTANGLE)
            kernel_weigh_rectangle(light, origin, normal, weight);
        else
            weigh_point(light, origin, normal, weight);
        for (int i = 0; i < LANES; i++) sum[i] += weight[i];
    }
    for (uint32_t n = 0; t->emitters && n < t->emitters->root_nodes; n++)
        weigh_groups(&t->emitters->nodes[n].groups, origin, normal,
                     &out->of[LIGHT_CHOICE_EMITTERS + n * EMITTER_GROUPS], out->total);
    if (any_sun) bound_suns(t, suns, out);
}

/* Passes one of the choices. Until a lane has found where its number falls, it keeps the last
 * choice that weighs something. */
LANE_INLINE void pass_choice(uint32_t number, const float *restrict weight,
                             const float *restrict target, struct lanes_mask *restrict found,
                             float *restrict upto, struct light_choice *restrict out)
{
    for (int i = 0; i < LANES; i++) {
        const float one = weight[i], next = upto[i] + one;
        const int32_t takes = ~found->on[i] & -(one > 0.0f);
        out->chosen[i] = takes ? number : out->chosen[i];
        out->weight[i] = takes ? one : out->weight[i];
        out->before[i] = takes ? upto[i] : out->before[i];
        found->on[i] |= takes & -(target[i] < next);
        upto[i] = next;
    }
}

static void kernel_choose_light(const struct light_table *t, const struct light_weights *restrict w,
                                const float *restrict x, struct light_choice *restrict out)
{
    _Alignas(LANES_ALIGN) float target[LANES], upto[LANES] = {0};
    struct lanes_mask found = {{0}};
    for (int i = 0; i < LANES; i++) {
        target[i] = x[i] * w->total[i];
        out->chosen[i] = UINT32_MAX;
        out->weight[i] = out->before[i] = 0.0f;
    }
    for (uint32_t k = 0; k < t->count; k++) pass_choice(k, w->of[k], target, &found, upto, out);
    for (uint32_t g = 0; t->emitters && g < t->emitters->root_groups; g++)
        pass_choice(LIGHT_CHOICE_EMITTERS + g, w->of[LIGHT_CHOICE_EMITTERS + g], target, &found,
                    upto, out);
}
