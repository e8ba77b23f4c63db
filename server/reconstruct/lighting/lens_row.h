#pragma once
/* Where lens samples of a row of pixels lie: what each shows as the middle of the lens sees it. */
#include "proto/lens_pattern.h"
#include "server/reconstruct/lens/lens_kernels.h"
#include "server/reconstruct/lighting/lens_light_kernels.h"
#include "server/reconstruct/patch/surface.h"

struct lens_row {
    const struct plan *plan;
    const struct patch *patch;
    const struct lens_kernels *lens;
    const struct lens_light_kernels *kernels;
    struct surface_view view;
    struct lens_pattern pattern;
    float *along, *across;         /* jitters of the pixels' lens points */
    float *height, *left, *length; /* of the line at hand */
    uint32_t *order, *u, *v;       /* path_seeds of points in pixels */
    int32_t x, y;                  /* of the first pixel */
    uint32_t count, line;
    struct lens_light_row samples; /* those that were placed last, along the world's axes */
    void *memory;
};

/* Rows have up to `width` pixels; samples are placed in `around`. ERR_MEMORY; fini is to be called
 * either way. */
int lens_row_create(const struct plan *plan, const struct patch *patch, size_t width,
                    struct rect around, struct lens_row *out);
void lens_row_fini(struct lens_row *r);

/* Begins a row: `count` pixels from (x, y) on. */
void lens_row_begin(struct lens_row *r, int32_t x, int32_t y, uint32_t count);

/* Line i of the lens. */
void lens_row_line(struct lens_row *r, uint32_t i);

/* Samples k of the line, of pixels from `begin` to `end` - 1 of the row. */
void lens_row_place(struct lens_row *r, uint32_t k, uint32_t begin, uint32_t end);
