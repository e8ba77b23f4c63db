#pragma once
/* What the layers miss of the plain average, given back.
 *
 * The plain average is right but noisy; the layers' picture is smooth but may be biased. Their
 * difference, averaged over a few pixels, is the bias and what is left of the noise; it is added as
 * far as it is larger than that noise can be. More samples leave less noise, so more is added, over
 * fewer pixels, and what the layers get wrong goes to nothing. Pixels nearly in focus whose samples
 * agree with each other are heard by themselves: mirror images of small lights. What is wrong with
 * the samples' own light stays: that of fields has their resolution (lens_light.h). */
#include "server/reconstruct/lens/lens_field.h"

/* Pixels around a block whose layers are looked at. */
int32_t lens_residual_reach_px(const struct plan *plan);

/* Writes the picture of `inner` from field->light, the means of `wide`. ERR_MEMORY. */
int lens_residual(const struct lens_field *field, struct rect inner, float *const out[3]);
