#pragma once
/* Where on the lens the same sample of all pixels lies, whatever their jitters. */
#include "proto/lens_pattern.h"

struct lens_span {
    float low[2], high[2]; /* of u[0], to the right, and u[1], down */
};

/* Of l x l samples: spans[row * l + column]. Points lie beyond by 0.003 at most, of a
 * radius of 1. */
void lens_spans(const struct lens_aperture *aperture, uint32_t l, struct lens_span *spans);
