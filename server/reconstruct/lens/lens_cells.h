#pragma once
/* One layer's image, made of the samples that lie in it or pass it: square cells over the picture's
 * plane, larger where the layer is farther out of focus. A sample (x, u) of slope s is projected to
 * x + s u. */
#include <stdbool.h>

#include "server/reconstruct/lens/lens_field.h"

#define LENS_TILE 8 /* cells a side that are marked together where there is something to see */

struct lens_cells {
    uint32_t layer;
    float low, high;      /* slopes */
    float close;          /* below `low`: from there on samples pass by their own slope */
    float least, most;    /* of their sizes */
    float middle;         /* of them */
    bool fixed;           /* too far out of focus to be projected */
    int32_t fine, coarse; /* cells a pixel: 2^(fine - coarse); one of them is 0 */
    int32_t phase;        /* 2^fine - 1: columns are stored by their last digits first */
    float scale;          /* that */
    struct rect targets;  /* pixels of the field's `wide` that can see the layer; may be empty */
    struct rect rect;     /* cells, in those of the whole picture */
    struct rect pixels;   /* whose samples can lie in them */
    struct rect *windows; /* of each sample: of which pixels it can */
    int32_t columns;      /* of one phase */
    int32_t stride;       /* of rows */
    size_t area;          /* of a plane */
    float *sums;          /* 8 a cell: light, samples, slopes, samples in or beyond the layer */
    float *plane[LENS_CELL_PLANES];
    struct rect tiles; /* in tiles of the whole picture */
    uint8_t *near;     /* of tiles: can a pixel there see the layer? */
    uint8_t *read;     /* of tiles: can such a pixel see the tile? */
    uint8_t *from;     /* of tiles: can samples of pixels there lie in what such pixels see? */
    uint8_t *spare;
    void *memory;
};

/* ERR_MEMORY; then fini still has to be called. */
int lens_cells_create(const struct lens_field *f, uint32_t layer, struct lens_cells *out);
void lens_cells_fini(const struct lens_field *f, struct lens_cells *c);

/* How far apart pixels are at most of which one sees what samples of the layer, l x l a pixel, or
 * beyond it say of the other's. */
int32_t lens_cells_reach_px(uint32_t layer, uint32_t l);

/* Of samples of the layer, l x l a pixel, those are not read that lie farther than this from all
 * pixels that look, in pixels. */
int32_t lens_cells_around_px(uint32_t layer, uint32_t l);

/* Makes the layer's image. */
void layer_splat(const struct lens_field *f, struct lens_cells *c);

/* Adds what each pixel sees of the layer through what nearer layers leave of its lens. */
void layer_composite(struct lens_field *f, const struct lens_cells *c);
