#pragma once
/* Learns where lenses and mirrors of a scene gather light, and from where it comes. Paths from
 * there then go the same way (path_guide.h). What is learned changes noise, never the mean.
 *
 * Photons leave the lamps and the bright parts of the sky towards what is clear and smooth or a
 * mirror, follow it, and are kept where they meet other surfaces (photons.h). */
#include "worker/scene/environment.h"
#include "worker/scene/photons.h"

struct render_scene;

/* Returns the map of the photons of a scene's lamps, or with `sky` of its bright parts: `cosine`
 * and `sine` turn directions of the world to the map's. NULL: there are none, or no memory. */
struct photons *caustics_of_lamps(const struct render_scene *scene);
struct photons *caustics_of_sky(const struct render_scene *scene, const struct environment *sky,
                                float cosine, float sine);
