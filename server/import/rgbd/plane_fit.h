#pragma once
/* A plane through what pixels show: 1/z = p0 + p1 u + p2 v by least squares, where u and v are
 * pixels from any centre. */
#include <stdbool.h>

struct plane_fit {
    double a[3][3], b[3], weight;
};

/* Adds a pixel's depth. Where there is a plane so far, pixels count less that are off it. */
void plane_fit_add(struct plane_fit *f, double u, double v, double z, const double *plane);

/* Returns false where the pixels are too few, or all in a line. */
bool plane_fit_solve(const struct plane_fit *f, double plane[3]);
