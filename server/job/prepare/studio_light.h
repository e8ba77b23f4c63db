#pragma once
/* The light of a scene that nothing lights: a grey room with three soft boxes, as an environment
 * map. It suits the camera that such scenes mostly get (proto/scene/camera_fit.h): a large key
 * light to its left, a weaker one to its right, and a strip behind that parts the object from its
 * background. A white surface sends on between a fifth, facing down, and one. */
#include "proto/scene/environment.h"
#include "server/store/objects.h"

#define STUDIO_WIDTH_PX  256u
#define STUDIO_HEIGHT_PX 128u

/* Fills STUDIO_WIDTH_PX x STUDIO_HEIGHT_PX texels of three floats, rows from the top. */
void studio_light_draw(float *texels);

/* Writes the map's blob into the store, unless it is there. ERR_MEMORY, ERR_IO, ... */
int studio_light_place(const struct objects *objects, struct environment_header *header,
                       struct digest *blob, struct fault *fault);
