#pragma once
/* The inner loops of the shadow filters, compiled once for each instruction set, and the arrays
 * they read.
 *
 * All arrays cover the field: a rectangle of the image with a margin of SHADOW_REACH_PX pixels
 * around all pixels that walk, so that no walk leaves it. Pixels outside of the image or of the
 * patch, without a surface or unlit have a zero normal, which no receiver accepts.
 *
 * Lengths along the light are counted in nodes: with r of coverage.h, a half-side is r/2 nodes,
 * node r is the light's centre, and of the 2r + 1 nodes over twice the light the last one is empty.
 * A kernel that keeps other sums with a sum (its denominator) treats them alike, operation by
 * operation, so that a constant field stays constant to the last bit. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"

#define SHADOW_REACH_PX    16                              /* farthest pixel of a walk */
#define SHADOW_TAPS        (2 * (2 * SHADOW_REACH_PX + 1)) /* most taps of a walk */
#define SHADOW_STRATA_MAX  16                              /* l; LIMIT_PLANE_STRATA_PER_AXIS */
#define SHADOW_PHASES      8                               /* weight rows between two nodes */
#define SHADOW_SUMS_MAX    448 /* most sums of a pixel: phases times lanes of l = 15, r = 14 */
#define SHADOW_NO_SPREAD   (-1e30f)
#define SHADOW_COS_NORMALS 0.939692621f /* 20 degrees */
#define SHADOW_PLANE_SHARE 0.35f        /* a neighbour off the plane, over its distance */
#define SHADOW_AXIS_CUT    4.5f         /* exponents beyond weigh 0 in the axis-aligned filter */

/* The walk along one light axis. It has `reach` taps to both sides, one pixel a step along the
 * major screen axis; between two pixels of the minor axis a tap is shared linearly. */
struct shadow_walk {
    float *step[2]; /* pixels, x and y; the larger is exactly 1 or -1 (or both 0 with reach 0) */
    float *falloff; /* 1 / (2 sigma_x^2) */
    int32_t *reach; /* 0 .. SHADOW_REACH_PX; 0 without wedge */
};

/* The field's pixels, one array for each number. SHADOW_PLANE_PAD elements past the end of points,
 * normals and tolerances are readable; normals are 0 there. */
#define SHADOW_PLANE_PAD 16
struct shadow_pixels {
    /* What the pixel shows to its neighbours: */
    float *point[3];  /* from the eye */
    float *normal[3]; /* unit; 0: no receiver accepts it */
    float *u[2];      /* receiver coordinates (x - C) . a_i / d1 */
    float *eta;       /* centre of its range of 1/slope; 0 without wedge */
    float
        *spread; /* half of that range; SHADOW_NO_SPREAD without wedge: every receiver accepts it */
    int32_t *slot;  /* of its node sums; -1: none */
    int32_t *phase; /* of its jitter along axis 1: floor(jitter * field->phases) */

    /* What the pixel reads its neighbours with: */
    float *distance;       /* d1: from the light's plane */
    float *plane_min;      /* least distance off the tangent plane that a neighbour may have */
    float *distance_most2; /* square of the world distance of the farthest neighbour */
    float *gamma[2];       /* change of G along axis i, per half-side */
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

    /* weights + ((row * (SHADOW_PHASES + 1)) + p) * window + k is I / cov (of mean 1) at (r/2 - p/8
     * - k) nodes from the light's centre for k < r, else 0. The factor 1 + gamma y is left out.
     * 64-byte aligned. */
    const float *weights;

    /* Of each slot: (2 r + 2) nodes of `lanes` sums, which are the numerators of the l rows, the
     * denominator, then zeros. The last node is zero. Each slot is 64-byte aligned. */
    float *columns;
    /* Of each slot: (2 r + 2) nodes of (numerator, denominator). The last node is zero. */
    float *rows;
};

static inline uint32_t shadow_nodes(const struct shadow_field *f)
{
    return 2 * f->scale + 2;
}

/* Returns the number of phases that a row's jitter is rounded to, so that every cell has the same
 * number of phases, row after row: 2 r / gcd(2 r, l). */
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

/* What the axis-aligned filter reads of the field's pixels. SHADOW_PLANE_PAD elements past the end
 * are readable. */
struct shadow_blur {
    const struct shadow_pixels *pixels; /* points, normals, tolerances */
    const float *seen;                  /* the values to blur */
    const float *refusal; /* a tap whose squared distance exceeds its own number refuses the
                             receiver; not below 0 */
    const float *falloff; /* 1 / (2 beta^2) */
    const int32_t *reach; /* pixels; 0: the pixel keeps its value */
};

/* A rectangle as receivers see it: eye-relative corners in the order of the outline (half_u to
 * half_v, counter-clockwise from the front), and what quadrature needs. */
struct shadow_rectangle {
    float centre[3];
    float axis[2][3]; /* unit */
    float half[2];    /* half-sides */
    float normal[3];  /* unit, in the direction of emission */
    float area;
    uint32_t profile; /* enum light_profile */
};

