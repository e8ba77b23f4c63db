#include "worker/shade/lambert.h"

#include <math.h>

#include "worker/shade/elementary.h"

#define QUARTER_PI 0.785398163397448310f

void lambert_sample(const float u[LANES], const float v[LANES], struct lanes3 *local)
{
    for (int i = 0; i < LANES; i++) {
        float a = 2.0f * u[i] - 1.0f, b = 2.0f * v[i] - 1.0f;
        int wide = fabsf(a) > fabsf(b);
        float radius = wide ? a : b, other = wide ? b : a;
        float divisor = radius == 0.0f ? 1.0f : radius; /* the centre: both are 0 */
        float angle = other / divisor * QUARTER_PI;
        float c = elementary_small_cos(angle), s = elementary_small_sin(angle);
        float height = 1.0f - radius * radius;
        local->x[i] = radius * (wide ? c : s);
        local->y[i] = radius * (wide ? s : c);
        local->z[i] = sqrtf(height > 0.0f ? height : 0.0f);
    }
}
