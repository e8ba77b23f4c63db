#pragma once
/* What colours are to the network: scaled by an exposure, then nearly as the eye sees them (the PU
 * curve of Aydin and others 2008, Extending Quality Metrics to Full Luminance Range Images, as Open
 * Image Denoise fits it), with 1 for the largest half float. */
#include "server/image/image.h"

float tone_forward(float linear);
float tone_inverse(float tone);

/* Returns what brings the logarithmic mean luminance of a picture, of cells of 16 by 16 pixels, to
 * 0.18; 1 for a black picture. */
float tone_exposure(const struct plane *const rgb[3]);
