#include "server/import/rgbd/light_sky.h"

#include <math.h>
#include <string.h>

#include "proto/scene/environment.h"

#define SUB 2 /* rays along each side of a texel */

void light_sky_direction(double x, double y, uint32_t width, uint32_t height, double out[3])
{
    const double azimuth = 2 * M_PI * (x / width - 0.5), polar = M_PI * y / height;
    out[0] = sin(polar) * cos(azimuth);
    out[1] = cos(polar);
    out[2] = sin(polar) * sin(azimuth);
}

/* Adds what frames show far away in a direction, where they know no depth. */
static int look_far(const struct light_views *views, const double direction[3], float rgb[3])
{
    int count = 0;
    for (uint32_t i = 0; i < views->count; i++) {
        const struct light_pixel *p = light_view_look(&views->list[i], direction);
        if (p == NULL || p->z > 0) continue;
        for (int c = 0; c < 3; c++) rgb[c] += p->color[c];
        count++;
    }
    for (int c = 0; c < 3 && count > 0; c++) rgb[c] /= (float)count;
    return count;
}

static bool look(const struct light_views *views, const double place[3], const double direction[3],
                 float rgb[3])
{
    struct light_hit nearest = {.pixel = NULL};
    for (uint32_t i = 0; i < views->count; i++) {
        const struct light_hit hit = light_view_trace(&views->list[i], place, direction);
        if (hit.pixel && (!nearest.pixel || hit.distance < nearest.distance)) nearest = hit;
    }
    for (int c = 0; c < 3; c++) rgb[c] = 0;
    if (nearest.pixel == NULL) return look_far(views, direction, rgb) > 0;
    memcpy(rgb, nearest.pixel->shines ? nearest.view->white : nearest.pixel->color,
           3 * sizeof *rgb);
    return true;
}

static void look_at_texel(const struct light_views *views, const double place[3], uint32_t i,
                          struct light_sky *out)
{
    const uint32_t x = i % SCENE_SKY_WIDTH_PX, y = i / SCENE_SKY_WIDTH_PX;
    int count = 0;
    double sum[3] = {0};
    for (int k = 0; k < SUB * SUB; k++) {
        double direction[3];
        float rgb[3];
        const int across = k % SUB, down = k / SUB;
        light_sky_direction(x + (across + 0.5) / SUB, y + (down + 0.5) / SUB, SCENE_SKY_WIDTH_PX,
                            SCENE_SKY_HEIGHT_PX, direction);
        if (!look(views, place, direction, rgb)) continue;
        for (int c = 0; c < 3; c++) sum[c] += (double)rgb[c];
        count++;
    }
    out->seen[i] = count > 0;
    for (int c = 0; c < 3 && count > 0; c++)
        out->texels[3 * i + (uint32_t)c] = (float)(sum[c] / count);
}

void light_sky_look(const struct light_views *views, const double place[3], struct light_sky *out)
{
    double seen = 0;
    memset(out, 0, sizeof *out);
    for (uint32_t i = 0; i < SCENE_SKY_TEXELS; i++) {
        const uint32_t y = i / SCENE_SKY_WIDTH_PX;
        const double share =
            environment_edge(y + 1, SCENE_SKY_HEIGHT_PX) - environment_edge(y, SCENE_SKY_HEIGHT_PX);
        look_at_texel(views, place, i, out);
        if (!out->seen[i]) continue;
        seen += share;
        for (uint32_t c = 0; c < 3; c++) out->mean[c] += share * (double)out->texels[3 * i + c];
    }
    for (int c = 0; c < 3 && seen > 0; c++) out->mean[c] /= seen;
    out->share = seen / (2.0 * SCENE_SKY_WIDTH_PX);
}

void light_sky_fill(struct light_sky *sky, const double radiance[3 * LIGHT_BINS])
{
    const uint32_t bin_width = SCENE_SKY_WIDTH_PX / LIGHT_BINS_U;
    const uint32_t bin_height = SCENE_SKY_HEIGHT_PX / LIGHT_BINS_V;
    for (uint32_t i = 0; i < SCENE_SKY_TEXELS; i++) {
        if (sky->seen[i]) continue;
        const uint32_t column = i % SCENE_SKY_WIDTH_PX, row = i / SCENE_SKY_WIDTH_PX;
        const double x = (column + 0.5) / bin_width - 0.5 + LIGHT_BINS_U;
        const double y = fmin(fmax((row + 0.5) / bin_height - 0.5, 0), LIGHT_BINS_V - 1.0);
        const uint32_t u = (uint32_t)x, v = (uint32_t)y, below = v + 1 < LIGHT_BINS_V ? v + 1 : v;
        const double across = x - u, down = y - v;
        const uint32_t left = u % LIGHT_BINS_U, right = (u + 1) % LIGHT_BINS_U;
        for (uint32_t c = 0; c < 3; c++) {
            const double upper = radiance[3 * (v * LIGHT_BINS_U + left) + c] * (1 - across) +
                                 radiance[3 * (v * LIGHT_BINS_U + right) + c] * across;
            const double lower = radiance[3 * (below * LIGHT_BINS_U + left) + c] * (1 - across) +
                                 radiance[3 * (below * LIGHT_BINS_U + right) + c] * across;
            sky->texels[3 * i + c] = (float)(upper * (1 - down) + lower * down);
        }
    }
}
