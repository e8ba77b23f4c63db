#pragma once
/* Computes how far from a surface a ray must start so that it does not hit that surface again.
 *
 * The idea is Waechter and Binder's (2019, "A fast and robust method for avoiding
 * self-intersection"): an offset along the geometric normal grows with the rounding errors of the
 * position and is no constant of the scene. The position is interpolated from the triangle's
 * vertices, so its error is a few units in the last place of the largest coordinate that went into
 * it, and so is that of the intersection test, which subtracts it from these vertices. That
 * magnitude is the argument, so offsets are right at any scale and any distance from the origin. */

/* Units in the last place, each 2^-23 of the magnitude. In tests/unit/worker/scene/test_offset.c
 * one unit still fails here and there and one and a half never does. The rest is room for skewed
 * instances. */
#define OFFSET_ULPS 6.0f

/* The smallest offset. Positions at the origin have denormal errors, which are flushed to zero. */
#define OFFSET_MIN 1e-30f

static inline float offset_distance(float magnitude)
{
    float d = magnitude * (OFFSET_ULPS * 0x1p-23f);
    return d > OFFSET_MIN ? d : OFFSET_MIN;
}
