#pragma once
/* The light that falls on every pixel of a patch, before albedo. Filters work on it, and the
 * anti-aliased resolve spreads it over sub-samples. */
#include "server/reconstruct/glossy/glossy.h"
#include "server/reconstruct/indirect/indirect.h"
#include "server/reconstruct/shadow/shadow.h"

/* Beyond any lit scene, and far enough below FLT_MAX that sums over lights, samples and albedo stay
 * finite. */
#define LIGHTING_MAX 1e30f

/* Returns a number up to that, also for one that has overflowed, or is a difference of two that
 * have: no comparison holds for NaN. */
static inline float lighting_bounded(float v)
{
    return v < LIGHTING_MAX ? v : LIGHTING_MAX;
}

/* Radiance that a white Lambert surface would send out, in arrays of the patch's size; 0 outside
 * the pixels that were asked for. One allocation. */
struct lighting {
    float *direct[3];       /* sum over lights of E_k color_k / pi */
    float *indirect[3];     /* mean bounce radiance; zero without bounces */
    float *total[3];        /* their sum */
    float *glossy[3];       /* radiance that the glossy lobe sees; without a lobe `indirect`, for
                               sub-samples that have one; NULL without planes of lobes */
    float *visibility;      /* ambient; 0 where it is not traced */
    float *width_px;        /* the largest sigma of all filters; 0: not filtered */
    float *error[3];        /* standard error of `indirect` and of filtered direct light; NULL where
                               neither is known */
    float *direct_error[3]; /* of filtered direct light, while it is found; NULL: not wanted */
    float *glossy_error[3]; /* the same of `glossy` */
    struct scratch *scratch; /* the patch's */
    void *memory;            /* owned; from there */
};

struct lighting_statistics {
    struct shadow_statistics shadow; /* over the lights */
    struct indirect_statistics indirect;
    struct glossy_statistics glossy;
    uint64_t shadow_cpu_us, indirect_cpu_us, glossy_cpu_us; /* CPU time of filters */
};

/* Computes the lighting of the pixels of `lit`, which lies in patch->core. Rectangle lights
 * under a shadow filter are filtered from their strata; other lights keep their Monte Carlo
 * means. Bounces and glossy lobes are filtered by their filters if there are any. `errors`: those
 * of shadows are wanted. Adds to *statistics. ERR_MEMORY. */
int lighting_create(const struct plan *plan, const struct patch *patch, struct rect lit,
                    bool errors, struct lighting *out, struct lighting_statistics *statistics);
void lighting_fini(struct lighting *lighting);
