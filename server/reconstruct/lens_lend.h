#pragma once
/* Pixels that lend their lighting to lens samples. */
#include "server/reconstruct/lighting.h"
#include "server/reconstruct/surface.h"

typedef float lens_quad __attribute__((vector_size(16), aligned(16)));

/* Zeros: the pixel has no lighting. */
struct lens_lender {
    lens_quad plane; /* normal, and how far along it the surface is from the eye */
    lens_quad light; /* red, green, blue, and the distance along the ray */
};

/* Axes are the world's. */
struct lens_lenders {
    const struct patch *patch;
    const struct lighting *lighting;
    struct surface_view view;
    struct rect rect;
    size_t width;
    struct lens_lender *pixels;
};

/* A lens sample, and where the middle of the lens sees it: between the middles of pixel (column,
 * row) of `rect`, which may lie one beside it, and of the next to the right and below. */
struct lens_borrower {
    struct surface surface;
    float allowed; /* a little less than what any point may be off a pixel's plane */
    int32_t column, row;
    float across, down;
};

/* ERR_MEMORY; `pixels` is to be given back to the patch's scratch memory. */
int lens_lenders_create(const struct plan *plan, const struct patch *patch,
                        const struct lighting *lighting, struct rect rect,
                        struct lens_lenders *out);

/* The lighting around of pixels that show the sample's surface; false: none does. */
bool lens_lend(const struct lens_lenders *l, const struct lens_borrower *sample, float light[3]);
