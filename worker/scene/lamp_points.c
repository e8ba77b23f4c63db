#include "worker/scene/lamp_points.h"

#include <math.h>

#include "proto/pattern_path.h"
#include "worker/shade/direction.h"

/* Rays start this part of a rectangle's sides in front of it, and so of what it stands for. */
#define CLEARANCE 1e-3f

/* Walks down from a group by the power of what is below. Returns a leaf. */
static uint32_t descend(const struct emitter_tree *t, uint32_t at, uint32_t *random)
{
    while (!(at & EMITTER_LEAF)) {
        const struct emitter_groups *g = &t->nodes[at].groups;
        float sum = 0.0f, upto = 0.0f;
        uint32_t taken = 0;
        for (uint32_t k = 0; k < g->count; k++) sum += g->power[k];
        const float target = path_next(random) * sum;
        for (uint32_t k = 0; k < g->count && upto <= target; k++) {
            upto += g->power[k];
            taken = k;
        }
        at = g->below[taken];
    }
    return at & ~EMITTER_LEAF;
}

static void sample_rectangle(const struct scene_light *l, const float u[2],
                             struct emitter_point *out)
{
    float sides = 0.0f;
    for (int k = 0; k < 3; k++) {
        out->position[k] = l->position[k] + (2.0f * u[0] - 1.0f) * l->half_u[k] +
                           (2.0f * u[1] - 1.0f) * l->half_v[k];
        out->normal[k] = l->direction[k];
        sides += fabsf(l->half_u[k]) + fabsf(l->half_v[k]);
    }
    out->double_sided = false;
    out->offset = CLEARANCE * sides;
}

void lamp_sample(const struct lamp_source *s, uint32_t *random, struct emitter_point *out)
{
    const float u[2] = {path_next(random), path_next(random)};
    const float choice = path_next(random);
    if (s->rectangle) {
        sample_rectangle(s->rectangle, u, out);
        return;
    }
    const uint32_t leaf = descend(emitters_tree(s->emitters), s->below, random);
    emitters_sample(s->emitters, leaf, emitters_choose(s->emitters, leaf, choice, u), u, out);
}

void lamp_bound(const struct scene_light *l, struct emitter_groups *out)
{
    const float *u = l->half_u, *v = l->half_v, *c = l->color;
    const float u2 = direction_dot(u, u), v2 = direction_dot(v, v);
    const float area = 4.0f * sqrtf(u2 * v2); /* its sides are perpendicular */
    out->power[0] = area * (0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2]);
    out->x[0] = l->position[0];
    out->y[0] = l->position[1];
    out->z[0] = l->position[2];
    out->radius[0] = sqrtf(u2 + v2);
    out->axis_x[0] = l->direction[0];
    out->axis_y[0] = l->direction[1];
    out->axis_z[0] = l->direction[2];
    out->cosine[0] = 1.0f;
    out->sine[0] = 0.0f;
}
