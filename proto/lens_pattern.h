#pragma once
/* Where lens samples lie: points u of an aperture of radius 1, u[0] to the right as image columns
 * run, u[1] down as image rows do. The light field of a pixel (x, y) with slope s, in pixels per
 * unit of the lens (samples.h), then shows at (x, u) what a pinhole shows at x + s u.
 *
 * A ray of proto/plan.h's lens starts at eye + aperture_radius * (u[0] right - u[1] up).
 *
 * A pixel's l x l points are l rows of equal area, with all of a row's points on one line, and l
 * points of equal distances on each. One jitter per pixel places them all (filters.md section 4),
 * uniformly over the aperture in the mean over jitters. */
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

/* The height u[1] below which (towards -1) lies `share`, 0 .. 1, of the area. Error 2e-6. */
float lens_aperture_height(const struct lens_aperture *a, float share);

/* The ends of the chord at a height; both the same where there is none. */
void lens_aperture_chord(const struct lens_aperture *a, float height, float *left, float *right);

/* Line i of l of `count` pixels with the jitters across[]: where it lies and what of it is in the
 * aperture. */
void lens_aperture_lines(const struct lens_aperture *a, uint32_t l, uint32_t i, uint32_t count,
                         const float *across, float *height, float *left, float *length);

/* All that the pattern needs of a plan: init once, then ask for points. */
struct lens_pattern {
    struct pattern pattern;
    uint32_t dimension;
    uint32_t l;
    struct lens_aperture aperture;
};

void lens_pattern_init(struct lens_pattern *out, const struct plan *plan);

/* The jitters of `count` pixels of row y from column x on: along[] of points on their line,
 * across[] of the lines. Point k of line i lies `pattern_axis(along, l, k)` of the way along the
 * chord at lens_aperture_height(pattern_axis(across, l, i)). */
void lens_pattern_jitters(const struct lens_pattern *p, int32_t x, int32_t y, uint32_t count,
                          float *along, float *across);

/* Point k of line i of a pixel. */
void lens_pattern_at(const struct lens_pattern *p, int32_t x, int32_t y, uint32_t i, uint32_t k,
                     float u[2]);

/* The same, for whoever asks but once. */
void lens_pattern_point(const struct plan *plan, int32_t x, int32_t y, uint32_t i, uint32_t k,
                        float u[2]);
