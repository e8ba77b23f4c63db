#pragma once
/* Cells over the sphere of directions, fine where lobes are: above and below the surface each a
 * polar grid about the direction in which a smooth surface would send light, its rings narrowing
 * towards that axis. Density and reflectance are integrated over each cell to below the noise of
 * the samples that they are compared with. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "worker/shade/bsdf.h"

#define GRID_RINGS   32
#define GRID_SECTORS 24
#define GRID_CELLS   (2 * GRID_RINGS * GRID_SECTORS)
#define GRID_GAUSS   12  /* points across a smooth cell */
#define GRID_LATTICE 192 /* points across any cell, at most */

struct shade_grid {
    const struct bsdf *bsdf;
    float wo[3];
    double narrowing; /* ring edges are at 2 (i / GRID_RINGS)^narrowing = 1 - cosine to the axis */
    double axis[2][3][3]; /* above, below: two tangents and the axis */
    double pdf[GRID_CELLS];
    double reflected, passed; /* f |cos| integrated, of the mean colour: wi above, below */
    double pdf_sum;
};

static inline void grid_frame(const double axis[3], double out[3][3])
{
    const double *n = axis, sign = n[2] >= 0.0 ? 1.0 : -1.0, a = -1.0 / (sign + n[2]);
    const double b = n[0] * n[1] * a;
    const double frame[3][3] = {{1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]},
                                {b, sign + n[1] * n[1] * a, -n[1]},
                                {n[0], n[1], n[2]}};
    memcpy(out, frame, sizeof frame);
}

/* Where a smooth surface transmits: straight on or by Snell's law; along the surface at total
 * reflection. */
static inline void grid_straight(const struct bsdf *b, const float wo[3], double out[3])
{
    const bool bent = b->model == BSDF_GLTF && !b->thin && b->ior > 0.0f;
    const double inverse = bent ? 1.0 / (double)b->ior : 1.0;
    const double x = -(double)wo[0] * inverse, y = -(double)wo[1] * inverse;
    const double s2 = x * x + y * y, scale = s2 < 1.0 ? 1.0 : 1.0 / sqrt(s2);
    out[0] = x * scale;
    out[1] = y * scale;
    out[2] = s2 < 1.0 ? -sqrt(1.0 - s2) : 0.0;
}

static inline int grid_cell_of(const struct shade_grid *g, const float wi[3])
{
    const int side = wi[2] < 0.0f;
    const double(*a)[3] = g->axis[side];
    double x = 0.0, y = 0.0, depth = 0.0;
    for (int k = 0; k < 3; k++) {
        const double w = (double)wi[k], d = w - a[2][k];
        x += w * a[0][k];
        y += w * a[1][k];
        depth += 0.5 * d * d;
    }
    const double t = pow(fmin(0.5 * depth, 1.0), 1.0 / g->narrowing);
    const double turn = atan2(y, x) / (2.0 * M_PI);
    int ring = (int)(t * GRID_RINGS), sector = (int)((turn - floor(turn)) * GRID_SECTORS);
    if (ring >= GRID_RINGS) ring = GRID_RINGS - 1;
    if (sector >= GRID_SECTORS) sector = GRID_SECTORS - 1;
    return (side * GRID_RINGS + ring) * GRID_SECTORS + sector;
}

static inline double grid_value(const struct bsdf *b, const struct bsdf_value *v)
{
    double sum = 0.0;
    for (int k = 0; k < 3; k++) sum += (double)(b->albedo[k] * v->diffuse + v->specular[k]);
    return sum / 3.0;
}

