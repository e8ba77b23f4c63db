#pragma once
/* Back faces that the camera does not see.
 *
 * glTF draws triangles of a material without `doubleSided` from their front alone. Here camera rays
 * pass their backs; all other rays meet both sides, so that light neither enters rooms through
 * walls that are seen from inside nor leaves them, whatever the camera sees. Mirrors, shadows and
 * indirect light show such surfaces as if they had two sides.
 *
 * Surfaces that let light through, as glass, leaves and blended alpha do, are met from both sides
 * by all rays: what lies behind them is seen in the light that they leave over. */
#include <embree3/rtcore.h>

#include "worker/scene/render_scene.h"
#include "worker/shade/lanes.h"

/* Fills the lanes of *valid whose hit is on such a back. Returns whether there are any. */
bool back_faces_find(const struct render_scene *scene, const struct lanes_mask *valid,
                     const struct RTCRayHit16 *rays, struct lanes_mask *out);

/* Drops hits on such backs, as a context's filter does. Every geometry's user data is its struct
 * mesh_view. */
void back_faces_filter(const struct RTCFilterFunctionNArguments *args);
