#pragma once
/* The part of the lens in which the same sample of all pixels lies, whatever their jitters. */
#include "proto/lens_pattern.h"

struct lens_span {
    float low[2], high[2]; /* of u[0], to the right, and u[1], down */
};

/* Computes spans[row * l + column] of l x l samples. Points lie outside by at most 0.003 of the
 * radius. */
void lens_spans(const struct lens_aperture *aperture, uint32_t l, struct lens_span *spans);
