#pragma once
/* The time that a frame's shutter is open runs from 0 to 1. What moves in it is known at some
 * steps, evenly spaced, and goes straight from one to the next. */
#include <stdint.h>

#define SHUTTER_STEPS       5u
#define SHUTTER_MIDDLE      (SHUTTER_STEPS / 2) /* this step is the frame as it is without a shutter */
#define SHUTTER_MIDDLE_TIME 0.5f

/* A time between step `before` and the next one. */
struct shutter_place {
    uint32_t before;
    float share; /* of the next one */
};

static inline struct shutter_place shutter_place_of(float time)
{
    const float at = time * (float)(SHUTTER_STEPS - 1);
    const uint32_t floor = (uint32_t)at, last = SHUTTER_STEPS - 2;
    const uint32_t before = floor < last ? floor : last;
    return (struct shutter_place){before, at - (float)before};
}

static inline float shutter_mix(struct shutter_place at, float before, float after)
{
    return (1.0f - at.share) * before + at.share * after;
}
