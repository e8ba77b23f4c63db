#pragma once
/* The light around objects in a sequence of colour and depth, as its frames tell of it:
 *
 *   - What is twice as bright as white is a lamp, a rectangle where it is (light_lamps.h).
 *   - Where frames saw surfaces around the objects, these send their colours (light_sky.h).
 *   - What no frame saw, and how strong lamps are, is found by the shading of what frames saw
 *     (light_rows.h, light_solve.h).
 *
 * Lamps stand in the scene; the rest is a map from far around, which lights what the scene's own
 * surfaces leave open. */
#include "server/import/rgbd/light_lamps.h"
#include "server/import/rgbd/light_sky.h"
#include "server/import/scene/builder.h"
#include "server/import/scene/scene_choice.h"

struct rgbd_light {
    bool found;
    uint32_t lamp_count;
    struct light_lamp lamps[LIGHT_LAMPS]; /* their radiance is what was found */
    struct light_sky sky;
    double white[3]; /* mean of the frames' */
};

/* Estimates the light if it is chosen; `place` puts the sequence's world into the scene, whose
 * origin is where objects stand. Frames that are black tell nothing: found is false, with a
 * warning. Faults as light_views_read has them. */
int rgbd_light_find(const struct rgbd_document *d, struct files *files, const struct affine *place,
                    const struct scene_choice *choice, struct rgbd_light *out,
                    struct warnings *warnings, struct fault *fault);

/* Returns whether a scene that has its other lights already gets an estimate beside them. */
bool rgbd_light_is_wanted(const struct scene_choice *choice, const struct builder *b);

/* Adds the estimate to such a scene, if it is wanted. */
int rgbd_light_add(const struct rgbd_light *light, const struct scene_choice *choice,
                   struct builder *b, struct fault *fault);
