#pragma once
/* Smooths features that are noisy themselves. Behind alpha and in leaves, samples of a pixel meet
 * one surface or another by chance, so means of few samples differ between pixels as much as the
 * light does. No neighbour then looks alike, and albedo puts its noise back into the picture.
 *
 * Depth identifies such pixels: along an edge it is smooth in one direction at least, in noise in
 * none. Their features are replaced by means over the noisy pixels around. The part of albedo and
 * tint that this removes goes into the rest, so that no light is lost. docs/reconstruction.md,
 * Residual filter. */
#include "server/reconstruct/patch/scratch.h"
#include "server/reconstruct/residual/residual_field.h"

/* How many pixels around a pixel its features depend on. */
#define RESIDUAL_SMOOTH_REACH_PX 5

/* Smooths features of the patch's pixels, before light is divided by any. ERR_MEMORY. */
int residual_smooth(struct residual_features *f, struct scratch *scratch);
