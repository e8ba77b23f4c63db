#pragma once
/* What moves while the shutter is open: where it is at a time in between (proto/shutter.h). */
#include "worker/scene/render_scene.h"

/* Steps of an instance; NULL: it stands. */
static inline const struct scene_step *mover_steps(const struct render_scene *s, uint32_t instance)
{
    return s->steps ? s->steps[instance] : NULL;
}

/* Finds the steps of each instance; NULL where nothing moves. ERR_MEMORY. */
int movers_find(const struct scene *blob, const struct scene_step ***out);

/* Returns whether an instance's vertices move; else it moves as a whole. */
static inline bool mover_bends(const struct scene_step *steps)
{
    return steps[0].first_vertex != steps[SHUTTER_STEPS - 1].first_vertex;
}

/* Computes an instance's transform at a time. */
void mover_to_world(const struct render_scene *s, uint32_t instance, float time, float out[12]);

/* Computes the corners of a triangle of an instance that bends, and the normals there if the mesh
 * has any. */
void mover_corners(const struct render_scene *s, uint32_t instance, uint32_t triangle, float time,
                   float corners[9], float normals[9]);
