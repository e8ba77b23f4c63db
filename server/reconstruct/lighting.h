#pragma once
/* What falls on every pixel of a patch, apart from its albedo: the quantity that filters work on
 * and that the anti-aliased resolve spreads over sub-samples. */
#include "server/reconstruct/shadow.h"

/* Beyond any lit scene, and far enough below FLT_MAX that sums over lights, samples and albedo stay
 * finite. */
#define LIGHTING_MAX 1e30f

/* Arrays of the patch's size: radiance that a white Lambert surface would send out; 0 outside the
 * pixels that were asked for. One allocation. */
struct lighting {
    float *direct[3];        /* sum over lights of E_k color_k / pi */
    float *indirect[3];      /* mean bounce radiance; zero without bounces */
    float *total[3];         /* their sum */
    float *width_px;         /* the shadow filter's, largest over the lights; 0: not filtered */
    struct scratch *scratch; /* the patch's */
    void *memory;            /* owned; from there */
};

/* Of the pixels of `lit`, which lies in patch->core: every light's and the bounce's Monte Carlo
 * mean as they came, and of rectangles under a shadow filter what that makes of their strata. Adds
 * to *shadow. ERR_MEMORY. */
int lighting_create(const struct plan *plan, const struct patch *patch, struct rect lit,
                    struct lighting *out, struct shadow_statistics *shadow);
void lighting_fini(struct lighting *lighting);
