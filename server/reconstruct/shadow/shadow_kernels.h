#pragma once
/* The inner loops of the shadow filters, once for each instruction set, and the arrays they read.
 *
 * All arrays are of the field: a rectangle of the image with a margin of SHADOW_REACH_PX pixels
 * around whatever walks, so that no walk can leave it. Pixels that show nothing (outside of the
 * image or of the patch, no surface, not lit) have a zero normal, which no neighbour takes.
 *
 * Lengths along the light are counted in nodes: with r of coverage.h, a half-side is r/2 nodes,
 * node r is the light's centre, and of the 2r + 1 nodes over twice the light the last one holds
 * nothing. A kernel that keeps other sums with a sum (its denominator) treats them alike, operation
 * by operation: a constant field must come out constant to the last bit. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"

#define SHADOW_REACH_PX    16                              /* farthest pixel of a walk */
#define SHADOW_TAPS        (2 * (2 * SHADOW_REACH_PX + 1)) /* neighbours of a walk, at most */
#define SHADOW_STRATA_MAX  16                              /* l; LIMIT_PLANE_STRATA_PER_AXIS */
#define SHADOW_PHASES      8                               /* weight rows between two nodes */
#define SHADOW_SUMS_MAX    448 /* a pixel's sums, at most: phases times lanes of l = 15, r = 14 */
#define SHADOW_NO_SPREAD   (-1e30f)
#define SHADOW_COS_NORMALS 0.939692621f /* 20 degrees */
#define SHADOW_PLANE_SHARE 0.35f        /* of the distance a neighbour may be off the plane */
#define SHADOW_AXIS_CUT    4.5f         /* axis-aligned: exponents beyond count nothing */

/* The walk along one light axis: `reach` taps to both sides, one pixel a step along the major
 * screen axis; between the two pixels of the minor axis a tap is shared out linearly. */
struct shadow_walk {
    float *step[2]; /* pixels, x and y; the larger is exactly 1 or -1 (or both 0 with reach 0) */
    float *falloff; /* 1 / (2 sigma_x^2) */
    int32_t *reach; /* 0 .. SHADOW_REACH_PX; 0 without wedge */
};

/* The field's pixels, an array a number. Of points, normals and tolerances SHADOW_PLANE_PAD more
 * than there are pixels may be read: normals are 0 there. */
#define SHADOW_PLANE_PAD 16
struct shadow_pixels {
    /* What a pixel shows to its neighbours. */
    float *point[3];  /* from the eye */
    float *normal[3]; /* unit, or 0: nobody takes it */
    float *u[2];      /* receiver coordinates (x - C) . a_i / d1 */
    float *eta;       /* centre of its range of 1/slope; 0 without wedge */
    float *spread;    /* half of that range; SHADOW_NO_SPREAD without wedge: refused by nobody */
    int32_t *slot;    /* of its node sums; -1: has none */
    int32_t *phase;   /* of its jitter along axis 1: floor(jitter * field->phases) */

    /* What it gathers with. */
    float *distance;       /* d1: from the light's plane */
    float *plane_least;    /* a neighbour may be off the tangent plane by that anyway */
    float *distance_most2; /* squared world distance of the farthest neighbour */
    float *gamma[2];       /* slope of G along axis i, a half-side */
    int32_t *weights[2];   /* row of field->weights along axis i */
    float *width_px;       /* sigma_x in pixels, geometric mean of both; 0 without wedge */
    struct shadow_walk walk[2];
};

struct shadow_field {
    int32_t width, height;
    const struct shadow_pixels *pixels; /* width * height, row by row; its arrays are not const */
    uint32_t strata;                    /* l */
    uint32_t scale;                     /* r = coverage_scale(l): nodes 2 r + 1, cells 2 r */
    uint32_t window;                    /* r rounded up to a multiple of 8 */
    uint32_t lanes;                     /* l + 1 rounded up to a multiple of 4 */
    uint32_t phases;                    /* of y2 in a row: shadow_phases(l, r) */
    float nodes_per_length[2];          /* r / (2 L_i) */
    float refusal[2];                   /* 1.5 sigma_y,i */

    /* weights + ((row * (SHADOW_PHASES + 1)) + p) * window + k: I / cov (of mean 1) at (r/2 - p/8 -
     * k) nodes from the light's centre, k < r; 0 for k >= r. The factor 1 + gamma y is not in it.
     * 64-byte aligned. */
    const float *weights;

    /* Of each slot, 64-byte aligned as a whole: (2 r + 2) nodes of `lanes` sums: numerators of the
     * l rows, then the denominator, then zeros. The last node is zero. */
    float *columns;
    /* Of each slot: (2 r + 2) nodes of (numerator, denominator); the last node is zero. */
    float *rows;
};

static inline uint32_t shadow_nodes(const struct shadow_field *f)
{
    return 2 * f->scale + 2;
}

/* Into how many phases a row's jitter falls, so that phases, row after row, make up cells of equal
 * numbers of them: 2 r / gcd(2 r, l). */
static inline uint32_t shadow_phases(uint32_t strata, uint32_t scale)
{
    uint32_t a = 2 * scale, b = strata;
    while (b > 0) {
        const uint32_t rest = a % b;
        a = b;
        b = rest;
    }
    return 2 * scale / a;
}