/* Gauss and Legendre's points and weights on [0, 1], by Newton's method on the polynomial. */
static inline void grid_gauss(int n, double *x, double *w)
{
    for (int i = 0; i < n; i++) {
        double z = cos(M_PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
        for (int step = 0; step < 50; step++) {
            double p = 1.0, before = 0.0;
            for (int k = 1; k <= n; k++) {
                const double next = ((2.0 * k - 1.0) * z * p - (k - 1.0) * before) / k;
                before = p;
                p = next;
            }
            slope = n * (z * p - before) / (z * z - 1.0);
            z -= p / slope;
        }
        x[i] = 0.5 + 0.5 * z;
        w[i] = 1.0 / ((1.0 - z * z) * slope * slope);
    }
}

struct grid_sum {
    double pdf, light;
};

/* Adds density and f |cos| of one point, ring and sector running from 0 to 1, so that weights of a
 * cell sum to 1. */
static inline void grid_point(const struct shade_grid *g, int side, double ring, double sector,
                              double weight, struct grid_sum *sum)
{
    const double depth = 2.0 * pow(ring, g->narrowing), r = sqrt(fmax(depth * (2.0 - depth), 0.0));
    const double angle = 2.0 * M_PI * sector;
    const double x = r * cos(angle), y = r * sin(angle), z = 1.0 - depth;
    const double(*a)[3] = g->axis[side];
    float wi[3];
    for (int k = 0; k < 3; k++) wi[k] = (float)(x * a[0][k] + y * a[1][k] + z * a[2][k]);
    if ((wi[2] < 0.0f) != side) return;
    struct bsdf_value v;
    bsdf_evaluate(g->bsdf, g->wo, wi, &v);
    const double slope = g->narrowing * depth / ring; /* d(depth) / d(ring) */
    const double area = weight * slope * 2.0 * M_PI / ((double)GRID_RINGS * GRID_SECTORS);
    sum->pdf += area * (double)v.pdf;
    sum->light += area * grid_value(g->bsdf, &v) * fabs((double)wi[2]);
}

/* What smooth cells want. */
static inline struct grid_sum grid_by_gauss(const struct shade_grid *g, int cell, int n,
                                            const double *x, const double *w)
{
    const int sector = cell % GRID_SECTORS, row = cell / GRID_SECTORS;
    struct grid_sum sum = {0};
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            grid_point(g, row / GRID_RINGS, (row % GRID_RINGS + x[i]) / GRID_RINGS,
                       (sector + x[j]) / GRID_SECTORS, w[i] * w[j], &sum);
    return sum;
}

/* What cells with an edge in them want: rows shifted against each other, so that an edge along
 * them, such as the horizon, falls between points at all fractions. */
static inline double grid_shift(int row)
{
    const double shift = (row + 0.5) * 0.61803398874989485;
    return shift - floor(shift);
}

static inline struct grid_sum grid_by_lattice(const struct shade_grid *g, int cell, int n)
{
    const int sector = cell % GRID_SECTORS, row = cell / GRID_SECTORS;
    struct grid_sum sum = {0};
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            grid_point(
                g, row / GRID_RINGS, (row % GRID_RINGS + (i + grid_shift(j)) / n) / GRID_RINGS,
                (sector + (j + grid_shift(i)) / n) / GRID_SECTORS, 1.0 / ((double)n * n), &sum);
    return sum;
}

/* Whether what is left of errors drowns in the noise of samples. */
static inline bool grid_agrees(struct grid_sum a, struct grid_sum b, int samples)
{
    return fabs(a.pdf - b.pdf) * samples <= 0.02 * sqrt(fmax(b.pdf * samples, 1.0)) &&
           fabs(a.light - b.light) <= 1e-6 + 1e-3 * b.light;
}

static inline struct grid_sum grid_integrate(const struct shade_grid *g, int cell, int samples)
{
    static double x[2][GRID_GAUSS], w[2][GRID_GAUSS];
    if (x[0][0] <= 0.0) {
        grid_gauss(GRID_GAUSS / 2, x[0], w[0]);
        grid_gauss(GRID_GAUSS, x[1], w[1]);
    }
    struct grid_sum coarse = grid_by_gauss(g, cell, GRID_GAUSS / 2, x[0], w[0]);
    struct grid_sum fine = grid_by_gauss(g, cell, GRID_GAUSS, x[1], w[1]);
    if (grid_agrees(coarse, fine, samples)) return fine;
    for (int n = 24; n <= GRID_LATTICE; n *= 2) {
        coarse = fine;
        fine = grid_by_lattice(g, cell, n);
        if (grid_agrees(coarse, fine, samples)) break;
    }
    return fine;
}

/* Integrates all cells; errors are small against the noise of `samples` samples. */
static inline void grid_init(struct shade_grid *g, const struct bsdf *b, const float wo[3],
                             double narrowing, int samples)
{
    memset(g, 0, sizeof *g);
    g->bsdf = b;
    g->narrowing = narrowing;
    memcpy(g->wo, wo, sizeof g->wo);
    const double mirror[3] = {-(double)wo[0], -(double)wo[1], (double)wo[2]};
    double straight[3];
    grid_straight(b, wo, straight);
    grid_frame(mirror, g->axis[0]);
    grid_frame(straight, g->axis[1]);
    for (int cell = 0; cell < GRID_CELLS; cell++) {
        const struct grid_sum sum = grid_integrate(g, cell, samples);
        g->pdf[cell] = sum.pdf;
        g->pdf_sum += sum.pdf;
        *(cell < GRID_CELLS / 2 ? &g->reflected : &g->passed) += sum.light;
    }
}
