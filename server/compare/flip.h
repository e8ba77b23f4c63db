#pragma once
/* Computes how different two pictures look when they alternate at a place: LDR-FLIP after
 * Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and Fairchild 2020, "FLIP: A Difference
 * Evaluator for Alternating Images", sections 4.1 and 4.2; weighted quartiles after their section
 * 5.
 *
 * It is not FLIP itself, since the pictures are linear numbers as the viewer shows them
 * (display_transform.h), not files of bytes. Pixels that do not count are black in both and left
 * out of the figures. */
#include "server/compare/display_transform.h"

/* The paper's viewer: a screen 0.7 m wide with 3840 pixels, seen from 0.7 m. */
#define FLIP_PPD 67.0206432765

/* Within these bounds filters have a centre and fit (convolve.h). */
#define FLIP_PPD_MIN 4.0
#define FLIP_PPD_MAX 400.0

struct flip {
    double mean, max;
    double quartile[3]; /* below which a quarter, half, three quarters of the sum of errors lie */
};

/* Computes map[i], width * height, in [0, 1]: 0 where no difference is visible, and where a pixel
 * does not count. `ppd` is in pixels a degree of visual angle, within the two above. ERR_MEMORY. */
int flip_map(const struct display_pair *pair, double ppd, float *map, struct flip *out);
