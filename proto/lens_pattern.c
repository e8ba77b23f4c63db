#include "proto/lens_pattern.h"

#include <math.h>
#include <string.h>

/* Jitters of many strata: a scrambled net, which no shear folds (pattern.h). The dimensions after
 * those of lights are free. */
#define DIMENSION_NET (PATTERN_LIGHT_NET + LIMIT_LIGHTS)

#define PI           3.14159265358979323846
#define JITTER_BATCH 64
#define SAME_HEIGHT  1e-6 /* corners that differ by less are as high as each other */

/* Returns the sine of any x in double, from a series in [-pi, pi]. It is the same on every CPU,
 * which the C library's is not. The error is 1e-13 to |x| = 1e3, and grows with x. */
static double sine(double x)
{
    const double rest = x - 2.0 * PI * floor(x / (2.0 * PI) + 0.5), square = rest * rest;
    double term = rest, sum = rest;
    for (int k = 1; k <= 16; k++) {
        term *= -square / (2.0 * k * (2.0 * k + 1.0));
        sum += term;
    }
    return sum;
}

struct corner {
    double x, y;
};

static struct corner corner_of(const struct plan_camera *camera, uint32_t k)
{
    const double angle = (double)camera->blade_rotation_rad + 2.0 * PI * k / camera->blade_count;
    return (struct corner){sine(angle + 0.5 * PI), -sine(angle)};
}

/* Sorts the corners' heights, each once. */
static uint32_t sort_heights(const struct corner *corners, uint32_t count, double *out)
{
    uint32_t n = 0;
    for (uint32_t k = 0; k < count; k++) {
        uint32_t at = 0;
        while (at < n && out[at] < corners[k].y - SAME_HEIGHT) at++;
        if (at < n && out[at] <= corners[k].y + SAME_HEIGHT) continue;
        memmove(out + at + 1, out + at, (n - at) * sizeof *out);
        out[at] = corners[k].y;
        n++;
    }
    return n;
}

/* Widens the chord at `height` to what edge a-b has there. */
static void meet_edge(struct corner a, struct corner b, double height, double *left, double *right)
{
    const double low = fmin(a.y, b.y), high = fmax(a.y, b.y);
    if (height < low - SAME_HEIGHT || height > high + SAME_HEIGHT) return;
    double first = a.x, second = b.x;
    if (high - low > SAME_HEIGHT) {
        const double t = fmin(fmax((height - a.y) / (b.y - a.y), 0.0), 1.0);
        first = second = a.x + t * (b.x - a.x);
    }
    *left = fmin(*left, fmin(first, second));
    *right = fmax(*right, fmax(first, second));
}

static void init_bands(const struct corner *corners, uint32_t count, struct lens_aperture *out)
{
    double heights[LIMIT_LENS_BLADES], widths[LIMIT_LENS_BLADES], area = 0.0;
    const uint32_t n = sort_heights(corners, count, heights);
    for (uint32_t i = 0; i < n; i++) {
        double left = 2.0, right = -2.0;
        for (uint32_t k = 0; k < count; k++)
            meet_edge(corners[k], corners[(k + 1) % count], heights[i], &left, &right);
        widths[i] = right - left;
        if (i > 0) area += 0.5 * (widths[i] + widths[i - 1]) * (heights[i] - heights[i - 1]);
        out->height[i] = (float)heights[i];
        out->left[i] = (float)left;
        out->right[i] = (float)right;
        out->below[i] = (float)area;
    }
    for (uint32_t i = 0; i < n; i++) out->below[i] = (float)((double)out->below[i] / area);
    out->area = (float)area;
    out->bands = n - 1;
}

void lens_aperture_init(const struct plan_camera *camera, struct lens_aperture *out)
{
    struct corner corners[LIMIT_LENS_BLADES];
    *out = (struct lens_aperture){.area = (float)PI};
    if (camera->blade_count < 3 || camera->blade_count > LIMIT_LENS_BLADES) return;
    for (uint32_t k = 0; k < camera->blade_count; k++) corners[k] = corner_of(camera, k);
    init_bands(corners, camera->blade_count, out);
}

/* Returns how high in band i `share` lies. The chord grows evenly there, and w0 y + (w1 - w0) y^2 /
 * (2 h) of the area lies below y. */
