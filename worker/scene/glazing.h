#pragma once
/* Finds the lamps of a scene that shine through glass or shades, where no shadow ray reaches them.
 * Rays from the lamps learn it, once per scene, and paths then go there on purpose (path_guide.h).
 * What is learned changes noise, never the mean.
 *
 * Places are the world's. */
#include <stdbool.h>

#include "worker/scene/emitter_groups.h"

struct RTCRay;
struct render_scene;

struct glazing {
    struct emitter_groups lamps; /* the spheres that paths are sent to; `power` counts the share of
                                    a lamp that shines through glass. `below` is not set */
};

/* Learns from a scene that is built. */
void glazing_learn(const struct render_scene *scene, struct glazing *out);

/* Returns whether a ray reaches its end, if need be through clear glass, and sets *through where it
 * does so. Frosted glass and shades stop it. */
bool glazing_sees(const struct render_scene *scene, struct RTCRay *ray, bool *through);
