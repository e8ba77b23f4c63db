#include "server/reconstruct/strata.h"

#include <string.h>

#include "server/reconstruct/gaussian.h"

#define NEAR_MOST 1e9f /* (size / distance)^2 */

void strata_jitters(const struct receiver_light *light, const int32_t *x, const int32_t *y,
                    uint32_t count, float *out0, float *out1)
{
    pattern_jitters(&light->plan->pattern, x, y, count,
                    pattern_light_dimension(light->index, light->strata), out0, out1);
    for (uint32_t i = 0; i < count; i++) {
        out0[i] = out0[i] < PATTERN_JITTER_MAX ? out0[i] : PATTERN_JITTER_MAX;
        out1[i] = out1[i] < PATTERN_JITTER_MAX ? out1[i] : PATTERN_JITTER_MAX;
    }
}

void strata_columns(const struct receiver_light *light, const struct patch *patch, size_t i,
                    uint32_t columns[SHADOW_STRATA_MAX])
{
    const size_t area = (size_t)rect_area(patch->rect);
    const uint8_t *bits = patch->lights[light->index].visibility + i;
    const uint32_t l = light->strata;
    for (uint32_t a = 0; a < l; a++) columns[a] = 0;
    for (uint32_t k = 0, b = 0; b < l; b++) {
        for (uint32_t a = 0; a < l; a++, k++)
            columns[a] |= ((uint32_t)bits[(k >> 3) * area] >> (k & 7u) & 1u) << b;
    }
}

bool strata_all_seen(const struct receiver_light *light, const struct patch *patch, size_t i)
{
    const size_t area = (size_t)rect_area(patch->rect);
    const uint8_t *bits = patch->lights[light->index].visibility + i;
    const uint32_t count = light->strata * light->strata;
    for (uint32_t first = 0; first < count; first += 8, bits += area) {
        const uint32_t left = count - first, all = left < 8 ? (1u << left) - 1 : 0xffu;
        if ((*bits & all) != all) return false;
    }
    return true;
}

/* I G of the light's point (u, v) in [-1, 1]^2, but for factors that all points share. */
static float point_weight(const struct shadow_rectangle *r, const float to[3],
                          const float normal[3], float size2, float u, float v)
{
    float w[3], up = 0.0f, squared = 0.0f;
    for (int k = 0; k < 3; k++) {
        w[k] = to[k] + u * r->half[0] * r->axis[0][k] + v * r->half[1] * r->axis[1][k];
        up += w[k] * normal[k];
        squared += w[k] * w[k];
    }
    if (!(up > 0.0f && squared > 0.0f)) return 0.0f;
    const float profile =
        r->profile == PROFILE_GAUSSIAN ? gaussian_exp_minus(2.0f * (u * u + v * v)) : 1.0f;
    /* In units of the light's size and bounded, so that squares of squares stay finite. */
    const float near = size2 / squared, bounded = near < NEAR_MOST ? near : NEAR_MOST;
    return profile * up * (bounded * bounded);
}

static bool none_seen(const uint32_t columns[SHADOW_STRATA_MAX], uint32_t l)
{
    uint32_t any = 0;
    for (uint32_t a = 0; a < l; a++) any |= columns[a];
    return any == 0;
}

float strata_ratio(const struct receiver_light *light, const struct patch *patch, int32_t x,
                   int32_t y)
{
    const size_t width = (size_t)rect_width(patch->rect);
    const size_t i = (size_t)(y - patch->rect.y0) * width + (size_t)(x - patch->rect.x0);
    if (strata_all_seen(light, patch, i)) return 1.0f;
    float point[3], normal[3], to[3], jitter[2];
    float *const points[3] = {&point[0], &point[1], &point[2]};
    float *const normals[3] = {&normal[0], &normal[1], &normal[2]};
    uint32_t columns[SHADOW_STRATA_MAX];
    const uint32_t l = light->strata;
    strata_columns(light, patch, i, columns);
    if (none_seen(columns, l)) return 0.0f; /* what the sums below come to */
    receiver_row(light, patch, x, y, 1, points, normals);
    for (int k = 0; k < 3; k++) to[k] = light->rectangle.centre[k] - point[k];
    strata_jitters(light, &x, &y, 1, &jitter[0], &jitter[1]);
    const float *half = light->rectangle.half, size2 = half[0] * half[0] + half[1] * half[1];
    float seen = 0.0f, all = 0.0f, seen_count = 0.0f;
    for (uint32_t b = 0; b < l; b++) {
        for (uint32_t a = 0; a < l; a++) {
            const float u = 2.0f * pattern_axis(jitter[0], l, a) - 1.0f;
            const float v = 2.0f * pattern_axis(jitter[1], l, b) - 1.0f;
            const float weight = point_weight(&light->rectangle, to, normal, size2, u, v);
            all += weight;
            seen += columns[a] >> b & 1u ? weight : 0.0f;
            seen_count += columns[a] >> b & 1u ? 1.0f : 0.0f;
        }
    }
    return all > 0.0f ? seen / all : seen_count / (float)(l * l);
}
