#pragma once
/* What falls on every pixel of a patch, apart from its albedo: the quantity that filters work on
 * and that the anti-aliased resolve spreads over sub-samples. */
#include "server/reconstruct/glossy/glossy.h"
#include "server/reconstruct/indirect/indirect.h"
#include "server/reconstruct/shadow/shadow.h"

/* Beyond any lit scene, and far enough below FLT_MAX that sums over lights, samples and albedo stay
 * finite. */
#define LIGHTING_MAX 1e30f

/* Arrays of the patch's size: radiance that a white Lambert surface would send out; 0 outside the
 * pixels that were asked for. One allocation. */
struct lighting {
    float *direct[3];        /* sum over lights of E_k color_k / pi */
    float *indirect[3];      /* mean bounce radiance; zero without bounces */
    float *total[3];         /* their sum */
    float *glossy[3];        /* radiance that the glossy lobe sees; where there is none, `indirect`,
                                for sub-samples that have one; NULL without planes of lobes */
    float *open;             /* share of the hemisphere that is open; zero where it is not traced */
    float *width_px;         /* of all filters the largest; 0: not filtered */
    float *error[3];         /* standard error of `indirect`; NULL without halves to tell of it */
    float *glossy_error[3];  /* the same of `glossy` */
    struct scratch *scratch; /* the patch's */
    void *memory;            /* owned; from there */
};

struct lighting_statistics {
    struct shadow_statistics shadow; /* over the lights */
    struct indirect_statistics indirect;
    struct glossy_statistics glossy;
    uint64_t shadow_cpu_us, indirect_cpu_us, glossy_cpu_us; /* CPU time of filters */
};

/* Of the pixels of `lit`, which lies in patch->core: every light's and the bounce's Monte Carlo
 * mean as they came; of rectangles under a shadow filter what that makes of their strata; of
 * bounces under a filter of indirect light what that makes of their means, and so of glossy lobes.
 * Adds to *statistics. ERR_MEMORY. */
int lighting_create(const struct plan *plan, const struct patch *patch, struct rect lit,
                    struct lighting *out, struct lighting_statistics *statistics);
void lighting_fini(struct lighting *lighting);
