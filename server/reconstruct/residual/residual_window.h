#pragma once
/* Samples of a few frames before and after one, which its residual filter uses as if they were its
 * own: half a of another frame's pixel joins half a, half b joins half b, so that halves know
 * nothing of each other. They are found by where things move, and refused where instance, normal,
 * place or what surrounds edges differ. Shadows and highlights do not move as surfaces do: light
 * whose means over small neighbourhoods differ by more than their noise is another light.
 * docs/reconstruction.md, Frames of a window, has the formulas. */
#include "server/reconstruct/residual/residual_history.h"

/* How many pixels around a pixel what joins it depends on: boxes, and slopes of depth. */
#define RESIDUAL_WINDOW_REACH_PX 6

/* What a frame has of others: those beside it, the nearest first. All is borrowed. */
struct residual_window {
    const struct plan *plan;     /* of the frame itself */
    const struct motion *motion; /* NULL: nothing moves but the camera */
    uint32_t view;               /* enum plan_view, of all frames */
    uint32_t count[MOTION_SIDES];
    const struct residual_history *frames[MOTION_SIDES][LIMIT_TEMPORAL_FRAMES];
};

/* Joins the features of other frames to the patch's own where nothing moves, so that edges have the
 * samples of all frames: to features that are not smoothed yet. ERR_MEMORY. */
int residual_window_join_features(const struct patch *patch, struct residual_field *field);

/* Joins the samples of the patch's window to the halves of the field's light, after features, and
 * sets what the field has of joined samples. ERR_MEMORY. */
int residual_window_join(const struct patch *patch, struct residual_field *field);