struct receiver_light; /* receiver.h */
struct wedge_shear;    /* wedge.h */
struct edge_field;     /* edge.h */

struct shadow_kernels {
    /* Computes E of plan.h without occlusion at `count` receivers, given as points from the eye and
     * unit normals. A zero normal gives 0. */
    void (*unoccluded)(const struct shadow_rectangle *light, uint32_t count,
                       const float *const point[3], const float *const normal[3], float *out);

    /* Sets u, distance, tolerances and gamma of `count` pixels from `first` on, from their points,
     * normals and depths (depth[i]). Sets all of these and the normal to 0 where a pixel is not
     * lit. */
    void (*place_receivers)(const struct receiver_light *light, uint32_t count, const float *depth,
                            size_t first, const struct shadow_pixels *out);

    /* Sets eta, spread, walks, widths and indices of weight rows of `count` pixels, whose 1/slope
     * is in least[pixel] .. most[pixel]. */
    void (*shear_receivers)(const struct wedge_shear *shear, const uint32_t *pixels, uint32_t count,
                            const float *most, const float *least, const struct shadow_pixels *out);

    /* Sets marks[q] to 1 for all pixels q that the walks of `count` pixels along an axis reach. */
    void (*mark_walks)(const struct shadow_field *field, uint32_t axis, const uint32_t *pixels,
                       uint32_t count, uint8_t *marks);

    /* Runs pass 1a: writes the columns of the slots of `count` pixels. jitter[k] is pixel k's along
     * axis 0. Bit b of seen[k * l + a] tells whether stratum (a, b) is seen; bit l is set.
     *
     *   g = i0 - (a + jitter) r/l,  i0 = ceil((a + jitter) r/l),  y_j = (1 - 2 (g + j)/r) of a half
     *   columns[i0 + j][b] += weight(g + j) (1 + gamma y_j) [seen], columns 0 .. l - 1 in order */
    void (*project_columns)(const struct shadow_field *field, const uint32_t *pixels,
                            uint32_t count, const float *jitter, const uint32_t *seen);

    /* Runs pass 1b, the walk along axis 0: out[k] becomes 2 r cells of (numerator, denominator)
     * of pixel k. Each accepted neighbour's columns are read at node r - eta Delta
     * nodes_per_length and added to the cells of its rows. l phases / 2 r phases, counted row by
     * row, make a cell. */
    void (*walk_columns)(const struct shadow_field *field, const uint32_t *pixels, uint32_t count,
                         float *out);

    /* Runs pass 2a: writes the rows of the slots from the cells of walk_columns. Cell c adds to
     * nodes i0 = c/2 + 1 and on with phase 6 (c even) or 2 (c odd). */
    void (*project_rows)(const struct shadow_field *field, const uint32_t *pixels, uint32_t count,
                         const float *cells);

    /* Runs pass 2b, the walk along axis 1 over rows: out[k] becomes (numerator, denominator) of
     * pixel k. */
    void (*walk_rows)(const struct shadow_field *field, const uint32_t *pixels, uint32_t count,
                      float *out);

    /* Blurs along one axis: out[i] becomes the weighted mean of `seen` around pixel first + i, i <
     * count, over pixels that lie `step` apart. */
    void (*blur)(const struct shadow_blur *planes, int32_t step, size_t first, uint32_t count,
                 float *out);

    /* Computes the own estimates of the seen fraction (strata.h) of `count` receivers at l x l
     * strata. jitter[axis][i] is receiver i's; bit k % 32 of bits[k / 32 * stride + i] tells
     * whether its stratum k is seen. */
    void (*estimate)(const struct shadow_rectangle *light, uint32_t l, uint32_t count,
                     const float *const point[3], const float *const normal[3],
                     const float *const jitter[2], const uint32_t *bits, size_t stride, float *out);

    /* Computes the seen fraction by a window along the shadow's edge (edge.h) around each of
     * `count` pixels whose filter is sigma_px wide; -1 where no edge can be found. */
    void (*filter_edges)(const struct edge_field *field, const uint32_t *pixels,
                         const float *sigma_px, uint32_t count, float *out);

    /* Sums a and b over the 5 x 5 pixels around pixel k, over compatible neighbours whose values
     * are not negative. out[k * 3] and on become their number, the sum of a and the sum of b,
     * added row by row from the top left. SHADOW_PLANE_PAD elements past the end of a and b are
     * readable. */
    void (*sum_slopes)(const struct shadow_field *field, const uint32_t *pixels, uint32_t count,
                       const float *a, const float *b, float *out);
};

/* The kernels of each instruction set (kernels.h). AVX2 and AVX-512 give the same bits of finite
 * numbers. */
extern const struct shadow_kernels shadow_kernels_sse42, shadow_kernels_avx2, shadow_kernels_avx512;
