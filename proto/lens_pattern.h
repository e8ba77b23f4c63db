#pragma once
/* The positions of lens samples. Points u lie on an aperture of radius 1, with u[0] to the right as
 * image columns run and u[1] down as image rows do. The light field of a pixel (x, y) with slope s,
 * in pixels per unit of the lens (samples.h), then shows at (x, u) what a pinhole shows at x + s u.
 *
 * A ray of proto/plan.h's lens starts at eye + aperture_radius * (u[0] right - u[1] up).
 *
 * A pixel's l x l points are l rows of equal area, with all of a row's points on one line, and l
 * points of equal distances on each. One jitter per pixel places them all (docs/reconstruction.md,
 * Lens samples), uniformly over the aperture in the mean over jitters. */
#include <math.h>
#include <string.h>

#include "proto/plan.h"

/* A round aperture has no corners; one of straight blades is bands between the heights of its
 * corners, each a trapezoid. */
struct lens_aperture {
    uint32_t bands; /* 0: round */
    float height[LIMIT_LENS_BLADES];
    float left[LIMIT_LENS_BLADES], right[LIMIT_LENS_BLADES]; /* ends of the chord at that height */
    float below[LIMIT_LENS_BLADES];                          /* share of the area up to it */
    float area;
};

void lens_aperture_init(const struct plan_camera *camera, struct lens_aperture *out);

/* Returns the height u[1] below which (towards -1) `share`, 0 .. 1, of the area lies. The error is
 * 2e-6. */
float lens_aperture_height(const struct lens_aperture *a, float share);

/* Computes the ends of the chord at a height. They are the same where there is none. */
void lens_aperture_chord(const struct lens_aperture *a, float height, float *left, float *right);

/* Computes line i of l of `count` pixels with the jitters across[]: its height, and the part of
 * it that lies in the aperture. */
void lens_aperture_lines(const struct lens_aperture *a, uint32_t l, uint32_t i, uint32_t count,
                         const float *across, float *height, float *left, float *length);

/* Returns x^(2/3) for 0 <= x <= 1, by three steps of Newton's method. Its guess divides the
 * exponent by 3. */
static inline float lens_two_thirds(float x)
{
    uint32_t bits;
    float root;
    memcpy(&bits, &x, sizeof bits);
    bits = bits / 3 + 0x2a514067u;
    memcpy(&root, &bits, sizeof root);
    for (int k = 0; k < 3; k++) /* the guess is above 1e-13, and so is all that follows */
        root = (2.0f * root + x / (root * root)) * (1.0f / 3.0f);
    return root * root;
}

/* Does lens_aperture_height for a disc. A cap of a disc whose depth is h holds (4 sqrt2 / 3 pi)
 * h^(3/2) (1 - 3 h / 20 - ...) of it. The depth is q = (3 pi / (4 sqrt2) share)^(2/3) times a fit
 * in q. */
static inline float lens_disc_height(float share)
{
    const float least = share < 0.5f ? share : 1.0f - share;
    const float q = lens_two_thirds(1.6660811f * (least > 0.0f ? least : 0.0f));
    const float depth =
        q * (1.00000076f +
             q * (0.0999239323f +
                  q * (0.0327052240f +
                       q * (0.00516035433f +
                            q * (0.0287030500f + q * (-0.0273979731f + q * 0.0188775309f))))));
    const float height = 1.0f - (depth < 1.0f ? depth : 1.0f);
    return share < 0.5f ? -height : height;
}

/* Does lens_aperture_lines for a disc. */
static inline void lens_disc_lines(uint32_t l, uint32_t i, uint32_t count,
                                   const float *restrict across, float *restrict height,
                                   float *restrict left, float *restrict length)
{
    for (uint32_t k = 0; k < count; k++) {
        const float y = lens_disc_height(pattern_axis(across[k], l, i));
        const float square = (1.0f - y) * (1.0f + y), half = sqrtf(square > 0.0f ? square : 0.0f);
        height[k] = y;
        left[k] = -half;
        length[k] = half + half;
    }
}

/* All that the pattern needs of a plan: init once, then ask for points. */
struct lens_pattern {
    struct pattern pattern;
    uint32_t dimension;
    uint32_t l;
    struct lens_aperture aperture;
};

void lens_pattern_init(struct lens_pattern *out, const struct plan *plan);

/* Computes the jitters of `count` pixels of row y from column x on: along[] of points on their
 * line, across[] of the lines. Point k of line i lies `pattern_axis(along, l, k)` of the way along
 * the chord at lens_aperture_height(pattern_axis(across, l, i)). */
void lens_pattern_jitters(const struct lens_pattern *p, int32_t x, int32_t y, uint32_t count,
                          float *along, float *across);

/* Computes point k of line i of a pixel. */
void lens_pattern_at(const struct lens_pattern *p, int32_t x, int32_t y, uint32_t i, uint32_t k,
                     float u[2]);

/* Does the same for a single lookup, without a prepared pattern. */
void lens_pattern_point(const struct plan *plan, int32_t x, int32_t y, uint32_t i, uint32_t k,
                        float u[2]);
