#include "server/reconstruct/shadow/shadow_error.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/shadow/shadow.h"

/* Neighbours of one surface: the cosine between their normals, the difference of their depths. */
#define COSINE_MIN  0.9f
#define DEPTH_SHARE 0.05f

/* Walsh functions of x and y, which know nothing of each other: where one is odd, samples come from
 * the next pixel along an axis, where it is even. */
#define HALVINGS 4
static bool is_odd(int halving, int32_t x, int32_t y)
{
    static const int32_t shift[HALVINGS][2] = {{0, 0}, {0, 1}, {1, 0}, {0, 8}};
    return ((x >> shift[halving][0]) + (y >> shift[halving][1])) & 1;
}

/* Steps that change is_odd. */
static const int32_t steps[HALVINGS][2] = {{1, 0}, {1, 0}, {0, 1}, {1, 0}};

static bool same_surface(const struct patch *p, size_t i, size_t k)
{
    const float cosine = p->normal[0][i] * p->normal[0][k] + p->normal[1][i] * p->normal[1][k] +
                         p->normal[2][i] * p->normal[2][k];
    return cosine > COSINE_MIN && fabsf(p->depth[i] - p->depth[k]) < DEPTH_SHARE * p->depth[i];
}

/* Where pixel (x, y) takes its samples from. */
static size_t source_of(const struct patch *p, int halving, int32_t x, int32_t y)
{
    const size_t i = patch_pixel(p, x, y);
    const int32_t way = (x >> 1 ^ y >> 1) & 1 ? 1 : -1; /* or shadows would move */
    const int32_t u = x + way * steps[halving][0], v = y + way * steps[halving][1];
    const bool inside = u >= p->rect.x0 && u < p->rect.x1 && v >= p->rect.y0 && v < p->rect.y1;
    if (!is_odd(halving, x, y) || !inside) return i;
    const size_t k = patch_pixel(p, u, v);
    return same_surface(p, i, k) ? k : i;
}

static void halve(const struct patch *p, const uint8_t *from, size_t bytes, int halving,
                  uint8_t *to)
{
    const size_t area = (size_t)rect_area(p->rect);
    for (int32_t y = p->rect.y0; y < p->rect.y1; y++)
        for (int32_t x = p->rect.x0; x < p->rect.x1; x++) {
            const size_t i = patch_pixel(p, x, y), k = source_of(p, halving, x, y);
            for (size_t b = 0; b < bytes; b++) to[b * area + i] = from[b * area + k];
        }
}

static void add_squares(const struct patch *p, struct rect inner, const float *whole,
                        const float *half, float *variance)
{
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        const size_t first = patch_pixel(p, inner.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(inner); i++) {
            const float off = half[i] - whole[i];
            variance[i] += off * off / HALVINGS;
        }
    }
}

int shadow_error_add(const struct plan *plan, uint32_t light, const struct patch *patch,
                     struct rect inner, const float *irradiance, float *variance)
{
    const uint32_t l = plan->lights[light].strata_per_axis;
    const size_t area = (size_t)rect_area(patch->rect), bytes = (l * l + 7) / 8;
    struct patch part = *patch;
    struct shadow_statistics again = {0}; /* of pixels that are counted already */
    float *half = scratch_take(patch->scratch, area * (sizeof *half + bytes));
    int error = half ? 0 : ERR_MEMORY;
    uint8_t *visibility = (uint8_t *)(half + area);
    part.lights[light].visibility = visibility;
    for (int k = 0; k < HALVINGS && !error; k++) {
        halve(patch, patch->lights[light].visibility, bytes, k, visibility);
        error = shadow_filter(plan, light, &part, inner, half, NULL, &again);
        if (!error) add_squares(patch, inner, irradiance, half, variance);
    }
    scratch_give(patch->scratch, half);
    return error;
}
