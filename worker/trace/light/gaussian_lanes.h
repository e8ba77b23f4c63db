#pragma once
/* Returns exp(-x) for x in [0, 4], by a series on [0, 1/4] that is squared four times. The relative
 * error is below 2e-6. It does not call the C library, whose bits depend on the CPU. */

static inline float gaussian(float x)
{
    float y = x * (1.0f / 16);
    float s = 1.0f - y * (1.0f - y * (0.5f - y * (1.0f / 6 - y * (1.0f / 24 - y / 120))));
    s *= s;
    s *= s;
    s *= s;
    return s * s;
}
