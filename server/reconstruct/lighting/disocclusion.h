#pragma once
/* Light of points that lens samples show and the middle of the lens does not: behind the edges of
 * what is near. Each such sample has the light that its own path has found, which is noise. Samples
 * of the same surface that lie near each other, as the middle of the lens would see them, share
 * theirs: means over a few pixels, over fewer the more samples a pixel has, down to one pixel, the
 * resolution of lighting that fields lend (lens_light.h).
 *
 * Where shapes are finer than pixels a surface has few samples around. Until they are enough, what
 * faces about the same way and lies about as far does for it: other samples that no field lights,
 * and the lighting of the pixels beside. What lobes reflect stays on its own surface, which alone
 * knows how much that is; it is sharper than light, and samples of fewer pixels share it. */
#include "server/reconstruct/lighting/light_lookup.h"
#include "server/reconstruct/patch/scratch.h"

/* How far apart, in pixels, samples at most are that share. What lens filters read around a block
 * is that much more than what their pixels look at. */
#define DISOCCLUSION_REACH_PX 3

struct disocclusion {
    struct scratch *scratch;
    size_t width, height;            /* in cells, which are pixels: columns and rows of samples */
    float radius;                    /* px; samples farther apart do not share light */
    float rest_radius;               /* nor what they send besides, which is sharper */
    uint32_t *first;                 /* of each cell its last spot */
    struct disocclusion_spot *spots; /* surfaces that cells have */
    size_t spot_count, spot_room;
    struct disocclusion_sample *list;
    size_t count, room; /* samples in the list, and for how many it has room */
};

/* What a sample shares. */
enum {
    DISOCCLUSION_LIGHT = 1, /* what falls on it; else a field has it */
    DISOCCLUSION_REST = 2   /* what it sends besides: the reflection of a glossy lobe */
};

struct disocclusion_sample {
    size_t at;               /* whatever finds the sample */
    uint32_t spot;           /* what is shared is this one's */
    uint32_t shares;         /* bits of the above */
    float light[3], rest[3]; /* its own */
};

/* Of l x l samples a pixel that are placed in columns up to width - 2 and rows up to height - 2.
 * ERR_MEMORY; fini is to be called either way. */
int disocclusion_create(struct scratch *scratch, size_t width, size_t height, uint32_t l,
                        struct disocclusion *out);
void disocclusion_fini(struct disocclusion *d);

/* Adds sample i of the row, of that light and rest. 1: it is in the list as `at`, and will share
 * them; 0: too many other surfaces lie in its cell, and it keeps both. ERR_MEMORY. */
int disocclusion_add(struct disocclusion *d, const struct lens_light_row *row, uint32_t i,
                     const float light[3], const float rest[3], uint32_t shares, size_t at);

/* After all have been added: light and rest of one of the list, `pixels` being the pixels in the
 * cells. */
void disocclusion_share(const struct disocclusion *d, const struct light_lookup_pixel *pixels,
                        const struct disocclusion_sample *sample, float light[3], float rest[3]);
