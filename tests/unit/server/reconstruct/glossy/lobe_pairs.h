#pragma once
/* Pairs of random lobes side by side, each pair in a row of its own, and how alike a filter finds
 * the two of each. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/glossy/glossy_scene.h"

#include "server/reconstruct/glossy/glossy_field.h"

enum { PAIRS = 256 };

/* What pairs are drawn from. Normals turn from the view by up to `turn` and from each other by up
 * to `bend` radians; alpha is from a to b, evenly in its logarithm, and that of the second is up to
 * `times` as much. Anisotropic lobes are stretched by `stretch` to 1; 0: all are round. */
struct lobe_range {
    double turn, bend, a, b, times, stretch;
};

struct lobe {
    double n[3], v[3], r[3]; /* unit */
    double cosine, alpha;
    double stretch, tangent[3];
    double along[3], across[3]; /* unit, at right angles to r */
    double wide, thin;          /* standard deviations along and across */
};

struct lobe_pairs {
    struct lobe lobe[PAIRS][2];
    double similarity[PAIRS]; /* as the filter finds it; 0 where a lobe takes no part */
};

static inline double lobe_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void lobe_unit(double a[3])
{
    const double length = sqrt(lobe_dot(a, a));
    for (int k = 0; k < 3; k++) a[k] /= length;
}

/* Facets' offsets as they move what is mirrored, turned onto the axes of the ellipse they make. */
static inline void lobe_stretch(struct lobe *l)
{
    double u[3], w[3], p[2][3], gram[3] = {0};
    const double out = lobe_dot(l->tangent, l->n),
                 each[2] = {1 / sqrt(l->stretch), sqrt(l->stretch)};
    for (int k = 0; k < 3; k++) u[k] = l->tangent[k] - out * l->n[k];
    lobe_unit(u);
    for (int k = 0; k < 3; k++)
        w[k] = l->n[(k + 1) % 3] * u[(k + 2) % 3] - l->n[(k + 2) % 3] * u[(k + 1) % 3];
    for (int j = 0; j < 2; j++)
        for (int k = 0; k < 3; k++) {
            const double *d = j ? w : u;
            p[j][k] = l->wide * each[j] * (lobe_dot(l->v, d) * l->n[k] + l->cosine * d[k]);
        }
    for (int k = 0; k < 3; k++) {
        gram[0] += p[0][k] * p[0][k];
        gram[1] += p[0][k] * p[1][k];
        gram[2] += p[1][k] * p[1][k];
    }
    const double turn = 0.5 * atan2(2 * gram[1], gram[0] - gram[2]);
    for (int k = 0; k < 3; k++) {
        l->along[k] = cos(turn) * p[0][k] + sin(turn) * p[1][k];
        l->across[k] = cos(turn) * p[1][k] - sin(turn) * p[0][k];
    }
    l->wide = sqrt(lobe_dot(l->along, l->along));
    l->thin = sqrt(lobe_dot(l->across, l->across));
    lobe_unit(l->along);
    lobe_unit(l->across);
}

/* What follows from a lobe's normal, view and alpha, in double precision. */
static inline void lobe_finish(struct lobe *l)
{
    double t[3], sine;
    lobe_unit(l->n);
    l->cosine = lobe_dot(l->n, l->v);
    for (int k = 0; k < 3; k++) l->r[k] = 2 * l->cosine * l->n[k] - l->v[k];
    for (int k = 0; k < 3; k++) t[k] = l->v[k] - l->cosine * l->n[k];
    sine = sqrt(lobe_dot(t, t));
    for (int k = 0; k < 3; k++) t[k] /= sine;
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        l->along[k] = sine * l->n[k] + l->cosine * t[k];
        l->across[k] = l->n[a] * t[b] - l->n[b] * t[a];
    }
    lobe_unit(l->across);
    l->wide = 2 * l->alpha / sqrt(2.26);
    l->thin = l->wide * l->cosine;
    if (l->stretch > 0) lobe_stretch(l);
}

/* A unit vector up to `most` radians from unit a. */
static inline void lobe_near(const double a[3], double most, uint32_t *random, double out[3])
{
    double off[3] = {floor_random(random) - 0.5, floor_random(random) - 0.5,
                     floor_random(random) - 0.5};
    const double along = lobe_dot(off, a);
    for (int k = 0; k < 3; k++) off[k] -= along * a[k];
    lobe_unit(off);
    const double angle = most * floor_random(random);
    for (int k = 0; k < 3; k++) out[k] = cos(angle) * a[k] + sin(angle) * off[k];
}

