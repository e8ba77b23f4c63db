#pragma once
/* Pixels that lend their lighting to lens samples. */
#include "server/reconstruct/lighting/lens_light_kernels.h"
#include "server/reconstruct/lighting/lighting.h"
#include "server/reconstruct/patch/surface.h"

#define LIGHT_LOOKUP_BESIDE 3 /* columns, and rows, of pixels that have nothing */

typedef float lens_quad __attribute__((vector_size(16), aligned(16)));

/* Zeros: the pixel has no lighting. */
struct light_lookup_pixel {
    lens_quad plane; /* normal, and how far along it the surface is from the eye */
    lens_quad light; /* red, green, blue, and the distance along the ray */
    lens_quad point; /* from the eye */
};

/* Axes are the world's. Around `rect` lie a column to the left, two to the right, and such rows,
 * that have nothing to lend. */
struct light_lookup {
    const struct patch *patch;
    const struct lighting *lighting;
    struct surface_view view;
    struct rect rect;
    size_t width; /* of all */
    struct light_lookup_pixel *pixels;
    lens_quad *lobes; /* of each what its glossy lobe sees, and alpha, 0: it has none and this is
                       * what it sees all around; NULL: fields light no lobes */
};

/* ERR_MEMORY; `pixels` is to be given back to the patch's scratch memory. */
int light_lookup_create(const struct plan *plan, const struct patch *patch,
                        const struct lighting *lighting, struct rect rect,
                        struct light_lookup *out);

/* Where samples are to be placed for light_lookup. */
static inline struct rect light_lookup_around(struct rect rect)
{
    return (struct rect){rect.x0 - 1, rect.y0 - 1, rect.x1, rect.y1};
}

/* The lighting of pixels around sample i of the row that show its surface, and what their glossy
 * lobes see where `lobes` are there; false: none does. Points
 * lie near each other's planes. The pixel's alone does not tell: at the edge of something round it
 * goes on along the ray, and what lies far behind is on it, too. */
bool light_lookup_at(const struct light_lookup *l, const struct lens_light_row *row, uint32_t i,
                     float light[3], float gloss[3]);
