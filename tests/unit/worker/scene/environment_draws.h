#pragma once
/* An environment map, and random directions and samples of it. */
#include <math.h>
#include <stdlib.h>

#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/scene/environment_fixture.h"

static struct environment_fixture f;
static struct random numbers;

static inline float draw(float direction[3])
{
    float pdf;
    const float choice = random_unit(&numbers),
                u[2] = {random_unit(&numbers), random_unit(&numbers)};
    environment_sample(f.map, choice, u, direction, &pdf);
    return pdf;
}

static inline void towards(double u, double v, float d[3])
{
    const double phi = 2.0 * M_PI * (u - 0.5), theta = M_PI * v;
    d[0] = (float)(sin(theta) * cos(phi));
    d[1] = (float)cos(theta);
    d[2] = (float)(sin(theta) * sin(phi));
}

static inline void random_direction(float d[3])
{
    const double y = 1.0 - 2.0 * (double)random_unit(&numbers),
                 phi = 2.0 * M_PI * (double)random_unit(&numbers);
    d[0] = (float)(sqrt(1.0 - y * y) * cos(phi));
    d[1] = (float)y;
    d[2] = (float)(sqrt(1.0 - y * y) * sin(phi));
}

static inline void open_random(uint32_t width, uint32_t height)
{
    float *texels = malloc(3 * sizeof(float) * width * height);
    for (uint32_t i = 0; i < 3 * width * height; i++) {
        const float r = random_unit(&numbers);
        texels[i] = i / 3 % 5 == 0 ? 0.0f : i / 3 % 37 == 1 ? 100.0f * r : r;
    }
    environment_fixture_open(&f, width, height, texels);
    free(texels);
}
