#pragma once
/* Loops over the lens samples of a row of pixels that light fields light, compiled once for each
 * instruction set, and the arrays they read and write. */
#include <stdint.h>

#include "proto/runtime/kernels.h"

/* Numbers of the pixels of a row and a line of the lens, and of samples k of that line. */
struct lens_relight_row {
    const float *along, *height, *left, *length; /* of lens_pattern.h */
    const uint32_t *order, *u, *v;               /* path_seeds of points in pixels */
    float x, y;                                  /* of the first pixel */
    uint32_t l, k, sample;

    /* The camera: plane coordinates at pixel position 0 and a pixel, and its axes. */
    float a_start, a_step, b_start, b_step;
    float right[3], up[3], forward[3];
    float unit;                         /* of depths */
    float allowed;                      /* off a pixel's plane, of a distance */
    float x_low, x_high, y_low, y_high; /* integers: the bounds of all positions */

    const float *slope;
    const uint16_t *code; /* normals */
    float *z;             /* read, in units; written, of the scene */

    /* The position in the view of the lens' centre: between the centres of pixel (column, row),
     * counted from the low bounds, and of the next pixels to the right and below. */
    int32_t *column, *row;
    float *across, *down;
    float *distance, *off, *point[3], *normal[3]; /* off: a little less than is allowed */
};

struct lens_relight_kernels {
    /* Places samples begin .. end - 1. */
    void (*place)(const struct lens_relight_row *row, uint32_t begin, uint32_t end);

    /* Unpacks the light of `count` samples and multiplies it by `scale`. */
    void (*own)(const uint32_t *packed, float scale, uint32_t count, float *const light[3]);

    /* Multiplies light by channel c of albedo and adds emission; `out` may be `shine`. */
    void (*add)(const uint32_t *albedo, const float *light, const float *shine, uint32_t c,
                uint32_t count, float *out);

    /* Returns the greatest size of slopes, but at least `least`. */
    float (*max)(const float *slope, uint32_t count, float least);
};

/* The kernels of each instruction set (kernels.h). All give the same bits. */
extern const struct lens_relight_kernels lens_relight_kernels_sse42, lens_relight_kernels_avx2,
    lens_relight_kernels_avx512;
