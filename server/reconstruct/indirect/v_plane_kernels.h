#pragma once
/* The inner loops of the sheared filter of indirect light, once for each instruction set, and the
 * arrays they read.
 *
 * A sample of a bounce ray d = (x, y, z) around the normal has v = (x/z, y/z). Seen from a point
 * whose ray to the same place passes through v - s, it weighs by the ratio of the cosines to the
 * fourth power (docs/reconstruction.md, V-plane filter); for a shift along y alone that is
 *
 *   gamma(v - s) / gamma(v) = 1 / (1 - 2 y z s + z^2 s^2)^2,
 *
 * which has no pole: for |s| <= 1 it is between 0.14 and 6.9.
 *
 * Arrays of the field are width * height, row by row, with room around whatever walks, so that no
 * walk can leave it. Pixels that show nothing, or where nothing was measured, have a zero normal:
 * no neighbour takes them. Weights travel as a fourth channel, treated operation by operation like
 * radiance: where all radiance is 1 (or any power of two), so is the outcome, to the last bit. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"

#define V_PLANE_REACH_PX    16  /* farthest pixel of a walk */
#define V_PLANE_SLOPES_PX   2   /* around a pixel, of the same object, that its slopes come from */
#define V_PLANE_STRATA_MAX  16  /* l; LIMIT_PLANE_STRATA_PER_AXIS */
#define V_PLANE_NODES       31  /* shifts along x, from -1 to 1, that sums are kept for */
#define V_PLANE_NODE_FLOATS 128 /* of a pixel: four channels a node, and a node more, of zeros */
#define V_PLANE_LANES       16
#define V_PLANE_RECORD      6
#define V_PLANE_CELLS       8 /* directions along x that a column of strata is cut into */
#define V_PLANE_POWERS      3 /* of a sample's cosine^2 within its column, 1 included: sums a cell */
#define V_PLANE_COS_NORMALS 0.939692621f /* 20 degrees */
#define V_PLANE_OFF_SHARE   0.2f         /* of the distance a neighbour may be off the plane */

/* What a pixel shows to its neighbours. */
struct v_plane_source {
    float point[3];  /* camera space: right, up, back; from the eye */
    float pixel;     /* world size of a pixel there */
    float normal[3]; /* unit, or 0: nobody takes it */
    int32_t cell;    /* which of V_PLANE_CELLS its jitter along x falls into */
};

/* The walk along one tangent: `reach` taps to both sides, one pixel a step along the major screen
 * axis, the nearest pixel along the other. */
struct v_plane_walk {
    float tangent[3];
    float eta;       /* 1 / height of what shines there: shift over distance */
    float slant;     /* pixels of the minor axis a step */
    float falloff;   /* 1 / (2 sigma_x^2) */
    int32_t reach;   /* 0 .. V_PLANE_REACH_PX */
    int32_t along_x; /* is x the major axis? */
};
_Static_assert(sizeof(struct v_plane_source) == 32 && sizeof(struct v_plane_walk) == 32,
               "two a cache line");

struct v_plane_field {
    int32_t width, height;
    const struct v_plane_source *sources;
    const struct v_plane_walk *walks[2]; /* along the first tangent (x) and the second (y) */
    uint32_t strata;                     /* l */
    uint32_t lanes;                      /* v_plane_lanes(l) */

    /* Of each cell, V_PLANE_CELLS of a column, V_PLANE_POWERS times V_PLANE_NODE_FLOATS, each
     * number four times: at the node's shift a sample of cosine^2 c weighs the first, plus c times
     * the second, plus c^2 times the third, as nearly as a parabola can. 64-byte aligned. */
    const float *ratios;
};

/* Lanes of a row of strata: l rounded up to fours. Lane row k + i is stratum (i, k). */
static inline uint32_t v_plane_row_lanes(uint32_t l)
{
    return (l + 3) / 4 * 4;
}

/* Lanes of all strata, rounded up to whole V_PLANE_LANES. */
static inline uint32_t v_plane_lanes(uint32_t l)
{
    return (l * v_plane_row_lanes(l) + V_PLANE_LANES - 1) / V_PLANE_LANES * V_PLANE_LANES;
}

/* A sample record: V_PLANE_RECORD arrays of `lanes` numbers: 2 y z, z^2, z^2 over that of the
 * column (cosine^2), radiance r, g, b. */
static inline size_t v_plane_record_floats(const struct v_plane_field *f)
{
    return V_PLANE_RECORD * (size_t)f->lanes;
}

/* Directions of l columns and l rows of strata of `count` pixels side by side: what column i of
 * pixel k is lies at i * stride + k. The ray is (side cosine, sine, height cosine). */
struct v_plane_strata {
    uint32_t l, count;
    size_t stride;
    float *height;        /* of columns */
    float *sine, *cosine; /* of rows */
};

/* Planes of samples of a row of pixels: stratum i's component c of pixel k at (4 i + c) * stride +
 * k, as in struct patch. */
struct v_plane_planes {
    const float *first;
    size_t stride;
};

/* What pixels' own samples say of heights; arrays of the field. */
struct v_plane_slopes_field {
    int32_t width;
    const int32_t *object; /* ids */
    const float *normal[3];
    const float *mean, *deviation;
};

struct v_plane_kernels {
    /* Fills the arrays from the pixels' jitters; errors of 3e-6. */
    void (*strata)(const struct v_plane_strata *strata, const float *jitter_u,
                   const float *jitter_v);

    /* Weighted mean and deviation of a = pixel / max(height, least_px pixel) over the samples,
     * height that of what a sample met above the pixel's tangent plane, 0 for misses that bring
     * light; weights z^2. Dark misses do not count; mean -1: no sample does. */
    void (*slopes)(const struct v_plane_strata *strata, const struct v_plane_planes *planes,
                   const struct v_plane_source *sources, float least_px, float *mean,
                   float *deviation);

    /* Means of both over the 5 x 5 pixels around `count` pixels from `first` on, of those of the
     * same object and V_PLANE_COS_NORMALS whose mean is not negative; 0 where there are none. In
     * lengths of each pixel's own size. */
    void (*average)(const struct v_plane_slopes_field *in, size_t first, uint32_t count,
                    float *mean, float *deviation);

    /* Records of the pixels k of a row with needs[k] & mask; radiance is multiplied by scale. Lanes
     * without a stratum stay as they are. */
    void (*records)(const struct v_plane_strata *strata, const struct v_plane_planes *planes,
                    uint32_t lanes, const uint8_t *needs, uint8_t mask, float scale, float *out);

    /* Passes 1a, 1b and 2a of `count` pixels of row y, columns x: the walk along the second
     * tangent, every neighbour's samples weighed at their exact shift and added into cells along x;
     * then the cells' sums at every node. rows[V_PLANE_REACH_PX + k]: the records of row y + k,
     * from the field's column 0 on. out: node sums of the row, likewise. */
    void (*columns)(const struct v_plane_field *field, int32_t y, const int32_t *x, uint32_t count,
                    const float *const *rows, float *out);

    /* Pass 2b: the walk along the first tangent over node sums, at the shift between two nodes.
     * out[4 k]: radiance and weight of pixel k, not yet divided. */
    void (*rows)(const struct v_plane_field *field, int32_t y, const int32_t *x, uint32_t count,
                 const float *const *rows, float *out);
};

/* One for each instruction set (kernels.h). AVX2 and AVX-512 give the same bits. */
extern const struct v_plane_kernels v_plane_kernels_sse42, v_plane_kernels_avx2,
    v_plane_kernels_avx512;
