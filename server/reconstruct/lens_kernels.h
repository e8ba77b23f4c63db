#pragma once
/* The inner loops of the filter of lens samples, once for each instruction set, and the arrays they
 * read. */
#include <stddef.h>
#include <stdint.h>

#define LENS_LANES  16
#define LENS_GROUPS 4 /* quarters of the aperture, each with a transparency of its own */
#define LENS_LIGHTS 4 /* red, green, blue, and the sum of their squares */

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
struct lens_place {
    const float *slope;            /* of the samples */
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
    int32_t beyond;             /* place those that lie beyond instead of the layer's */
    int32_t fixed;              /* all have the slope that others pass by */
    int32_t column, row;        /* of the first cell; row: from the pixels' own */
    int32_t columns, rows;      /* of all cells */
    int32_t stride, phase_step; /* cell (c, r): r stride + (c & (2^fine - 1)) phase_step + (c >>
                                   fine) */
};

struct lens_kernels {
    /* out[(g LENS_SUMS + s) stride + i]: sum s over group g of pixel i of `count`, a multiple of
     * LENS_LANES, whose cell is `first` + i. A cell counts as far as it reaches over its distance:
     * clamped to 0 .. 1. */
    void (*gather)(const struct lens_gather *gather, size_t first, uint32_t count, float *out,
                   size_t stride);

    /* Bits of the layers (lens_layer_of) of `count` slopes. */
    uint32_t (*layers)(const float *slope, uint32_t count);

    /* lens_disc_lines of proto/lens_pattern.h. */
    void (*lines)(uint32_t l, uint32_t i, uint32_t count, const float *across, float *height,
                  float *left, float *length);

    /* The cells of a row's samples; -1: not in the layer, or in none of the cells. */
    void (*place)(const struct lens_place *place, uint32_t count, int32_t *cell);
};

/* One for each of build_isa()'s names; lens_kernels_c runs anywhere. */
extern const struct lens_kernels lens_kernels_c, lens_kernels_avx2, lens_kernels_avx512;

/* The kernels to use here: those of build_isa(). All give the same bits. */
const struct lens_kernels *lens_kernels_best(void);
