#pragma once
/* Blinn-Phong: specular C cos^n of the half vector to the normal, C = (n + 2) (n + 4) /
 * (8 pi (n + 2^(-n/2))), so that at most `specular` is reflected, and all of it at normal incidence
 * (Giesen 2009, "Phong normalization factor derivations"). Beside it albedo / pi. */
#include "worker/shade/bsdf.h"

/* Evaluates the lobes; wo.z, wi.z >= DIRECTION_GRAZING. */
void blinn_phong_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                          struct bsdf_value *out);
/* Samples wi with the density that blinn_phong_evaluate gives; it may lie below the horizon. */
void blinn_phong_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                        float wi[3]);
