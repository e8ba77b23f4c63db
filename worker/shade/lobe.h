#pragma once
/* Lobes cos^n around an axis, and the choice between a diffuse lobe and another. */
#include "worker/shade/bsdf.h"
#include "worker/shade/direction.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/lambert.h"

/* Where a lobe's estimate is 0 it may still be reached: no lobe is chosen less often than this. */
#define LOBE_MIN 0.01f

/* What sharp lobes show cannot be smoothed, while diffuse light is from few samples. So lobes that
 * the camera sees are chosen at least this often where they are mirrors, and in proportion less
 * often up to a roughness from where they are not favoured (docs/reconstruction.md, Sample
 * positions). */
#define LOBE_SEEN_SHARE 0.5f
#define LOBE_SEEN_ALPHA 0.12f

/* Returns how much sharp lobes are favoured: 1 of mirrors, 0 of rough ones. */
static inline float lobe_sharpness(float alpha)
{
    const float sharp = 1.0f - alpha * (1.0f / LOBE_SEEN_ALPHA);
    return sharp > 0.0f ? sharp : 0.0f;
}

/* Returns the least probability of a lobe of facets that the camera sees. */
static inline float lobe_seen_share(float alpha)
{
    return LOBE_SEEN_SHARE * lobe_sharpness(alpha);
}

/* Returns how much facets' estimate is at least, over those of all others. */
static inline float lobe_least(bool seen, float alpha)
{
    const float share = seen ? lobe_seen_share(alpha) : 0.0f;
    return share > LOBE_MIN ? share / (1.0f - share) : LOBE_MIN;
}

static inline float lobe_mean(const float color[3])
{
    return (color[0] + color[1] + color[2]) * (1.0f / 3.0f);
}

/* Returns the probability of the specular lobe from estimates of what each lobe reflects. */
static inline float lobe_share(float specular, float diffuse)
{
    if (specular <= 0.0f) return 0.0f;
    if (diffuse <= 0.0f) return 1.0f;
    const float share = specular / (specular + diffuse);
    return share < LOBE_MIN ? LOBE_MIN : share;
}

/* Returns (1 - depth)^n for n >= 0. With the depth, one minus the cosine, sharp lobes keep their
 * digits. */
static inline float lobe_power(float depth, float n)
{
    if (depth >= 1.0f) return 0.0f;
    return elementary_exp(n * elementary_log1p(-depth));
}

/* Returns the depth at which a share u in [0, 1) of the lobe (n + 1) cos^n lies nearer to the
 * axis. */
static inline float lobe_depth(float u, float n)
{
    return -elementary_expm1(elementary_log1p(-u) / (n + 1.0f));
}

/* Returns 1 - h.z, for h near z. */
static inline float lobe_depth_of(const float h[3])
{
    return (h[0] * h[0] + h[1] * h[1]) / (1.0f + h[2]);
}

/* Returns the density that a cosine-weighted lobe, chosen with `probability`, adds. */
static inline float lobe_diffuse_pdf(float probability, float cosine)
{
    return probability * cosine * LAMBERT_INV_PI;
}

/* Returns a diffuse lobe over its albedo that makes room for what Schlick's Fresnel adds at grazing
 * angles to lobes beside it. */
static inline float lobe_diffuse_under_schlick(float z_o, float z_i)
{
    return LAMBERT_INV_PI * (1.0f - fresnel_grazing(z_o)) * (1.0f - fresnel_grazing(z_i)) /
           (1.0f - FRESNEL_GRAZING_MEAN);
}
