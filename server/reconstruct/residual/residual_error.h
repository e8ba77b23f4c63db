#pragma once
/* Estimates how far the residual filter's picture is off, by noise and bias.
 *
 *   e^2 = rho (f max(S N^2, S H^2) + rest) + bias^2
 *
 * N are probes after the last pass and H the halves' difference (residual_probe.h), S a mean over
 * the 5 x 5 pixels around, in which the pixel itself counts as its samples allow. f is 2 where
 * passes leave little of the noise; where they leave all of it, the result is the plain mean's
 * variance. `rest` is the part of that variance which halves of scattered light do not show:
 * emission's, which is not filtered; rho is a channel's share of it. bias^2 is how far boxes of the
 * plain and of the filtered picture lie apart, and what the last pass has changed, each beyond what
 * noise makes of it. docs/reconstruction.md, Errors. */
#include "server/reconstruct/residual/residual_probe.h"

/* How many pixels around a pixel its error depends on: half the largest box. */
#define RESIDUAL_ERROR_REACH_PX 6

/* Turns variances of the block's plain means, row by row, into those of the filtered picture, after
 * the last pass; pixels that are not filtered keep theirs. ERR_MEMORY. */
int residual_error_find(const struct residual_probes *probes, const struct patch *patch,
                        const struct residual_field *field, struct rect block,
                        float *const variance[3]);
