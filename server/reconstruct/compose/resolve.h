#pragma once
/* Anti-aliasing (docs/reconstruction.md, Anti-aliasing): a pixel is the mean of its centre and its
 * sub-samples, each with its own albedo and the lighting of the pixel around it that shows the same
 * surface. */
#include "server/reconstruct/lighting/lighting.h"
#include "server/reconstruct/patch/surface.h"

/* What a pixel shows, before emission. */
struct resolved {
    float direct[3], indirect[3], total[3]; /* radiance: lighting times albedo; glossy lobes' times
                                               reflectance is indirect */
    float albedo[3];                        /* mean; samples without surface count as black */
    float coverage;                         /* share of samples that hit a surface */
    float error[3];        /* standard error of diffuse indirect light; 0 unless known */
    float glossy_error[3]; /* that of glossy lobes' light; likewise */
    float spread[3]; /* variance of total, as a mean of the pixel's few samples; 0 unless wanted */
    uint32_t lone;   /* sub-samples with light of their own */
    uint32_t unmatched; /* others whose surface is shown by no pixel around them */
    uint32_t mixed;     /* 1: a mixed pixel, of which the two above are 0 */
};

struct resolver {
    const struct plan *plan; /* borrowed, as all below */
    const struct patch *patch;
    const struct lighting *lighting;
    struct surface_view view;
    uint32_t subs; /* sub-samples that are compared: 0 when planes for it are missing */
    float share;   /* 1 / (1 + subs) */
    bool errors;   /* whether errors are wanted; false unless the caller sets it */
    bool parts; /* whether direct and indirect light are, too; true unless the caller clears it */
};

void resolver_init(struct resolver *r, const struct plan *plan, const struct patch *patch,
                   const struct lighting *lighting);

/* Resolves pixel i of the patch from the pixels around it, as far as the patch has them. A mixed
 * pixel goes by its entries (resolve_mixed.h).
 *
 * A lone sub-sample (proto/lone.h) keeps the light that it was shaded with. A sub-sample that fully
 * matches its own pixel (surface_match 1) takes that pixel's lighting as it is, so that flat
 * regions are not blurred. Otherwise the lighting is a weighted mean: with m the match to its own
 * pixel, the own pixel has the weight m and each of the 8 around (1 - m) k_q m_q / 8, k_q a tent 3
 * pixels wide. Where all weights vanish, the pixel of least mismatch is taken, and the sub-sample
 * counts as unmatched; without any surface around it is unlit. */
void resolve_pixel(const struct resolver *r, size_t i, struct resolved *out);
