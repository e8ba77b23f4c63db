#include "server/import/rgbd/depth_links.h"

#include <math.h>
#include <stdlib.h>

static size_t pixel_at(const struct depth_map *m, int32_t x, int32_t y)
{
    return (size_t)y * (size_t)m->width + (size_t)x;
}

static bool is_inside(const struct depth_map *m, int32_t x, int32_t y)
{
    return x >= 0 && y >= 0 && x < m->width && y < m->height;
}

float depth_links_inverse(const struct depth_links *l, int32_t x, int32_t y)
{
    if (!is_inside(l->map, x, y)) return 0;
    const float z = l->map->z[pixel_at(l->map, x, y)];
    return z > 0 ? 1 / z : 0;
}

static bool is_same(const struct depth_links *l, int32_t x, int32_t y, int32_t dx, int32_t dy)
{
    const float a = depth_links_inverse(l, x, y), b = depth_links_inverse(l, x + dx, y + dy);
    if (!(a > 0 && b > 0)) return false;
    const float z = 1 / fmaxf(a, b), near = (4 * depth_noise_m(z) + 0.005f * z) * a * b;
    if (fabsf(a - b) <= near) return true;
    const float before = depth_links_inverse(l, x - dx, y - dy);
    const float after = depth_links_inverse(l, x + 2 * dx, y + 2 * dy);
    return (before > 0 && fabsf(2 * a - before - b) <= near) ||
           (after > 0 && fabsf(2 * b - after - a) <= near);
}

int depth_links_find(const struct depth_map *map, struct depth_links *out)
{
    const size_t pixels = (size_t)map->width * (size_t)map->height;
    *out = (struct depth_links){.map = map, .of = malloc(pixels)};
    if (out->of == NULL) return ERR_MEMORY;
    for (int32_t y = 0; y < map->height; y++)
        for (int32_t x = 0; x < map->width; x++)
            out->of[pixel_at(map, x, y)] =
                (uint8_t)((is_same(out, x, y, 1, 0) ? DEPTH_LINK_RIGHT : 0) |
                          (is_same(out, x, y, 0, 1) ? DEPTH_LINK_DOWN : 0));
    return 0;
}

void depth_links_fini(struct depth_links *links)
{
    free(links->of);
    *links = (struct depth_links){NULL};
}

bool depth_links_has(const struct depth_links *l, int32_t x, int32_t y, uint8_t link)
{
    return is_inside(l->map, x, y) && l->of[pixel_at(l->map, x, y)] & link;
}

float depth_links_slope(const struct depth_links *l, int32_t x, int32_t y, uint8_t axis,
                        int32_t reach_px)
{
    const int32_t dx = axis == DEPTH_LINK_RIGHT, dy = 1 - dx;
    int32_t first = 0, last = 0;
    float sum = 0, weights = 0;
    while (first > -reach_px &&
           depth_links_has(l, x + (first - 1) * dx, y + (first - 1) * dy, axis))
        first--;
    while (last < reach_px && depth_links_has(l, x + last * dx, y + last * dy, axis)) last++;
    const float middle = 0.5f * (float)(first + last);
    for (int32_t k = first; k <= last; k++) {
        const float off = (float)k - middle;
        sum += off * depth_links_inverse(l, x + k * dx, y + k * dy);
        weights += off * off;
    }
    return weights > 0 ? sum / weights : 0;
}
