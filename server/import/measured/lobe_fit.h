#pragma once
/* Fits the lobes of a measured material to its measurement: those of worker/shade/measured.h.
 *
 * For every pair of alphas from 0.003 to 1 the colours of a diffuse and two GGX lobes are the best
 * ones by least squares, none of them negative. Differences weigh as those of cube roots, which
 * dark parts of a reflectance need (Bieron and Peers 2020, "An adaptive BRDF fitting metric"). The
 * pair of the least error is taken, and searched around twice. Numbers are rounded to 1e-4, so that
 * machines agree. */
#include "proto/scene/scene.h"
#include "server/import/measured/merl.h"

struct lobe_fit {
    float diffuse[3];     /* albedo */
    float specular[2][3]; /* what facets reflect at normal incidence */
    float grazing[2];     /* ... and at grazing angles */
    float alpha[2];       /* that of the higher peak first */
    double off;           /* share of the measured light that the fit puts elsewhere */
};

/* Fits. Nothing of the fit reflects more than it receives. ERR_MEMORY. */
int lobe_fit_make(const struct merl *m, struct lobe_fit *out);
