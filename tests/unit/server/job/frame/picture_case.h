#pragma once
/* Pictures whose figures are known. */
#include <math.h>

#include "server/image/image.h"
#include "tests/unit/unit.h"

static const char *const picture_channels[] = {"R", "G", "B", "error.R", "error.G", "error.B"};

/* R, G, B of one value; standard errors too when there is one. */
static inline struct image *picture_filled(int32_t width, int32_t height, float value, float error)
{
    struct image *image;
    uint32_t channels = error > 0 ? 6 : 3;
    assert_int_equal(image_create_named(picture_channels, channels, width, height, &image), 0);
    for (uint32_t c = 0; c < channels; c++)
        for (int32_t y = 0; y < height; y++)
            for (int32_t x = 0; x < width; x++)
                *plane_at(&image->channels[c].plane, x, y) = c < 3 ? value : error;
    return image;
}

/* A number in [0, 1) of a small generator. */
static inline double picture_random(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* Box and Muller's normal deviate. */
static inline double picture_normal(uint64_t *state)
{
    double u = 1 - picture_random(state), v = picture_random(state);
    return sqrt(-2 * log(u)) * cos(6.283185307179586 * v);
}
