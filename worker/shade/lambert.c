#include "worker/shade/lambert.h"

#include <math.h>

#define QUARTER_PI 0.785398163397448310f

/* Taylor series; on [-pi/4, pi/4] the errors are below 3e-8. */
static inline float small_sin(float x)
{
    float s = x * x;
    return x * (1.0f + s * (-1.0f / 6 + s * (1.0f / 120 + s * (-1.0f / 5040 + s / 362880))));
}

static inline float small_cos(float x)
{
    float s = x * x;
    return 1.0f + s * (-0.5f + s * (1.0f / 24 + s * (-1.0f / 720 + s / 40320)));
}

void lambert_sample(const float u[LANES], const float v[LANES], struct lanes3 *local)
{
    for (int i = 0; i < LANES; i++) {
        float a = 2.0f * u[i] - 1.0f, b = 2.0f * v[i] - 1.0f;
        int wide = fabsf(a) > fabsf(b);
        float radius = wide ? a : b, other = wide ? b : a;
        float divisor = radius == 0.0f ? 1.0f : radius; /* the centre: both are 0 */
        float angle = other / divisor * QUARTER_PI;
        float c = small_cos(angle), s = small_sin(angle);
        float height = 1.0f - radius * radius;
        local->x[i] = radius * (wide ? c : s);
        local->y[i] = radius * (wide ? s : c);
        local->z[i] = sqrtf(height > 0.0f ? height : 0.0f);
    }
}
