#include "server/reconstruct/lens_lend.h"

#include <immintrin.h>
#include <math.h>

/* Less than this of the pixels around is nobody's surface. */
#define WEIGHT_MIN 1e-3f

static bool has_lighting(const struct patch *patch, size_t i)
{
    return patch->depth[i] > 0.0f && (!patch->reflector || patch->reflector[i] > 0.0f);
}

/* A row, whose points px, py, pz are. */
static void place_row(struct lens_lenders *l, int32_t y, const float *px, const float *py,
                      const float *pz)
{
    const struct patch *p = l->patch;
    const size_t first = patch_pixel(p, l->rect.x0, y);
    struct lens_lender *out = l->pixels + (size_t)(y - l->rect.y0) * l->width;
    for (size_t x = 0; x < l->width; x++) {
        const size_t i = first + x;
        const float a = p->normal[0][i], b = p->normal[1][i], c = p->normal[2][i];
        const float *const *light = (const float *const *)l->lighting->total;
        out[x] = (struct lens_lender){{0}, {0}};
        if (!has_lighting(p, i)) continue;
        out[x].plane = (lens_quad){a, b, c, a * px[x] + b * py[x] + c * pz[x]};
        out[x].light = (lens_quad){light[0][i], light[1][i], light[2][i], p->depth[i]};
    }
}

int lens_lenders_create(const struct plan *plan, const struct patch *patch,
                        const struct lighting *lighting, struct rect rect, struct lens_lenders *out)
{
    const size_t area = (size_t)rect_area(rect), width = (size_t)rect_width(rect);
    struct lens_lenders *l = out;
    *l = (struct lens_lenders){.patch = patch, .lighting = lighting, .rect = rect, .width = width};
    l->pixels = scratch_take(patch->scratch, area * sizeof *l->pixels + 3 * width * sizeof(float));
    if (!l->pixels) return ERR_MEMORY;
    float *px = (float *)(void *)(l->pixels + area), *py = px + width, *pz = py + width;
    surface_view_init(&l->view, plan);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        surface_points(&l->view, rect.x0, y, (uint32_t)width,
                       patch->depth + patch_pixel(patch, rect.x0, y), px, py, pz);
        place_row(l, y, px, py, pz);
    }
    return 0;
}

/* Nearly all samples are plainly on the surface of all four pixels around: surface_match is 1, and
 * no root tells so. */
static bool lend_plainly(const struct lens_lenders *l, const struct lens_borrower *s,
                         lens_quad *light)
{
    if (s->column < 0 || s->column + 1 >= (int32_t)l->width || s->row < 0 ||
        s->row + 1 >= rect_height(l->rect))
        return false;
    const struct lens_lender *a = l->pixels + (size_t)s->row * l->width + (size_t)s->column;
    const struct lens_lender *b = a + l->width;
    const float *point = s->surface.point, *normal = s->surface.normal;
    __m128 x = a[0].plane, y = a[1].plane, z = b[0].plane, d = b[1].plane;
    _MM_TRANSPOSE4_PS(x, y, z, d);
    const lens_quad off = x * point[0] + y * point[1] + z * point[2] - d;
    const lens_quad cosine = x * normal[0] + y * normal[1] + z * normal[2];
    const lens_quad none = {0}, allowed = none + s->allowed;
    const __m128 same =
        (__m128)((off <= allowed) & (-off <= allowed) & (cosine >= none + SURFACE_COS_FULL));
    if (_mm_movemask_ps(same) != 15) return false;
    const float right = s->across, left = 1.0f - right;
    *light = (1.0f - s->down) * (left * a[0].light + right * a[1].light) +
             s->down * (left * b[0].light + right * b[1].light);
    return true;
}

static float match(const struct lens_lenders *l, const struct lens_borrower *s, int32_t column,
                   int32_t row, const struct lens_lender *pixel)
{
    const float distance = pixel->light[3];
    struct surface surface = {.distance = distance,
                              .normal = {pixel->plane[0], pixel->plane[1], pixel->plane[2]}};
    if (!(distance > 0.0f)) return 0.0f;
    surface_points(&l->view, l->rect.x0 + column, l->rect.y0 + row, 1, &distance, &surface.point[0],
                   &surface.point[1], &surface.point[2]);
    return surface_match(&l->view, &s->surface, &surface);
}

static bool lend_some(const struct lens_lenders *l, const struct lens_borrower *s, float light[3])
{
    lens_quad sum = {0};
    float weights = 0.0f;
    for (int32_t k = 0; k < 4; k++) {
        const int32_t x = s->column + (k & 1), y = s->row + (k >> 1);
        if (x < 0 || x >= (int32_t)l->width || y < 0 || y >= rect_height(l->rect)) continue;
        const struct lens_lender *pixel = l->pixels + (size_t)y * l->width + (size_t)x;
        const float weight = (k & 1 ? s->across : 1.0f - s->across) *
                             (k >> 1 ? s->down : 1.0f - s->down) * match(l, s, x, y, pixel);
        if (!(weight > 0.0f)) continue;
        sum += weight * pixel->light;
        weights += weight;
    }
    if (!(weights > WEIGHT_MIN)) return false;
    for (int c = 0; c < 3; c++) light[c] = sum[c] / weights;
    return true;
}

bool lens_lend(const struct lens_lenders *l, const struct lens_borrower *sample, float light[3])
{
    lens_quad all;
    if (!lend_plainly(l, sample, &all)) return lend_some(l, sample, light);
    for (int c = 0; c < 3; c++) light[c] = all[c];
    return true;
}
