#pragma once
/* Looks up the lighting of pixel centres for lens samples. */
#include "server/reconstruct/lighting/lens_relight_kernels.h"
#include "server/reconstruct/lighting/lighting.h"
#include "server/reconstruct/patch/surface.h"

#define LIGHT_LOOKUP_BESIDE 3 /* columns, and rows, of padding */

typedef float lens_quad __attribute__((vector_size(16), aligned(16)));

/* A pixel; zeros if it has no lighting. */
struct light_lookup_pixel {
    lens_quad plane; /* normal, and how far along it the surface is from the eye */
    lens_quad light; /* red, green, blue, and the distance along the ray */
    lens_quad point; /* from the eye */
};

/* The pixels of `rect`, along the world's axes. A column to the left, two to the right, and as many
 * rows are padding without lighting. */
struct light_lookup {
    const struct patch *patch;
    const struct lighting *lighting;
    struct surface_view view;
    struct rect rect;
    size_t width; /* with padding */
    struct light_lookup_pixel *pixels;
    lens_quad *lobes; /* of each pixel: what its glossy lobe sees, and alpha. With an alpha of 0 the
                         pixel has no lobe, and the light is from all around. NULL: lobes are not
                         lit by look-up */
};

/* Loads the pixels. The caller gives `pixels` back to the patch's scratch memory. ERR_MEMORY. */
int light_lookup_create(const struct plan *plan, const struct patch *patch,
                        const struct lighting *lighting, struct rect rect,
                        struct light_lookup *out);

/* Returns the limits of samples' positions for light_lookup_at. */
static inline struct rect light_lookup_around(struct rect rect)
{
    return (struct rect){rect.x0 - 1, rect.y0 - 1, rect.x1, rect.y1};
}

/* Interpolates the lighting of the pixels around sample i of the row that show its surface, and
 * what their glossy lobes see if `lobes` is set. Returns false if no pixel does. Points must lie
 * near each other's planes: at a round edge the pixel's own plane contains the ray, and with it
 * what lies far behind. */
bool light_lookup_at(const struct light_lookup *l, const struct lens_relight_row *row, uint32_t i,
                     float light[3], float gloss[3]);
