#pragma once
/* Places the lens samples of a row of pixels in the view of the lens' centre. */
#include "proto/lens_pattern.h"
#include "server/reconstruct/lens/lens_kernels.h"
#include "server/reconstruct/lighting/lens_relight_kernels.h"
#include "server/reconstruct/patch/surface.h"

struct lens_row {
    const struct plan *plan;
    const struct patch *patch;
    const struct lens_kernels *lens;
    const struct lens_relight_kernels *kernels;
    struct surface_view view;
    struct lens_pattern pattern;
    float *along, *across;         /* jitters of the pixels' lens points */
    float *height, *left, *length; /* of the current line */
    uint32_t *order, *u, *v;       /* path_seeds of points in pixels */
    int32_t x, y;                  /* of the first pixel */
    uint32_t count, line;
    struct lens_relight_row samples; /* the samples placed last, along the world's axes */
    void *memory;
};

/* Creates a row of up to `width` pixels; positions are limited to `around`. ERR_MEMORY; fini must
 * be called either way. */
int lens_row_create(const struct plan *plan, const struct patch *patch, size_t width,
                    struct rect around, struct lens_row *out);
void lens_row_fini(struct lens_row *r);

/* Begins a row of `count` pixels from (x, y) on. */
void lens_row_begin(struct lens_row *r, int32_t x, int32_t y, uint32_t count);

/* Begins line i of the lens. */
void lens_row_line(struct lens_row *r, uint32_t i);

/* Places samples k of the line, of pixels `begin` to `end` - 1 of the row. */
void lens_row_place(struct lens_row *r, uint32_t k, uint32_t begin, uint32_t end);