/* What the axis-aligned filter reads of the field's pixels; SHADOW_PLANE_PAD more may be read. */
struct shadow_blur {
    const struct shadow_pixels *pixels; /* points, normals, tolerances */
    const float *seen;                  /* to blur */
    const float *refusal;               /* farther neighbours (squared) refuse it; not below 0 */
    const float *falloff;               /* 1 / (2 beta^2) */
    const int32_t *reach;               /* pixels; 0: keeps its own value */
};

/* Rectangle seen from receivers: eye-relative corners in the order of the outline (half_u to
 * half_v, seen from the front counter-clockwise), and what quadrature needs. */
struct shadow_rectangle {
    float centre[3];
    float axis[2][3]; /* unit */
    float half[2];    /* half-sides */
    float normal[3];  /* unit, the way the light goes */
    float area;
    uint32_t profile; /* enum light_profile */
};

struct receiver_light; /* receiver.h */
struct wedge_shear;    /* wedge.h */
struct edge_field;     /* edge.h */

struct shadow_kernels {
    /* E of plan.h without occlusion, to `count` receivers (points from the eye, unit or zero
     * normals: zero gives 0). */
    void (*unoccluded)(const struct shadow_rectangle *light, uint32_t count,
                       const float *const point[3], const float *const normal[3], float *out);

    /* Sets u, distance, tolerances and gamma of `count` pixels from `first` on, whose points,
     * depths (depth[i]) and normals are there; of those that are not lit all of it and the normal
     * to 0. */
    void (*place_receivers)(const struct receiver_light *light, uint32_t count, const float *depth,
                            size_t first, const struct shadow_pixels *out);

    /* Sets eta, spread, walks, widths and numbers of weight rows of `count` pixels, whose 1/slope
     * goes from least[pixel] to most[pixel]. */
    void (*shear_receivers)(const struct wedge_shear *shear, const uint32_t *pixels, uint32_t count,
                            const float *most, const float *least, const struct shadow_pixels *out);

    /* Sets marks[q] to 1 for all pixels q that the walks of `count` pixels along an axis reach. */
    void (*mark_walks)(const struct shadow_field *field, uint32_t axis, const uint32_t *pixels,
                       uint32_t count, uint8_t *marks);

    /* Pass 1a: writes the columns of the slots of `count` pixels. Of pixel k: jitter[k] along axis
     * 0, and seen[k * l + a]: bit b: stratum (a, b) is seen; bit l: set.
     *   g = i0 - (a + jitter) r/l,  i0 = ceil((a + jitter) r/l),  y_j = (1 - 2 (g + j)/r) of a half
     *   columns[i0 + j][b] += weight(g + j) (1 + gamma y_j) [seen], columns 0 .. l - 1 in order */
    void (*project_columns)(const struct shadow_field *field, const uint32_t *pixels,
                            uint32_t count, const float *jitter, const uint32_t *seen);

    /* Pass 1b: out[k]: 2 r cells of (numerator, denominator) of pixel k. The walk along axis 0;
     * each accepted neighbour's columns, read at node r - eta Delta nodes_per_length, go to the
     * cells of its rows: l phases / 2 r phases, counted row by row, make a cell. */
    void (*walk_columns)(const struct shadow_field *field, const uint32_t *pixels, uint32_t count,
                         float *out);

    /* Pass 2a: writes the rows of the slots from what walk_columns gave: cell c adds to nodes
     * i0 = c/2 + 1 and on with phase 6 (c even) or 2 (c odd). */
    void (*project_rows)(const struct shadow_field *field, const uint32_t *pixels, uint32_t count,
                         const float *cells);

    /* Pass 2b: out[k]: (numerator, denominator) of pixel k. The walk along axis 1 over rows. */
    void (*walk_rows)(const struct shadow_field *field, const uint32_t *pixels, uint32_t count,
                      float *out);

    /* Axis-aligned: out[i]: the mean of `seen` around pixel first + i, i < count, over pixels that
     * lie `step` apart. */
    void (*blur)(const struct shadow_blur *planes, int32_t step, size_t first, uint32_t count,
                 float *out);

    /* Own estimates of the seen fraction (strata.h) of `count` receivers at l x l strata. Of
     * receiver i: jitter[axis][i]; bit k % 32 of bits[k / 32 * stride + i]: stratum k is seen. */
    void (*estimate)(const struct shadow_rectangle *light, uint32_t l, uint32_t count,
                     const float *const point[3], const float *const normal[3],
                     const float *const jitter[2], const uint32_t *bits, size_t stride, float *out);

    /* edge.h: the seen fraction by a window along the edge around each of `count` pixels whose
     * filter is sigma_px wide; -1 where no edge can be told. */
    void (*filter_edges)(const struct edge_field *field, const uint32_t *pixels,
                         const float *sigma_px, uint32_t count, float *out);

    /* Sums over the 5 x 5 pixels around pixel k, of those compatible neighbours whose values are
     * not negative: out[k * 3]: how many, sum of a, sum of b. Row by row, from the top left.
     * SHADOW_PLANE_PAD more of a and b may be read. */
    void (*sum_slopes)(const struct shadow_field *field, const uint32_t *pixels, uint32_t count,
                       const float *a, const float *b, float *out);
};

/* One for each instruction set (kernels.h). AVX2 and AVX-512 give the same bits of finite numbers.
 */
extern const struct shadow_kernels shadow_kernels_sse42, shadow_kernels_avx2, shadow_kernels_avx512;
