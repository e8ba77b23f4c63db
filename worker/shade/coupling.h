#pragma once
/* How much light a layer of GGX facets leaves for the diffuse surface under it.
 *
 * glTF 2.0, appendix B, weighs the diffuse lobe by 1 - F(V.H) and notes ("Coupling Diffuse and
 * Specular Reflection") that this reflects more light than comes in; it names Kulla and Conty
 * (2017, "Revisiting Physically Based Shading at Imageworks") as the remedy, which is used here:
 * with M(w) the mean Fresnel reflectance of the facets that w sees and M the cosine-weighted mean
 * of M(w), the diffuse lobe is (1 - M(wo)) (1 - M(wi)) / (1 - M) / pi. It is reciprocal, and
 * nothing of what the facets let through is lost.
 *
 * Schlick's Fresnel makes M(w) = f0 + (1 - f0) W(w), W the mean of (1 - w.h)^5 over the facets that
 * w sees, weighted by what leaves them. W was integrated over visible facets (512 x 512 directions
 * per node); test_bsdf holds it against such an integral. Bilinear between nodes, W is off by 5e-4
 * in the mean and by 0.011 at worst, at grazing directions and alpha of about 0.01. */
#include <math.h>

#define COUPLING_NODES 16

/* W^(1/5) by row sqrt(alpha), column sqrt(cosine), both in equal steps from 0 to 1; a row after the
 * other. */
extern const float coupling_roots[COUPLING_NODES * COUPLING_NODES];
/* The cosine-weighted mean of W by row. */
extern const float coupling_averages[COUPLING_NODES];

/* Returns the node below t in [0, 1] and sets the fraction up to the next. */
static inline int coupling_node(float t, float *fraction)
{
    const float at = t * (COUPLING_NODES - 1);
    const int node = at < COUPLING_NODES - 2 ? (int)at : COUPLING_NODES - 2;
    *fraction = at - (float)node;
    return node;
}

/* Returns W of a direction at `cosine` to the normal for facets of roughness alpha, both in [0,
 * 1]. */
static inline float coupling_grazing(float cosine, float alpha)
{
    float f, g;
    const int column = coupling_node(sqrtf(cosine), &f);
    const int row = coupling_node(sqrtf(alpha), &g);
    const int at = row * COUPLING_NODES + column, next = at + COUPLING_NODES;
    const float a = coupling_roots[at], b = coupling_roots[next];
    const float low = a + (coupling_roots[at + 1] - a) * f;
    const float high = b + (coupling_roots[next + 1] - b) * f;
    const float root = low + (high - low) * g, square = root * root;
    return square * square * root;
}

static inline float coupling_average(float alpha)
{
    float g;
    const int row = coupling_node(sqrtf(alpha), &g);
    return coupling_averages[row] + (coupling_averages[row + 1] - coupling_averages[row]) * g;
}
