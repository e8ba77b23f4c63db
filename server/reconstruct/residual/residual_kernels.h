#pragma once
/* The residual filter's inner loops, once for each instruction set. All compute the same bits. */
#include <stdbool.h>

#include "proto/runtime/kernels.h"
#include "server/reconstruct/residual/residual_field.h"

#define RESIDUAL_TAPS_MAX   64 /* of a pass */
#define RESIDUAL_TAPS_CHUNK 4  /* that are added at a time */
#define RESIDUAL_PATCH_MAX  3

struct residual_tap {
    int32_t x, y;
};

/* How a pass weighs and what it filters. */
enum residual_kind {
    RESIDUAL_CROSS, /* each half, by what the other one shows */
    RESIDUAL_JOINT, /* both halves, by their mean */
    RESIDUAL_MEAN   /* the mean, by itself */
};

struct residual_pass {
    enum residual_kind kind;
    uint32_t tap_count;
    struct residual_tap taps[RESIDUAL_TAPS_MAX]; /* without (0, 0), which counts in full */
    int32_t patch_px[RESIDUAL_COMPONENTS]; /* a patch has 2 patch_px + 1 pixels a side: 1 or 3 */
    float sharpness[RESIDUAL_COMPONENTS];  /* 1 / k^2 */
    bool smooth[RESIDUAL_COMPONENTS];      /* guides are, over 3 x 3 pixels */
    uint32_t probes;                       /* that it filters, if there are any */
};

#define RESIDUAL_TILE (RESIDUAL_TILE_X * RESIDUAL_TILE_Y)

/* Rows and columns that patches of a tile's pixels reach, in whole vectors. */
#define RESIDUAL_ROWS    (RESIDUAL_TILE_Y + 2 * RESIDUAL_PATCH_MAX)
#define RESIDUAL_COLUMNS (RESIDUAL_TILE_X + 16)

/* Scratch of one thread. A row of the tile has RESIDUAL_TILE_X numbers, whatever its width. */
struct residual_tile {
    size_t base;  /* where its first pixel is in the planes */
    size_t width; /* a multiple of 16 */
    size_t height;
    _Alignas(64) float exponent[2][RESIDUAL_TAPS_CHUNK][RESIDUAL_TILE]; /* by features: of diffuse
                                                                         light, of the rest */
    _Alignas(64) float distance[RESIDUAL_ROWS * RESIDUAL_COLUMNS];
    struct residual_patches { /* sums of distances over patches' columns, by row; and of two rows */
        _Alignas(64) float across[RESIDUAL_ROWS * RESIDUAL_TILE_X];
        _Alignas(64) float pairs[RESIDUAL_ROWS * RESIDUAL_TILE_X];
    } patches[RESIDUAL_TAPS_CHUNK];
    _Alignas(64) float weight[RESIDUAL_TAPS_CHUNK][RESIDUAL_TILE_X];
    struct residual_sums {
        _Alignas(64) float sum[2][3][RESIDUAL_TILE]; /* of weighted differences from the pixel */
        _Alignas(64) float weights[2][RESIDUAL_TILE];
    } sums[RESIDUAL_COMPONENTS];
    _Alignas(
        64) float probes[RESIDUAL_COMPONENTS][2][RESIDUAL_PROBES][RESIDUAL_TILE]; /* likewise */
};

struct residual_kernels {
    /* Computes exponents of `count` taps for the tile, which tell how little features have in
     * common. */
    void (*compare_features)(const struct residual_features *f, const struct residual_tap *taps,
                             uint32_t count, struct residual_tile *tile);

    /* Adds these taps, whose exponents the tile has, to the sums of a component: of half `half`
     * under RESIDUAL_CROSS, of both under RESIDUAL_JOINT, else of the first, which is the mean. */
    void (*add_taps)(const struct residual_pass *pass, const struct residual_field *field,
                     enum residual_component component, uint32_t first_tap, uint32_t count,
                     int half, struct residual_tile *tile);

    /* Writes half `half`'s filtered light from its sums, under the weights of `weights`. */
    void (*finish)(const struct residual_field *field, enum residual_component component, int half,
                   int weights, const struct residual_tile *tile);

    /* Does the same for its probes. */
    void (*finish_probes)(const struct residual_field *field, enum residual_component component,
                          int half, const struct residual_tile *tile);
};

extern const struct residual_kernels residual_kernels_sse42, residual_kernels_avx2,
    residual_kernels_avx512;
