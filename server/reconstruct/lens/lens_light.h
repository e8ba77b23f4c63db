#pragma once
/* Takes the noise out of the light of lens samples, where these are the paths of the residual
 * filter, before the lens's filter mixes them.
 *
 * The residual filter knows means of pixels, and the lens's filter wants samples. What it makes of
 * a pixel goes to the samples that meet a surface: those of one surface take their mean, and all
 * the difference that is left (docs/reconstruction.md, Light of lens samples). Samples far out of
 * focus keep their own light, since many pixels share each. */
#include "server/reconstruct/patch/patch.h"
#include "server/reconstruct/residual/residual.h"

/* Returns how many pixels around a block have samples whose light is filtered; 0 where none is. */
int32_t lens_light_reach_px(const struct plan *plan);

/* Filters the light in patch->lens_radiance of samples that a block's pixels may see. The patch
 * reaches as far as lens_light_reach_px and residual_halo_px together, or ends with the image.
 * ERR_MEMORY. */
int lens_light_filter(const struct plan *plan, struct patch *patch, struct rect block,
                      struct residual_statistics *statistics);