/* Draws a pair at pixels i and i + 1 of the patch. */
static inline void lobe_draw(const struct plan *plan, struct patch *p, int32_t y,
                             const struct lobe_range *range, uint32_t *random)
{
    const size_t i = patch_pixel(p, 0, y);
    float at[3], d[3];
    double v[3], first[3], n[3];
    plan_camera_ray(plan, 0.5f, (float)y + 0.5f, at, d);
    for (int k = 0; k < 3; k++) v[k] = -(double)d[k];
    lobe_unit(v);
    lobe_near(v, range->turn, random, first);
    lobe_near(first, range->bend, random, n);
    const double least = log(range->a), most = log(range->b);
    const double alpha = exp(least + (most - least) * floor_random(random));
    for (int k = 0; k < 3; k++) {
        p->normal[k][i] = (float)first[k];
        p->normal[k][i + 1] = (float)n[k];
    }
    for (size_t j = i; j < i + 2; j++) {
        p->depth[j] = 2.0f;
        p->id[j] = 1;
        p->glossy_nearness[j] = 3.0f; /* which lobes as published do not know */
        p->glossy_weight[j] = 1.0f;
        for (int c = 0; c < 3; c++) p->reflectance[c][j] = 0.5f;
    }
    const double other = exp(log(range->times) * (2.0 * floor_random(random) - 1.0));
    p->glossy_alpha[i] = (float)alpha;
    p->glossy_alpha[i + 1] = (float)fmin(alpha * other, 1.0);
    for (size_t j = 0; j < 2 && range->stretch > 0; j++) {
        double tangent[3];
        lobe_near(j ? n : first, 1.5, random, tangent); /* not at right angles, as it was rounded */
        p->glossy_stretch[i + j] =
            (float)(range->stretch + (1 - range->stretch) * floor_random(random));
        for (int k = 0; k < 3; k++) p->glossy_tangent[k][i + j] = (float)tangent[k];
    }
}

/* The weight of the second lobe for the first, of which its own is 1: what is left of each alone.
 */
static inline void lobe_weigh(struct glossy_neighbourhood *around, struct lobe_pairs *pairs)
{
    const struct glossy_rule rule = {.similarity = 1.0f, .footprint = 1e30f, .reach = 1};
    const struct glossy_kernels *kernels = KERNELS_BEST(glossy_kernels);
    float *plane = calloc(around->area, sizeof *plane);
    for (size_t i = 0; i < around->area; i++) plane[i] = 1e30f;
    around->field.near_plane = plane;
    for (int32_t y = 0; y < PAIRS; y++) {
        const size_t i = glossy_neighbourhood_index(around, 0, y);
        const struct glossy_run run =
            glossy_neighbourhood_run(around, around->rect, y, true, rule.reach);
        around->channel[0][i] = around->channel[1][i + 1] = 1.0f;
        around->channel[1][i] = around->channel[0][i + 1] = 0.0f;
        kernels->spread[around->shape](&around->field, &rule, &run, 2,
                                       (const float *const *)around->channel, around->between);
        pairs->similarity[y] = (double)around->between[1][i] / (double)around->between[0][i];
        for (int k = 0; k < 3; k++) {
            for (size_t j = 0; j < 2; j++) {
                pairs->lobe[y][j].n[k] = around->field.normal[k][i + j];
                pairs->lobe[y][j].v[k] = -around->field.point[k][i + j];
            }
        }
    }
    free(plane);
}

static inline void lobe_pairs_make(uint32_t filter, const struct lobe_range *range, uint32_t seed,
                                   struct lobe_pairs *out)
{
    struct plan plan;
    struct glossy_neighbourhood around;
    struct patch *patch;
    floor_plan(&plan, PAIRS, filter, 2);
    plan.camera.half_width = plan.camera.half_height =
        1e-5f; /* all pixels are seen from one side */
    const struct rect rect = {0, 0, 2, PAIRS};
    if (range->stretch > 0) plan.planes |= PLANES_GLOSSY_AXES;
    assert_int_equal(patch_create(&plan, rect, &patch), 0);
    for (int32_t y = 0; y < PAIRS; y++) lobe_draw(&plan, patch, y, range, &seed);
    assert_int_equal(glossy_neighbourhood_create(&plan, patch, rect, 1, false, &around), 0);
    lobe_weigh(&around, out);
    for (int32_t y = 0; y < PAIRS; y++)
        for (size_t j = 0; j < 2; j++) {
            struct lobe *l = &out->lobe[y][j];
            const size_t i = patch_pixel(patch, 0, y) + j;
            l->alpha = fmax((double)patch->glossy_alpha[i], 0.002);
            l->stretch = range->stretch > 0 ? (double)patch->glossy_stretch[i] : 0;
            for (int k = 0; k < 3 && l->stretch > 0; k++)
                l->tangent[k] = (double)patch->glossy_tangent[k][i];
            lobe_unit(l->v);
            lobe_finish(l);
        }
    glossy_neighbourhood_fini(&around);
    patch_destroy(&patch);
}
