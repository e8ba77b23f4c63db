#pragma once
/* The photograph that a picture is composed with, as rays of virtual objects see it: where the
 * camera would show a point, and what the photograph shows there. */
#include <stdbool.h>

#include "proto/plan.h"
#include "proto/scene/environment.h"

struct photograph {
    const struct plan *plan; /* borrowed, as is the blob */
    const struct environment_blob *texels;
    float across, down; /* texels a pixel */
};

void photograph_init(struct photograph *p, const struct plan *plan,
                     const struct environment_blob *blob);

/* Finds where the camera's ray that meets a point comes from: `to` is unit, `distance` away.
 * Returns false for a point that is not before the camera, or outside the picture; *px and *py, in
 * pixels, tell the rest. */
bool photograph_find(const struct photograph *p, const float point[3], float to[3], float *distance,
                     float *px, float *py);

/* Reads the light at a place of the picture, interpolated between texels. */
void photograph_read(const struct photograph *p, float px, float py, float out[3]);
