#pragma once
/* How far from a surface a ray must start so that it does not hit that surface again.
 *
 * The idea is Waechter and Binder's (2019, "A fast and robust method for avoiding
 * self-intersection"): an offset along the geometric normal that grows with the rounding errors of
 * the position, not a constant of the scene. The position is interpolated from the triangle's
 * vertices, so its error, and that of the intersection test which subtracts it from these vertices,
 * is a few units in the last place of the largest coordinate that went into it. That magnitude is
 * the argument: correct at any scale and any distance from the origin. */

/* Units in the last place, 2^-23 of the magnitude each. In tests/unit/worker/scene/test_offset.c
 * one still fails here and there and one and a half never; the rest is room for skewed instances.
 */
#define OFFSET_ULPS 6.0f

/* Smallest offset: positions at the origin have denormal errors, which are flushed to zero. */
#define OFFSET_MIN 1e-30f

static inline float offset_distance(float magnitude)
{
    float d = magnitude * (OFFSET_ULPS * 0x1p-23f);
    return d > OFFSET_MIN ? d : OFFSET_MIN;
}
