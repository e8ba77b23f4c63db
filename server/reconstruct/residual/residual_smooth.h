#pragma once
/* Smooths features that are noisy themselves. Behind alpha and in leaves, samples of a pixel meet
 * one surface or another by chance, so means of few samples differ between pixels as much as the
 * light does. No neighbour then looks alike, and albedo puts its noise back into the picture.
 *
 * Depth identifies such pixels: along an edge it is smooth in one direction at least, in noise in
 * none. Their features are replaced by means over the noisy pixels around. The part of albedo and
 * tint that this removes goes into the rest, so that no light is lost. docs/reconstruction.md,
 * Residual filter. */
#include "server/reconstruct/residual/residual_field.h"

/* How many pixels around a pixel its features depend on. */
#define RESIDUAL_SMOOTH_REACH_PX 5

/* Planes that it needs to work in. */
#define RESIDUAL_SMOOTH_PLANES 20

/* Smooths features of the patch's pixels, before light is divided by any. `work` has
 * RESIDUAL_SMOOTH_PLANES planes, which may hold anything. */
void residual_smooth(struct residual_features *f, float *work);
