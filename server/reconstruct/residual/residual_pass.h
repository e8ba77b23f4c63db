#pragma once
/* One pass of the residual filter over a part of the field. */
#include "server/reconstruct/residual/residual.h"
#include "server/reconstruct/residual/residual_kernels.h"

/* The passes, which are numbered in their order. */
#define RESIDUAL_PASSES 3

/* Returns how many pixels around a pixel a pass reads. */
int32_t residual_reach_px(int number);

/* Filters the pixels of `area` (of the patch's own coordinates, inside the patch); half[] of all
 * components then holds the result, also beyond the picture's border. Needs pixels around as far as
 * the pass reaches, as far as there is a picture. ERR_MEMORY. */
int residual_pass_run(int number, struct rect area, struct residual_field *field,
                      struct residual_statistics *statistics);
