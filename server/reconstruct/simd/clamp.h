#pragma once

/* Returns v within least .. most; NaN stays NaN. */
static inline float clamp(float v, float least, float most)
{
    return v < least ? least : v > most ? most : v;
}
