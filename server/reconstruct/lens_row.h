#pragma once
/* Where lens samples of a row of pixels lie: what each shows as the middle of the lens sees it. */
#include "proto/lens_pattern.h"
#include "proto/pattern_path.h"
#include "server/reconstruct/lens_kernels.h"
#include "server/reconstruct/surface.h"

/* Arrays of as many pixels as a row has. */
struct lens_row {
    const struct plan *plan;
    const struct patch *patch;
    const struct lens_kernels *kernels;
    struct surface_view view;
    struct lens_pattern pattern;
    float *along, *across;         /* jitters of the pixels' lens points */
    float *height, *left, *length; /* of the line at hand */
    struct path_seeds *seeds;      /* of points in pixels */

    /* The row at hand, and a line of the lens. */
    int32_t x, y;
    uint32_t count, line;

    /* Of samples that were placed: where the middle of the lens sees their points, in pixels;
     * their points, how far those are, and their normals, along the world's axes. */
    float *at[2], *z, *distance, *point[3], *normal[3];
    void *memory;
};

/* ERR_MEMORY; rows have up to `width` pixels. fini is to be called either way. */
int lens_row_create(const struct plan *plan, const struct patch *patch, size_t width,
                    struct lens_row *out);
void lens_row_fini(struct lens_row *r);

/* Begins a row: `count` pixels from (x, y) on. */
void lens_row_begin(struct lens_row *r, int32_t x, int32_t y, uint32_t count);

/* Line i of the lens. */
void lens_row_line(struct lens_row *r, uint32_t i);

/* Samples k of the line, of pixels from `begin` to `end` - 1 of the row. */
void lens_row_place(struct lens_row *r, uint32_t k, uint32_t begin, uint32_t end);
