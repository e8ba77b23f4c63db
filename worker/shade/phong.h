#pragma once
/* Phong's lobe about the mirror direction, normalised and made reciprocal by Lafortune and Willems
 * (1994, "Using the modified Phong reflectance model for physically based rendering"): specular
 * (n + 2) / (2 pi) cos^n. Beside it albedo / pi; the two reflect at most albedo + specular. */
#include "worker/shade/bsdf.h"

/* Evaluates the lobes; wo.z, wi.z >= DIRECTION_GRAZING. */
void phong_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                    struct bsdf_value *out);
/* Samples wi with the density that phong_evaluate gives; it may lie below the horizon. */
void phong_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                  float wi[3]);
