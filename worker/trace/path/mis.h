#pragma once
/* Multiple importance sampling lets two samplers share the light that both can find. */

/* Returns the weight of a sample of density `own` that the other sampler draws with density
 * `other`: the power heuristic, exponent 2 (Veach and Guibas 1995, section 5.1). It is 1 where
 * `own` is 0, as for Dirac lobes, and 0 where the square overflows. */
static inline float mis_power_weight(float own, float other)
{
    float ratio = other / (own > 0.0f ? own : 1.0f);
    float weight = 1.0f / (1.0f + ratio * ratio);
    return own > 0.0f ? weight : 1.0f;
}
