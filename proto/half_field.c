#include "proto/half_field.h"

#include <math.h>

#define ALPHA_MIN  0.002f
#define ALPHA_LIKE 0.1f         /* of the pixel's: how much alphas may differ */
#define SIGMA      0.665190105f /* 1 / sqrt(2.26): of GGX facets over alpha */
#define COSINE_MIN 0.05f

/* Computes the mirrored direction, in camera space, and returns the cosine of the view. */
static float mirror(const struct surface_view *view, const struct shown_surface *s, float out[3])
{
    float v[3] = {0.0f, 0.0f, -1.0f}, cosine = 0.0f;
    for (int k = 0; k < 3 && !view->orthographic; k++) v[k] = -s->point[k] / s->distance;
    for (int k = 0; k < 3; k++) cosine += v[k] * s->normal[k];
    for (int k = 0; k < 3; k++) out[k] = 2.0f * cosine * s->normal[k] - v[k];
    return cosine;
}

float half_field_apart2(const struct surface_view *view, const struct half_field_lobe *pixel,
                        const struct half_field_lobe *node)
{
    float r[3], s[3], apart2 = 0.0f;
    const float cosine = mirror(view, &pixel->surface, r);
    const float other = mirror(view, &node->surface, s);
    const float alpha = fmaxf(pixel->alpha, ALPHA_MIN);
    if (!(fminf(cosine, other) >= COSINE_MIN)) return INFINITY;
    if (fabsf(node->alpha - pixel->alpha) > ALPHA_LIKE * pixel->alpha) return INFINITY;
    for (int k = 0; k < 3; k++) {
        const float moved = pixel->surface.point[k] - node->surface.point[k];
        const float h = r[k] - s[k] + node->nearness * moved;
        apart2 += h * h;
    }
    const float stretch = pixel->stretch > 0.0f ? pixel->stretch : 1.0f;
    const float width = 2.0f * SIGMA * alpha * cosine;
    return apart2 / (width * width * stretch);
}
