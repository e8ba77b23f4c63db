#pragma once
/* Adds back what the layers miss of the plain average.
 *
 * The plain average is right but noisy; the layers' picture is smooth but may be biased. Their
 * difference, averaged over a few pixels, is the bias plus the remaining noise. It is added as far
 * as it exceeds that noise. More samples leave less noise, so more is added, over fewer pixels, and
 * the bias of the layers vanishes. Pixels nearly in focus whose samples agree, such as mirror
 * images of small lights, are judged alone. Errors of the samples' own light stay: light from
 * fields has the fields' resolution (lens_relight.h). */
#include "server/reconstruct/lens/lens_field.h"

/* Returns how many pixels around a block it reads the layers' picture of. */
int32_t lens_residual_reach_px(const struct plan *plan);

/* Writes the picture of `inner` from field->light, the means of `wide`. ERR_MEMORY. */
int lens_residual(const struct lens_field *field, struct rect inner, float *const out[3]);
