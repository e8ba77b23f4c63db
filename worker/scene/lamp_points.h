#pragma once
/* Samples points on the lamps of a scene, for what is learned of it by chance: groups of emitters
 * and recognised rectangles. */
#include "worker/scene/emitters.h"
#include "worker/scene/render_scene.h"

/* A group of emitters, or a rectangle that stands for some. */
struct lamp_source {
    const struct emitters *emitters;
    uint32_t below;                      /* of the group */
    const struct scene_light *rectangle; /* NULL: none */
};

/* Samples a point of a source, in proportion to what it emits. */
void lamp_sample(const struct lamp_source *source, uint32_t *random, struct emitter_point *out);

/* Sets what bounds a rectangle. */
void lamp_bound(const struct scene_light *rectangle, struct emitter_groups *out);
