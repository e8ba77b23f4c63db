#pragma once
/* The inner loops of the lens filter, compiled once for each instruction set, and the arrays they
 * read. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"
#include "server/reconstruct/simd/lanes.h"

struct lens_aperture;

#define LENS_GROUPS 4 /* quarters of the aperture, each with its own transparency */
#define LENS_LIGHTS 4 /* red, green, blue, and the sum of their squares */

/* The sums of a cell while it is filled: light, samples, known slopes, samples in or beyond the
 * layer, and how many of them have known slopes. */
#define LENS_CELL_SUMS 8

/* Planes of a layer's image. A cell without samples has weight 0. */
enum lens_cell_plane {
    LENS_CELL_REACH,  /* how far around it spreads, in cells, plus half a cell */
    LENS_CELL_WEIGHT, /* lens area that a cell covers there, up to a factor */
    LENS_CELL_SHARE,  /* weight times the share of samples that meet the layer */
    LENS_CELL_LIGHT,  /* weight times mean light; samples that miss the layer are black */
    LENS_CELL_PLANES = LENS_CELL_LIGHT + LENS_LIGHTS
};

/* Sums over the cells that a pixel sees through its lens. */
enum lens_sum { LENS_SUM_WEIGHT, LENS_SUM_SHARE, LENS_SUM_LIGHT, LENS_SUMS = 2 + LENS_LIGHTS };

struct lens_tap {
    int32_t at;     /* from the pixel's cell */
    float distance; /* in cells; the same for all points of a scaled aperture's edge */
};

/* Taps of group g end before tap end[g]. Those before inner[g] have full weight, wherever the pixel
 * lies in its cell. */
struct lens_gather {
    const float *plane[LENS_CELL_PLANES];
    const struct lens_tap *taps;
    uint32_t inner[LENS_GROUPS], end[LENS_GROUPS];
};

/* Samples of a row of pixels, and how they are projected to a layer's cells. */
struct lens_splat {
    const float *slope;            /* of the samples */
    const float *light[3];         /* of the samples; undefined where they lie beyond */
    const float *along;            /* jitter of the pixels */
    const float *left, *chord;     /* of the sample's line: where it begins and how long it is */
    const float *height;           /* of that line */
    float stratum, strata_inverse; /* k and 1 / l: points lie (k + along) / l of the chord */
    int32_t x;                     /* column of the first pixel */
    float row_phase;               /* row of the pixels within its cell, in pixels */
    float cells;                   /* a pixel: 2^(fine - coarse) */
    int32_t fine, coarse;          /* one of them is 0 */
    float low, high;               /* slopes of the layer, from low, below high */
    float close;        /* from that slope on samples beyond the layer pass it by their own slope */
    const float *pass;  /* of the pixels: slope by which samples beyond the layer pass it */
    const float *known; /* slopes that `pass` was found from; 0: unknown */
    int32_t beyond;     /* whether to add the samples beyond the layer instead of its own */
    int32_t fixed;      /* whether all samples have the slope that others pass by */
    int32_t column, row;   /* of the first cell; row: relative to the pixels' own */
    int32_t columns, rows; /* of all cells */
    size_t next;           /* from a row's samples to those of the row added after it */
    int32_t spare;         /* first of SIMD_LANES spare cells, which take what belongs nowhere */
    int32_t stride, phase_step; /* cell (c, r): r stride + (c & (2^fine - 1)) phase_step + (c >>
                                   fine) */
};

/* Turns sums of cells into planes. Areas of the lens are 1 / slope^2 of those of the image. */
struct lens_finish {
    const float *sums; /* LENS_CELL_SUMS of each cell */
    float *plane[LENS_CELL_PLANES];
    float inradius; /* of the aperture, in cells per unit of slope */
    float middle;   /* size of unknown slopes */
    int32_t fixed;  /* whether all slopes have that size */
};

/* Samples in focus of a row of pixels, and what the pixels gathered before. */
struct lens_focus {
    const float *slope, *light; /* of the first pixel's first sample, as a patch has them */
    size_t area;                /* of planes of samples */
    uint32_t samples;
    float low, high;          /* slopes in focus */
    float share[LENS_GROUPS]; /* of the lens */
    float *through[LENS_GROUPS], *lights[LENS_LIGHTS], *shares;
};

/* What pixels have gathered so far: the transparency of nearer layers in each quarter of the lens;
 * sums of light, of shares, and of shares times slopes. */
enum lens_view {
    LENS_VIEW_THROUGH,
    LENS_VIEW_LIGHT = LENS_VIEW_THROUGH + LENS_GROUPS,
    LENS_VIEW_SHARE = LENS_VIEW_LIGHT + LENS_LIGHTS,
    LENS_VIEW_SPREAD,
    LENS_VIEWS
};

/* A layer to be composited behind that. */
struct lens_composite {
    const float *sums;        /* as gather writes them of SIMD_LANES pixels, its stride */
    float share[LENS_GROUPS]; /* of the cells that make up the lens */
    float lens[LENS_GROUPS];  /* of the lens itself */
    float slope;              /* its size */
    uint32_t near;            /* bits of pixels that may see it; the others stay as they are */
};

struct lens_kernels {
    /* Gathers cells: out[(g LENS_SUMS + s) stride + i] becomes sum s over group g of pixel i of
     * `count`, a multiple of SIMD_LANES, whose cell is `first` + i. A cell is weighted by its reach
     * less its distance, clamped to 0 .. 1. */
    void (*gather)(const struct lens_gather *gather, size_t first, uint32_t count, float *out,
                   size_t stride);

    /* Returns the bits of the layers (lens_layer_of) of `count` slopes. */
    uint32_t (*layers)(const float *slope, uint32_t count);

    /* Computes lens_aperture_lines of proto/lens_pattern.h, to the last bit. */
    void (*lines)(const struct lens_aperture *a, uint32_t l, uint32_t i, uint32_t count,
                  const float *across, float *height, float *left, float *length);

    /* Adds the `count` samples of a row that are in the layer or beyond it to the sums of their
     * cells: LENS_CELL_SUMS of each cell, aligned to 16 bytes. */
    void (*add)(const struct lens_splat *splat, uint32_t count, float *sums);

    /* Adds the slopes in low .. high to `sums`, and their number to `counts`. */
    void (*slopes)(const float *slope, float low, float high, uint32_t count, float *sums,
                   float *counts);

    /* Computes the slopes by which samples pass a layer: the mean of a pixel's known slopes;
     * without any, or if fixed, `middle`. Up to SIMD_LANES more than `count` are written. */
    void (*passes)(const float *sums, const float *counts, float middle, int32_t fixed,
                   size_t count, float *pass);

    /* Finishes `count` cells from `first` on, and up to SIMD_LANES more. */
    void (*finish)(const struct lens_finish *finish, size_t first, size_t count);

    /* Composites what is in focus, behind nearer layers, for `count` pixels, a multiple of
     * SIMD_LANES. Lists the pixels that see through but have no sample in focus or beyond, and
     * leaves them as they are. Returns their number. */
    uint32_t (*focus)(const struct lens_focus *focus, uint32_t count, uint32_t *hidden);

    /* Composites the layer behind what SIMD_LANES pixels have gathered. */
    void (*composite)(const struct lens_composite *composite, float seen[LENS_VIEWS][SIMD_LANES]);
};

/* The kernels of each instruction set (kernels.h). All give the same bits. */
extern const struct lens_kernels lens_kernels_sse42, lens_kernels_avx2, lens_kernels_avx512;
