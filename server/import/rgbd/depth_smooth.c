/* Joint bilateral filtering (Petschnigg et al. 2004) of 1/z, in which planes are linear. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/rgbd/depth_map.h"

#define RADIUS_PX   4
#define SIGMA_PX    2.0f
#define FILL_PX     2     /* a step of filling looks so far */
#define FILL_STEPS  16    /* so holes of twice as many pixels are filled */
#define COLOR_SIGMA 0.08f /* of square roots, which are about as even to the eye */

struct smoothing {
    const struct depth_map *map;
    const float *tone; /* square roots of colours; NULL: none */
    float *out;        /* 1/z */
};

static float color_weight(const struct smoothing *s, size_t i, size_t k)
{
    float sum = 0;
    if (s->tone == NULL) return 1;
    for (size_t c = 0; c < 3; c++) {
        const float off = s->tone[3 * i + c] - s->tone[3 * k + c];
        sum += off * off;
    }
    return expf(-sum / (2 * COLOR_SIGMA * COLOR_SIGMA));
}

/* Averages pairs on either side alike, so that slopes stay; a tap whose other side is another
 * surface counts with it, or not at all. */
static float filter(const struct smoothing *s, int32_t x, int32_t y)
{
    const struct depth_map *m = s->map;
    const size_t i = (size_t)y * (size_t)m->width + (size_t)x;
    const float own = 1 / m->z[i];
    const float range = (3 * depth_noise_m(m->z[i]) + 0.005f * m->z[i]) * own * own;
    float sum = m->sure[i] * own, weights = m->sure[i];
    for (int32_t v = 0; v <= RADIUS_PX; v++)
        for (int32_t u = v == 0 ? 1 : -RADIUS_PX; u <= RADIUS_PX; u++) {
            const int32_t ends[4] = {x + u, y + v, x - u, y - v};
            float pair = 0, at[2], sure[2], weight = 1;
            bool inside = true;
            for (int k = 0; k < 2 && inside; k++) {
                inside = ends[2 * k] >= 0 && ends[2 * k] < m->width && ends[2 * k + 1] >= 0 &&
                         ends[2 * k + 1] < m->height;
                if (!inside) break;
                const size_t j = (size_t)ends[2 * k + 1] * (size_t)m->width + (size_t)ends[2 * k];
                inside = m->z[j] > 0;
                at[k] = inside ? 1 / m->z[j] : 0;
                sure[k] = m->sure[j];
                weight *= color_weight(s, i, j);
            }
            if (!inside) continue;
            pair = 0.5f * (at[0] + at[1]) - own;
            if (fabsf(at[0] - at[1]) > 2 * (range + (float)(abs(u) + v) * 0.05f * own)) continue;
            weight *= expf(-(float)(u * u + v * v) / (2 * SIGMA_PX * SIGMA_PX) -
                           pair * pair / (2 * range * range)) *
                      (sure[0] + sure[1]);
            sum += weight * (own + pair);
            weights += weight;
        }
    return sum / weights;
}

/* Averages the depths around a hole's pixel that look like it; 0: there is none yet. */
static float fill_pixel(const struct smoothing *s, int32_t x, int32_t y)
{
    const struct depth_map *m = s->map;
    const size_t i = (size_t)y * (size_t)m->width + (size_t)x;
    float sum = 0, weights = 0;
    for (int32_t v = y - FILL_PX; v <= y + FILL_PX; v++)
        for (int32_t u = x - FILL_PX; u <= x + FILL_PX; u++) {
            if (u < 0 || v < 0 || u >= m->width || v >= m->height) continue;
            const size_t j = (size_t)v * (size_t)m->width + (size_t)u;
            if (!(m->z[j] > 0)) continue;
            const float weight = color_weight(s, i, j) + 1e-6f;
            sum += weight / m->z[j];
            weights += weight;
        }
    return weights > 0 ? weights / sum : 0;
}

/* One step from the edges of all holes inwards. Returns whether it changed anything. */
static bool fill_once(struct smoothing *s, struct depth_map *m)
{
    bool changed = false;
    const size_t count = (size_t)m->width * (size_t)m->height;
    memset(s->out, 0, count * sizeof *s->out);
    for (int32_t y = 0; y < m->height; y++)
        for (int32_t x = 0; x < m->width; x++) {
            const size_t i = (size_t)y * (size_t)m->width + (size_t)x;
            if (!(m->z[i] > 0)) s->out[i] = fill_pixel(s, x, y);
        }
    for (size_t i = 0; i < count; i++) {
        if (!(s->out[i] > 0)) continue;
        m->z[i] = s->out[i];
        m->sure[i] = 0.1f;
        changed = true;
    }
    return changed;
}

int depth_map_smooth(struct depth_map *m, struct fault *fault)
{
    const size_t count = (size_t)m->width * (size_t)m->height;
    float *out = malloc(count * sizeof *out);
    float *tone = m->color != NULL ? malloc(3 * count * sizeof *tone) : NULL;
    struct smoothing s = {.map = m, .tone = tone, .out = out};
    if (out == NULL || (m->color != NULL && tone == NULL)) {
        free(out);
        free(tone);
        return fault_set(fault, ERR_MEMORY, "/rgbd", "no memory to filter depth");
    }
    for (size_t i = 0; tone != NULL && i < 3 * count; i++) tone[i] = sqrtf(m->color[i]);
    for (int step = 0; step < FILL_STEPS && fill_once(&s, m); step++) continue;
    for (int32_t y = 0; y < m->height; y++)
        for (int32_t x = 0; x < m->width; x++) {
            const size_t i = (size_t)y * (size_t)m->width + (size_t)x;
            out[i] = m->z[i] > 0 ? filter(&s, x, y) : 0;
        }
    for (size_t i = 0; i < count; i++) m->z[i] = out[i] > 0 ? 1 / out[i] : 0;
    free(out);
    free(tone);
    return 0;
}
