#pragma once
/* The inner loops of the filter of lens samples, once for each instruction set, and the arrays they
 * read. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"

struct lens_aperture;

#define LENS_LANES  16
#define LENS_GROUPS 4 /* quarters of the aperture, each with a transparency of its own */
#define LENS_LIGHTS 4 /* red, green, blue, and the sum of their squares */

/* Of a cell that is being filled: light, samples, slopes of those whose slopes are known, samples
 * in or beyond the layer, those of them whose slopes are known. */
#define LENS_CELL_SUMS 8

/* What a cell of a layer's image holds, each a plane. A cell that no sample passes through weighs
 * nothing. */
enum lens_cell_plane {
    LENS_CELL_REACH,  /* how far around it spreads, in cells, and half a cell */
    LENS_CELL_WEIGHT, /* lens area that a cell covers there, up to a factor */
    LENS_CELL_SHARE,  /* weight times the share of samples that meet the layer */
    LENS_CELL_LIGHT,  /* weight times mean light, what misses the layer being black */
    LENS_CELL_PLANES = LENS_CELL_LIGHT + LENS_LIGHTS
};

/* Sums over the cells that a pixel sees through its lens. */
enum lens_sum { LENS_SUM_WEIGHT, LENS_SUM_SHARE, LENS_SUM_LIGHT, LENS_SUMS = 2 + LENS_LIGHTS };

struct lens_tap {
    int32_t at;     /* from the pixel's cell */
    float distance; /* in cells; the same for all points of a scaled aperture's edge */
};

/* Taps of group g end before tap end[g]; those before inner[g] count in full wherever they are. */
struct lens_gather {
    const float *plane[LENS_CELL_PLANES];
    const struct lens_tap *taps;
    uint32_t inner[LENS_GROUPS], end[LENS_GROUPS];
};

/* Where in a layer samples of a row of pixels lie. */
struct lens_splat {
    const float *slope;            /* of the samples */
    const float *light[3];         /* theirs; where they lie beyond, anything */
    const float *along;            /* jitter of the pixels */
    const float *left, *chord;     /* of the sample's line: where it begins and how long it is */
    const float *height;           /* of that line */
    float stratum, strata_inverse; /* k and 1 / l: points lie (k + along) / l of the chord */
    int32_t x;                     /* column of the first pixel */
    float row_phase;               /* row of the pixels within its cell, in pixels */
    float cells;                   /* a pixel: 2^(fine - coarse) */
    int32_t fine, coarse;          /* one of them is 0 */
    float low, high;               /* slopes of the layer, from low, below high */
    float close;                   /* from there on samples beyond it pass it by their own slope */
    const float *pass;          /* of the pixels: slope by which samples beyond the layer pass it */
    const float *known;         /* how many slopes tell of that; 0: nobody knows it */
    int32_t beyond;             /* add those that lie beyond instead of the layer's */
    int32_t fixed;              /* all have the slope that others pass by */
    int32_t column, row;        /* of the first cell; row: from the pixels' own */
    int32_t columns, rows;      /* of all cells */
    size_t next;                /* from a row's samples to those of the row added after it */
    int32_t spare;              /* cell from which on LENS_LANES are nobody's: they take anything */
    int32_t stride, phase_step; /* cell (c, r): r stride + (c & (2^fine - 1)) phase_step + (c >>
                                   fine) */
};

/* From sums of cells to planes. Areas of the lens are 1 / slope^2 of those of the image. */
struct lens_finish {
    const float *sums; /* LENS_CELL_SUMS of each cell */
    float *plane[LENS_CELL_PLANES];
    float inradius; /* of the aperture, in cells per unit of slope */
    float middle;   /* size of slopes that nobody knows */
    int32_t fixed;  /* all have that one */
};

/* Samples in focus of a row of pixels, and what the pixels have seen before them. */
struct lens_focus {
    const float *slope, *light; /* of the first pixel's first sample, as a patch has them */
    size_t area;                /* of planes of samples */
    uint32_t samples;
    float low, high;          /* slopes in focus */
    float share[LENS_GROUPS]; /* of the lens */
    float *through[LENS_GROUPS], *lights[LENS_LIGHTS], *shares;
};

/* What pixels have seen so far: what nearer layers let through of each quarter of the lens; sums of
 * light, of shares, and of shares times slopes. */
enum lens_view {
    LENS_VIEW_THROUGH,
    LENS_VIEW_LIGHT = LENS_VIEW_THROUGH + LENS_GROUPS,
    LENS_VIEW_SHARE = LENS_VIEW_LIGHT + LENS_LIGHTS,
    LENS_VIEW_SPREAD,
    LENS_VIEWS
};

/* A layer behind that. */
struct lens_composite {
    const float *sums;        /* as gather writes them of LENS_LANES pixels, its stride */
    float share[LENS_GROUPS]; /* of the cells that make up the lens */
    float lens[LENS_GROUPS];  /* of the lens itself */
    float slope;              /* its size */
    uint32_t near;            /* bits of pixels that may see it; others stay as they are */
};

struct lens_kernels {
    /* out[(g LENS_SUMS + s) stride + i]: sum s over group g of pixel i of `count`, a multiple of
     * LENS_LANES, whose cell is `first` + i. A cell counts as far as it reaches over its distance:
     * clamped to 0 .. 1. */
    void (*gather)(const struct lens_gather *gather, size_t first, uint32_t count, float *out,
                   size_t stride);

    /* Bits of the layers (lens_layer_of) of `count` slopes. */
    uint32_t (*layers)(const float *slope, uint32_t count);

    /* lens_aperture_lines of proto/lens_pattern.h, to the last bit. */
    void (*lines)(const struct lens_aperture *a, uint32_t l, uint32_t i, uint32_t count,
                  const float *across, float *height, float *left, float *length);

    /* Adds the samples of a row, `count` of them, that are in the layer or beyond it, to the sums
     * of the cells that they lie in: LENS_CELL_SUMS of each cell, on 16 bytes. */
    void (*add)(const struct lens_splat *splat, uint32_t count, float *sums);

    /* Adds the slopes in low .. high to `sums`, and to `counts` how many. */
    void (*slopes)(const float *slope, float low, float high, uint32_t count, float *sums,
                   float *counts);

    /* Slopes by which samples pass a layer: the means of those pixels that know some; else, or if
     * fixed, `middle`. Up to LENS_LANES more than `count` are written. */
    void (*passes)(const float *sums, const float *counts, float middle, int32_t fixed,
                   size_t count, float *pass);

    /* Finishes `count` cells from `first` on, and up to LENS_LANES more. */
    void (*finish)(const struct lens_finish *finish, size_t first, size_t count);

    /* What is in focus, under what nearer layers let through, of `count` pixels, a multiple of
     * LENS_LANES. Lists those that see through but have no sample in focus or beyond, of which
     * nothing is changed; returns how many. */
    uint32_t (*focus)(const struct lens_focus *focus, uint32_t count, uint32_t *hidden);

    /* The layer, under what LENS_LANES pixels have seen. */
    void (*composite)(const struct lens_composite *composite, float seen[LENS_VIEWS][LENS_LANES]);
};

/* One for each instruction set (kernels.h). All give the same bits. */
extern const struct lens_kernels lens_kernels_sse42, lens_kernels_avx2, lens_kernels_avx512;
