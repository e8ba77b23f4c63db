#pragma once
/* What falls on every pixel of a patch, apart from its albedo: the quantity that filters work on
 * and that the anti-aliased resolve spreads over sub-samples. */
#include "server/reconstruct/patch.h"

/* Beyond any lit scene, and far enough below FLT_MAX that sums over lights, samples and albedo stay
 * finite. */
#define LIGHTING_MAX 1e30f

/* Arrays of the patch's size: radiance that a white Lambert surface would send out. One allocation.
 */
struct lighting {
    float *direct[3];   /* sum over lights of E_k color_k / pi */
    float *indirect[3]; /* mean bounce radiance; zero without bounces */
    float *total[3];    /* their sum */
    void *memory;       /* owned */
};

/* The plain average: every light's and the bounce's Monte Carlo mean as they came. ERR_MEMORY. */
int lighting_create(const struct plan *plan, const struct patch *patch, struct lighting *out);
void lighting_fini(struct lighting *lighting);
