#pragma once
/* Draws in what stands out of all eight pixels around it, as far as it may be noise. At silhouettes
 * few pixels are alike, so that their own few samples are all that filters have: they are left as
 * dots (docs/reconstruction.md, Lone pixels). */
#include "server/reconstruct/residual/residual_field.h"

/* How many pixels around it reads. */
#define RESIDUAL_LONE_REACH_PX 1

/* Draws the light of a field in that has been through all passes in `area` (of the patch's own
 * coordinates) and RESIDUAL_LONE_REACH_PX around, as far as there is a picture. */
void residual_lone_draw_in(struct residual_field *field, struct rect area);
