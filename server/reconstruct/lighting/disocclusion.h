#pragma once
/* Light of points that a lens sample sees and the centre of the lens does not: those disoccluded
 * behind the edges of near things. Each such sample has only its own path's light, which is noisy.
 * Samples of one surface that lie near each other, as seen from the centre, share their light: it
 * is averaged over a few pixels, which shrink to one pixel as samples grow, the resolution of
 * looked-up light (lens_relight.h).
 *
 * Where shapes are finer than pixels a surface has few samples around. Until they suffice, surfaces
 * that face about the same way and lie about as far away are taken, too: other samples without
 * looked-up light, and the lighting of the pixels beside. Reflections of lobes are shared within
 * one surface only, since its reflectance is in them. They are sharper than diffuse light and are
 * shared over fewer pixels. */
#include "server/reconstruct/lighting/light_lookup.h"
#include "server/reconstruct/patch/scratch.h"

/* The largest distance, in pixels, of samples that share. It adds to what the lens filter reads
 * around a block. */
#define DISOCCLUSION_REACH_PX 3

struct disocclusion {
    struct scratch *scratch;
    size_t width, height;            /* in cells, which are pixels: columns and rows of samples */
    float radius;                    /* px; within it samples share light */
    float rest_radius;               /* px; within it they share reflections, which are sharper */
    uint32_t *first;                 /* of each cell: its last spot */
    struct disocclusion_spot *spots; /* surfaces in cells */
    size_t spot_count, spot_room;
    struct disocclusion_sample *list;
    size_t count, room; /* samples in the list, and its room */
};

/* What a sample shares. */
enum {
    DISOCCLUSION_LIGHT = 1, /* incident light; else it was looked up */
    DISOCCLUSION_REST = 2   /* the reflection of a glossy lobe */
};

struct disocclusion_sample {
    size_t at;               /* the caller's index of the sample */
    uint32_t spot;           /* whose shared light it takes */
    uint32_t shares;         /* bits of the above */
    float light[3], rest[3]; /* its own */
};

/* Creates an empty list for l x l samples a pixel, placed in columns up to width - 2 and rows up to
 * height - 2. ERR_MEMORY; fini must be called either way. */
int disocclusion_create(struct scratch *scratch, size_t width, size_t height, uint32_t l,
                        struct disocclusion *out);
void disocclusion_fini(struct disocclusion *d);

/* Adds sample i of the row, with its light and rest. Returns 1 if it is in the list, as `at`; 0 if
 * its cell has too many other surfaces and it keeps both; ERR_MEMORY. */
int disocclusion_add(struct disocclusion *d, const struct lens_relight_row *row, uint32_t i,
                     const float light[3], const float rest[3], uint32_t shares, size_t at);

/* Returns light and rest of a sample of the list, after all have been added. `pixels` are the
 * pixels in the cells. */
void disocclusion_share(const struct disocclusion *d, const struct light_lookup_pixel *pixels,
                        const struct disocclusion_sample *sample, float light[3], float rest[3]);
