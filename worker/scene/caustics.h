#pragma once
/* Learns where lenses and mirrors of a scene gather light, and from where it comes. Paths from
 * there then go the same way (path_guide.h). What is learned changes noise, never the mean.
 *
 * Photons leave the lamps of the scene, or the bright parts of a sky, towards its lenses and
 * mirrors (photon_targets.h), follow them (photon_flight.h), and are kept where they meet other
 * surfaces (photons.h). */
#include "worker/scene/environment.h"
#include "worker/scene/photons.h"

struct render_scene;

/* Map the photons of the lamps of a scene, whose targets are known, or of a sky: `cosine` and
 * `sine` turn directions of the world to the map's. *out is NULL where there are none. ERR_MEMORY.
 */
int caustics_of_lamps(const struct render_scene *scene, struct photons **out);
int caustics_of_sky(const struct render_scene *scene, const struct environment *map, float cosine,
                    float sine, struct photons **out);
