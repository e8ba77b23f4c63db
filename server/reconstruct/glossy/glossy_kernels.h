#pragma once
/* The inner loop of the filters that compare glossy lobes, compiled once for each instruction set,
 * and the arrays it reads. All have the field's layout: rows of `stride` numbers with margins, so
 * that sixteen adjacent receivers can look GLOSSY_REACH_MAX_PX columns to both sides. Pixels whose
 * lobe takes no part have object 0. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"
#include "server/reconstruct/simd/lanes.h"

#define GLOSSY_REACH_MAX_PX 64
#define GLOSSY_TAPS         (2 * GLOSSY_REACH_MAX_PX) /* neighbours on a line, at most */
#define GLOSSY_CUT          8.0f                      /* exponents beyond weigh 0 */

/* How lobes are compared: as Gaussians over an ellipse, with parallax; as spherical Gaussians; as
 * the mixtures of these that glossy_mixture.h tells. The last two know no parallax. */
enum glossy_shape { GLOSSY_ELLIPTIC, GLOSSY_ROUND, GLOSSY_MIXTURE, GLOSSY_SHAPES };

/* The lobes of pixels. Each is a Gaussian around the mirrored direction with the covariance
 * along along^T + across across^T, both at right angles to it. The sharpness is such that a lobe
 * and itself are alike by 1. */
struct glossy_field {
    int32_t stride;          /* a multiple of SIMD_LANES */
    const float *point[3];   /* from the eye */
    const float *normal[3];  /* unit */
    const float *mirror[3];  /* unit */
    const float *along[3];   /* of round facets in the plane of incidence */
    const float *across[3];  /* at right angles to that; never 0 where the object is not */
    const float *round;      /* variance of the round lobe that fills the same solid angle */
    const float *sharpness;  /* half the log of that, and for mixtures what these change in it */
    const float *nearness;   /* mean of 1 / distance of what the lobe sees */
    const float *near_plane; /* neighbours may be that far off the tangent plane */
    const int32_t *object;
    const float *similarity, *distance, *footprint; /* of each pixel; NULL: those of the rule */
};

struct glossy_rule {
    float similarity; /* weight of the log of two lobes' similarity */
    float distance;   /* weight of a pixel's squared distance */
    float footprint;  /* bound on the weight of parallax, times that distance */
    float taper;      /* weights are exp(-x) (1 - taper x) up to x = 1 / taper; 0: exp(-x) */
    int32_t reach;    /* pixels to both sides, at most GLOSSY_REACH_MAX_PX */
};

/* Receivers first .. first + count - 1, a multiple of SIMD_LANES, and how many pixels they look
 * to both sides, `step` apart. */
struct glossy_run {
    size_t first;
    uint32_t count;
    ptrdiff_t step; /* 1 along x, the stride along y */
    int32_t before, after;
};

struct glossy_kernels {
    /* Filters along one line (docs/reconstruction.md, Glossy lobes). out[c] becomes the mean of
     * in[c] over the neighbours on the same object and near the tangent plane, weighted by how
     * alike their lobes are, or see the same points. Other neighbours are skipped. Constant
     * channels stay constant to the last bit. */
    void (*spread[GLOSSY_SHAPES])(const struct glossy_field *field, const struct glossy_rule *rule,
                                  const struct glossy_run *run, uint32_t count,
                                  const float *const *in, float *const *out);
};

/* The kernels of each instruction set (kernels.h). AVX2 and AVX-512 give the same bits. */
extern const struct glossy_kernels glossy_kernels_sse42, glossy_kernels_avx2, glossy_kernels_avx512;
