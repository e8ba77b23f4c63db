#pragma once
/* Estimates how far filtered shadows are off, from halves of the samples.
 *
 * A half is the picture of every other pixel alone: the others take the samples of a neighbour of
 * the same surface, so that each of those counts twice. Filtered, it is off the whole by as much as
 * the whole is off the truth. Several ways to halve the pixels tell more than one. */
#include "server/reconstruct/patch/patch.h"

/* Adds to variance[] the squared standard error of what shadow_filter has made of light k over
 * `inner` with these arguments, `irradiance`. Arrays are of the patch's size. ERR_MEMORY. */
int shadow_error_add(const struct plan *plan, uint32_t light, const struct patch *patch,
                     struct rect inner, const float *irradiance, float *variance);
