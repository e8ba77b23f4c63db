#pragma once
/* The share of light that a smooth interface reflects, unpolarised. Cosines are those between a
 * direction and the (facet) normal, in [0, 1]. */
#include <math.h>
#include <stdbool.h>

/* Returns (1 - cosine)^5: Schlick (1994, "An inexpensive BRDF model"), F = f0 + (1 - f0) times
 * this. */
static inline float fresnel_grazing(float cosine)
{
    const float m = cosine < 1.0f ? 1.0f - cosine : 0.0f, s = m * m;
    return s * s * m;
}

/* Its cosine-weighted mean, 1/21. */
#define FRESNEL_GRAZING_MEAN 0.0476190476f

static inline float fresnel_schlick(float f0, float grazing)
{
    return f0 + (1.0f - f0) * grazing;
}

/* Returns the share by Fresnel's equations between dielectrics; eta > 0 is the far side's index
 * over the near one's. *cosine_far becomes the refracted direction's cosine; 0 with total
 * reflection, which gives 1. */
static inline float fresnel_dielectric(float cosine, float eta, float *cosine_far)
{
    const float sine2 = (1.0f - cosine) * (1.0f + cosine) / (eta * eta);
    const float c = sine2 < 1.0f ? sqrtf(1.0f - sine2) : 0.0f;
    *cosine_far = c;
    if (c <= 0.0f) return 1.0f;
    const float parallel = (eta * cosine - c) / (eta * cosine + c);
    const float across = (cosine - eta * c) / (cosine + eta * c);
    return 0.5f * (parallel * parallel + across * across);
}

/* Returns the share by Fresnel's equations at a conductor of complex index eta + i k as seen from a
 * vacuum, eta > 0. */
static inline float fresnel_conductor(float cosine, float eta, float k)
{
    const float cos2 = cosine * cosine, sin2 = (1.0f - cosine) * (1.0f + cosine);
    const float eta2 = eta * eta, k2 = k * k, t0 = eta2 - k2 - sin2;
    /* p^2 + q^2 and p of Born and Wolf's p + i q = sqrt((eta + i k)^2 - sin^2) */
    const float sum = sqrtf(t0 * t0 + 4.0f * eta2 * k2);
    const float p2 = 0.5f * (sum + t0), p = sqrtf(p2 > 0.0f ? p2 : 0.0f);
    const float across = (sum + cos2 - 2.0f * cosine * p) / (sum + cos2 + 2.0f * cosine * p);
    const float a = cos2 * sum + sin2 * sin2, b = 2.0f * cosine * p * sin2;
    const float ratio = a + b > 0.0f ? (a - b) / (a + b) : 1.0f;
    return 0.5f * across * (1.0f + ratio);
}
