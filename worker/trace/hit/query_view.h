#pragma once
/* What rays meet in a view of a picture that is composed with a photograph (enum plan_view). Every
 * placed mesh is of one class, which Embree tests with each ray's mask, so that a ray that comes
 * near no virtual object takes the same way through the tree, and ends in the same bits, whether or
 * not it could meet some. */
#include <embree3/rtcore.h>

#include "proto/plan.h"
#include "worker/scene/render_scene.h"
#include "worker/shade/lanes.h"

struct query_view {
    uint32_t camera; /* classes (enum instance_class) that camera rays meet */
    uint32_t others; /* that all other rays meet */
    uint32_t shown;  /* that the camera sees; what else its rays meet hides what is behind it */
};

/* Returns the view, which is static. */
const struct query_view *query_view_of(enum plan_view view);

/* Sets all rays' masks. */
void query_view_mask(uint32_t mask, struct RTCRayHit16 *rays);

/* Turns hits of what the camera does not see into misses. */
void query_view_hide(const struct query_view *view, const struct render_scene *scene,
                     struct RTCRayHit16 *rays);
