#pragma once
/* The inner loops of the sheared filter of indirect light, compiled once for each instruction set,
 * and the arrays they read.
 *
 * A sample of a bounce ray d = (x, y, z) around the normal has v = (x/z, y/z). At a receiver whose
 * ray to the same point passes through v - s it is weighted by the ratio of the cosines to the
 * fourth power (docs/reconstruction.md, V-plane filter). For a shift along y alone that is
 *
 *   gamma(v - s) / gamma(v) = 1 / (1 - 2 y z s + z^2 s^2)^2,
 *
 * which has no pole: for |s| <= 1 it is between 0.14 and 6.9.
 *
 * Arrays of the field are width * height, row by row, with margins around all pixels that walk, so
 * that no walk leaves it. Pixels without a surface, or where nothing was measured, have a zero
 * normal, which no receiver accepts. Weights travel as a fourth channel and are treated like
 * radiance, operation by operation: where all radiance is 1 (or any power of two), so is the
 * result, to the last bit. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"
#include "server/reconstruct/simd/lanes.h"

#define V_PLANE_REACH_PX    16  /* farthest pixel of a walk */
#define V_PLANE_SLOPES_PX   2   /* radius of the window, over one object, for slopes */
#define V_PLANE_STRATA_MAX  16  /* l; LIMIT_PLANE_STRATA_PER_AXIS */
#define V_PLANE_NODES       31  /* shifts along x, from -1 to 1, at which sums are kept */
#define V_PLANE_NODE_FLOATS 128 /* of a pixel: four channels a node, and one more node of zeros */
#define V_PLANE_RECORD      6
#define V_PLANE_CELLS       8 /* directions along x in a column of strata */
#define V_PLANE_POWERS      3 /* sums a cell: powers 0 to 2 of cosine^2 within a column */
#define V_PLANE_COS_NORMALS 0.939692621f /* 20 degrees */
#define V_PLANE_OFF_SHARE   0.2f         /* a neighbour off the plane, over its distance */

/* What a pixel shows to its neighbours. */
struct v_plane_source {
    float point[3];  /* camera space: right, up, back; from the eye */
    float pixel;     /* world size of a pixel there */
    float normal[3]; /* unit; 0: no receiver accepts it */
    int32_t cell;    /* of V_PLANE_CELLS, by its jitter along x */
};

/* The walk along one tangent. It has `reach` taps to both sides, one pixel a step along the major
 * screen axis, at the nearest pixel along the other axis. */
struct v_plane_walk {
    float tangent[3];
    float eta;       /* 1 / height of the reflector: shift over distance */
    float slant;     /* pixels of the minor axis a step */
    float falloff;   /* 1 / (2 sigma_x^2) */
    int32_t reach;   /* 0 .. V_PLANE_REACH_PX */
    int32_t along_x; /* whether x is the major axis */
};
_Static_assert(sizeof(struct v_plane_source) == 32 && sizeof(struct v_plane_walk) == 32,
               "two a cache line");

struct v_plane_field {
    int32_t width, height;
    const struct v_plane_source *sources;
    const struct v_plane_walk *walks[2]; /* along the first tangent (x) and the second (y) */
    uint32_t strata;                     /* l */
    uint32_t lanes;                      /* v_plane_lanes(l) */

    /* Of each cell, V_PLANE_CELLS of a column: V_PLANE_POWERS times V_PLANE_NODE_FLOATS numbers,
     * each four times. The weight at the node's shift of a sample with cosine^2 c is the first,
     * plus c times the second, plus c^2 times the third: the best fit of a parabola. 64-byte
     * aligned. */
    const float *ratios;
};

/* Returns the lanes of a row of strata: l rounded up to a multiple of 4. Lane row k + i is stratum
 * (i, k). */
static inline uint32_t v_plane_row_lanes(uint32_t l)
{
    return (l + 3) / 4 * 4;
}

/* Returns the lanes of all strata, rounded up to whole SIMD_LANES. */
static inline uint32_t v_plane_lanes(uint32_t l)
{
    return (l * v_plane_row_lanes(l) + SIMD_LANES - 1) / SIMD_LANES * SIMD_LANES;
}

/* Returns the floats of a sample record: V_PLANE_RECORD arrays of `lanes` numbers, which are 2 y z,
 * z^2, z^2 over that of the column (cosine^2), and radiance r, g, b. */
static inline size_t v_plane_record_floats(const struct v_plane_field *f)
{
    return V_PLANE_RECORD * (size_t)f->lanes;
}

/* Directions of l columns and l rows of strata of `count` adjacent pixels. Column i of pixel k lies
 * at i * stride + k. The ray is (side cosine, sine, height cosine). */
struct v_plane_strata {
    uint32_t l, count;
    size_t stride;
    float *height;        /* of columns */
    float *sine, *cosine; /* of rows */
};

/* Planes of samples of a row of pixels. Component c of stratum i of pixel k lies at (4 i + c) *
 * stride + k, as in struct patch. */
struct v_plane_planes {
    const float *first;
    size_t stride;
};

/* Slopes from the pixels' own samples; arrays of the field. */
struct v_plane_slopes_field {
    int32_t width;
    const int32_t *object; /* ids */
    const float *normal[3];
    const float *mean, *deviation;
};

struct v_plane_kernels {
    /* Fills the arrays from the pixels' jitters, with errors of 3e-6. */
    void (*strata)(const struct v_plane_strata *strata, const float *jitter_u,
                   const float *jitter_v);

    /* Computes weighted mean and deviation of a = pixel / max(height, least_px pixel) over the
     * samples, with weights z^2. The height is that of a sample's hit above the pixel's tangent
     * plane; a is 0 for a miss that brings light. Dark misses are left out; the mean is -1 where no
     * sample remains. */
    void (*slopes)(const struct v_plane_strata *strata, const struct v_plane_planes *planes,
                   const struct v_plane_source *sources, float least_px, float *mean,
                   float *deviation);

    /* Averages both over the 5 x 5 pixels around `count` pixels from `first` on. Pixels of the same
     * object within V_PLANE_COS_NORMALS whose mean is not negative take part; 0 where there are
     * none. Results are in the pixel's own size. */
    void (*average)(const struct v_plane_slopes_field *in, size_t first, uint32_t count,
                    float *mean, float *deviation);

    /* Writes records of the pixels k of a row with needs[k] & mask; radiance is multiplied by
     * scale. Lanes without a stratum stay as they are. */
    void (*records)(const struct v_plane_strata *strata, const struct v_plane_planes *planes,
                    uint32_t lanes, const uint8_t *needs, uint8_t mask, float scale, float *out);

    /* Runs passes 1a, 1b and 2a for `count` pixels of row y, columns x. The walk along the second
     * tangent weights every neighbour's samples at their exact shift and adds them into cells along
     * x; then the cells are summed at every node. rows[V_PLANE_REACH_PX + k] are the records of row
     * y + k, from the field's column 0 on. out holds node sums of the row, likewise. */
    void (*columns)(const struct v_plane_field *field, int32_t y, const int32_t *x, uint32_t count,
                    const float *const *rows, float *out);

    /* Runs pass 2b: the walk along the first tangent over node sums, at the shift between two
     * nodes. out[4 k] and on become radiance and weight of pixel k, not yet divided. */
    void (*rows)(const struct v_plane_field *field, int32_t y, const int32_t *x, uint32_t count,
                 const float *const *rows, float *out);
};

/* The kernels of each instruction set (kernels.h). AVX2 and AVX-512 give the same bits. */
extern const struct v_plane_kernels v_plane_kernels_sse42, v_plane_kernels_avx2,
    v_plane_kernels_avx512;
