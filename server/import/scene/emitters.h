#pragma once
/* Finds emissive rectangles and makes them lights.
 *
 * A mesh whose material emits evenly, and whose triangles pair into at most EMITTER_RECTANGLES
 * rectangles, becomes that many rectangle lights for each of its instances, twice as many when the
 * material is double-sided; it is flagged MESH_IS_LIGHT. Emission leaves on the front side: the
 * one from which the corners run counter-clockwise. Other emissive meshes stay as they are, with a
 * warning that only paths sample their light (worker/scene/emitters.h). */
#include "server/import/scene/builder.h"

#define EMITTER_RECTANGLES 8

struct rectangle {
    double centre[3], half_u[3], half_v[3]; /* half_u x half_v points to the front */
};

/* Pairs triangles (indexes into positions) into rectangles: right angles and equal opposite sides
 * to a tolerance of 1e-3. Returns how many, or 0 when a triangle is left over, when there are more
 * than EMITTER_RECTANGLES, or when one is degenerate. */
uint32_t emitters_pair(const float *positions, const uint32_t *triangles, uint32_t triangle_count,
                       struct rectangle out[EMITTER_RECTANGLES]);

/* Finds the emitters of all meshes and instances. It is the last step before the builder is
 * finished. */
int emitters_find(struct builder *b, struct fault *fault);
