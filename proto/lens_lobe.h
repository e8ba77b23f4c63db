#pragma once
/* Decides which glossy lobes may share the light that they reflect: a lens sample's with the
 * centre's of its pixel (worker/trace/path/centre_gbuffer.h), and with those of the pixels around
 * (server/reconstruct/lighting/light_lookup.h). */
#include <stdbool.h>

/* The largest ratio of GGX alphas that are alike. */
#define LENS_LOBE_ALPHA_RATIO 1.25f

/* Returns whether two lobes are alike, by their alphas. An alpha of 0 means no lobe, which is like
 * no other. */
static inline bool lens_lobes_alike(float a, float b)
{
    return a > 0.0f && a <= LENS_LOBE_ALPHA_RATIO * b && b <= LENS_LOBE_ALPHA_RATIO * a;
}
