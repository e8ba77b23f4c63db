#pragma once
/* One layer's image, made of the samples that lie in it or pass it. Its square cells cover the
 * picture's plane, and are larger the farther the layer is out of focus. A sample (x, u) of slope s
 * is projected to x + s u. */
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

/* Creates the cells of a layer. ERR_MEMORY; fini must be called even then. */
int lens_cells_create(const struct lens_field *f, uint32_t layer, struct lens_cells *out);
void lens_cells_fini(const struct lens_field *f, struct lens_cells *c);

/* Returns the greatest distance between two pixels of which one reads samples of the other, in the
 * layer or beyond it, at l x l samples a pixel. */
int32_t lens_cells_reach_px(uint32_t layer, uint32_t l);

/* Returns the distance in pixels beyond which samples of the layer are read by no pixel, at l x l
 * samples a pixel. */
int32_t lens_cells_around_px(uint32_t layer, uint32_t l);

/* Splats samples into the layer's image. */
void layer_splat(const struct lens_field *f, struct lens_cells *c);

/* Adds what each pixel sees of the layer through the part of its lens that nearer layers leave. */
void layer_composite(struct lens_field *f, const struct lens_cells *c);
