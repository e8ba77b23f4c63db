#pragma once
/* Features that are noise themselves: where samples of a pixel meet one surface or another by
 * chance, as behind alpha and in leaves, means of few samples differ from pixel to pixel as much as
 * the light does. No neighbour then looks alike, and albedo puts its noise back into the picture.
 *
 * Depth tells such pixels: along an edge it is smooth in one direction at least, in noise in none.
 * Their features become means over the pixels around that are noisy as well. What albedo and tint
 * then no longer say is in the rest, so that nothing is lost. docs/reconstruction.md, Residual
 * filter. */
#include "server/reconstruct/patch/scratch.h"
#include "server/reconstruct/residual/residual_field.h"

/* Pixels around one that its features come of. */
#define RESIDUAL_SMOOTH_REACH_PX 5

/* Smooths features of the patch's pixels, before light is divided by any. ERR_MEMORY. */
int residual_smooth(struct residual_features *f, struct scratch *scratch);
