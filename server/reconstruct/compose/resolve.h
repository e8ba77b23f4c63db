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
    float error[3];        /* standard error of diffuse indirect; 0 unless the lighting tells */
    float glossy_error[3]; /* of what glossy lobes send on; the same */
    float spread[3]; /* squared standard error of total, as a mean of so few samples of the pixel; 0
                        unless wanted */
    uint32_t lone;   /* sub-samples that have light of their own */
    uint32_t unmatched; /* others whose surface no pixel around them shows */
};

struct resolver {
    const struct plan *plan; /* borrowed, as all below */
    const struct patch *patch;
    const struct lighting *lighting;
    struct surface_view view;
    uint32_t subs; /* sub-samples that take part: 0 when planes for the comparison are missing */
    float share;   /* 1 / (1 + subs) */
    bool errors;   /* are wanted; false unless the caller says otherwise */
    bool parts;    /* direct and indirect light, too: true unless the caller says otherwise */
};

void resolver_init(struct resolver *r, const struct plan *plan, const struct patch *patch,
                   const struct lighting *lighting);

/* Pixel i of the patch. Reads the pixels around it as far as the patch has them.
 *
 * A lone sub-sample (proto/lone.h) has the light that it was shaded with.
 *
 * A sub-sample that fully matches its own pixel (surface_match 1) takes that pixel's lighting as it
 * is: flat regions are not blurred. Otherwise with m its match to its own pixel, the lighting is
 * the mean with weights m for the own pixel and (1 - m) k_q m_q / 8 for the 8 around, k_q a tent 3
 * pixels wide. Where no weight is left, the least mismatch decides, and the sub-sample counts as
 * unmatched; without any surface around, it is unlit. */
void resolve_pixel(const struct resolver *r, size_t i, struct resolved *out);