static float band_height(const struct lens_aperture *a, uint32_t i, float share)
{
    const float w0 = a->right[i] - a->left[i], w1 = a->right[i + 1] - a->left[i + 1];
    const float h = a->height[i + 1] - a->height[i];
    const float more = share - a->below[i], area = (more > 0.0f ? more : 0.0f) * a->area;
    const float square = w0 * w0 + 2.0f * (w1 - w0) / h * area;
    const float under = w0 + sqrtf(square > 0.0f ? square : 0.0f);
    const float y = under > 1e-9f ? 2.0f * area / under : 0.0f;
    return a->height[i] + (y < h ? y : h);
}

/* Returns the band of a share of the area. */
static uint32_t band_of(const struct lens_aperture *a, float share)
{
    uint32_t i = 0;
    while (i + 1 < a->bands && a->below[i + 1] < share) i++;
    return i;
}

float lens_aperture_height(const struct lens_aperture *a, float share)
{
    return a->bands > 0 ? band_height(a, band_of(a, share), share) : lens_disc_height(share);
}

static void band_chord(const struct lens_aperture *a, uint32_t i, float height, float *left,
                       float *right)
{
    const float h = a->height[i + 1] - a->height[i]; /* above SAME_HEIGHT */
    const float t = (height - a->height[i]) / h;
    *left = a->left[i] + t * (a->left[i + 1] - a->left[i]);
    *right = a->right[i] + t * (a->right[i + 1] - a->right[i]);
    if (t >= 0.0f && t <= 1.0f && *left <= *right) return;
    *left = *right = 0.5f * (*left + *right);
}

void lens_aperture_chord(const struct lens_aperture *a, float height, float *left, float *right)
{
    if (a->bands > 0) {
        uint32_t i = 0;
        while (i + 1 < a->bands && a->height[i + 1] < height) i++;
        band_chord(a, i, height, left, right);
        return;
    }
    const float square = (1.0f - height) * (1.0f + height);
    *right = sqrtf(square > 0.0f ? square : 0.0f);
    *left = -*right;
}

void lens_aperture_lines(const struct lens_aperture *a, uint32_t l, uint32_t i, uint32_t count,
                         const float *across, float *height, float *left, float *length)
{
    if (a->bands == 0) {
        lens_disc_lines(l, i, count, across, height, left, length);
        return;
    }
    for (uint32_t k = 0; k < count; k++) {
        const float share = pattern_axis(across[k], l, i);
        const uint32_t band = band_of(a, share);
        float right;
        height[k] = band_height(a, band, share);
        band_chord(a, band, height[k], &left[k], &right);
        length[k] = right - left[k];
    }
}

void lens_pattern_init(struct lens_pattern *out, const struct plan *plan)
{
    out->pattern = plan->pattern;
    out->l = plan->lens_strata_per_axis;
    out->dimension = out->l < PATTERN_NET_STRATA ? (uint32_t)PATTERN_LENS : DIMENSION_NET;
    lens_aperture_init(&plan->camera, &out->aperture);
}

void lens_pattern_jitters(const struct lens_pattern *p, int32_t x, int32_t y, uint32_t count,
                          float *along, float *across)
{
    int32_t xs[JITTER_BATCH], ys[JITTER_BATCH];
    for (uint32_t k = 0; k < JITTER_BATCH; k++) ys[k] = y;
    for (uint32_t first = 0; first < count; first += JITTER_BATCH) {
        const uint32_t n = count - first < JITTER_BATCH ? count - first : JITTER_BATCH;
        for (uint32_t k = 0; k < n; k++) xs[k] = x + (int32_t)(first + k);
        pattern_jitters(&p->pattern, xs, ys, n, p->dimension, along + first, across + first);
    }
}

void lens_pattern_at(const struct lens_pattern *p, int32_t x, int32_t y, uint32_t i, uint32_t k,
                     float u[2])
{
    float jitter[2], left, right;
    pattern_jitter(&p->pattern, x, y, p->dimension, jitter);
    u[1] = lens_aperture_height(&p->aperture, pattern_axis(jitter[1], p->l, i));
    lens_aperture_chord(&p->aperture, u[1], &left, &right);
    u[0] = left + (right - left) * pattern_axis(jitter[0], p->l, k);
}

void lens_pattern_point(const struct plan *plan, int32_t x, int32_t y, uint32_t i, uint32_t k,
                        float u[2])
{
    struct lens_pattern p;
    lens_pattern_init(&p, plan);
    lens_pattern_at(&p, x, y, i, k, u);
}
