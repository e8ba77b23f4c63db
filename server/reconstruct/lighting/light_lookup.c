#include "server/reconstruct/lighting/light_lookup.h"

#include <immintrin.h>
#include <math.h>
#include <string.h>

#include "proto/lens_lobe.h"

#define ALL 15

/* The least sum of weights. Below it a sample has no pixel of its surface around. */
#define WEIGHT_MIN 1e-3f

static bool has_lighting(const struct patch *patch, size_t i)
{
    return patch->depth[i] > 0.0f &&
           (!patch->bounce_distance_min || patch->bounce_distance_min[i] > 0.0f);
}

/* Loads a row, whose points are px, py, pz. */
static void place_row(struct light_lookup *l, int32_t y, const float *px, const float *py,
                      const float *pz)
{
    const struct patch *p = l->patch;
    const size_t first = patch_pixel(p, l->rect.x0, y);
    struct light_lookup_pixel *out = l->pixels + (size_t)(y - l->rect.y0 + 1) * l->width + 1;
    for (size_t x = 0; x < (size_t)rect_width(l->rect); x++) {
        const size_t i = first + x;
        const float a = p->normal[0][i], b = p->normal[1][i], c = p->normal[2][i];
        const float *const *light = (const float *const *)l->lighting->total;
        out[x] = (struct light_lookup_pixel){.plane = {0}};
        if (!has_lighting(p, i)) continue;
        out[x].plane = (lens_quad){a, b, c, a * px[x] + b * py[x] + c * pz[x]};
        out[x].light = (lens_quad){light[0][i], light[1][i], light[2][i], p->depth[i]};
        out[x].point = (lens_quad){px[x], py[x], pz[x], 0.0f};
        if (!l->lobes) continue;
        const float *const *gloss = (const float *const *)l->lighting->glossy;
        const float alpha = patch_is_glossy(p, i) ? p->glossy_alpha[i] : 0.0f;
        l->lobes[out + x - l->pixels] = (lens_quad){gloss[0][i], gloss[1][i], gloss[2][i], alpha};
    }
}

static void clear_edges(struct light_lookup *l)
{
    const size_t rows = (size_t)rect_height(l->rect) + LIGHT_LOOKUP_BESIDE, all = l->width;
    const size_t bytes = sizeof *l->pixels;
    if (l->lobes) memset(l->lobes, 0, rows * all * sizeof *l->lobes);
    memset(l->pixels, 0, all * bytes);
    for (size_t y = 1; y < rows - 2; y++) {
        memset(l->pixels + y * all, 0, bytes);
        memset(l->pixels + (y + 1) * all - 2, 0, 2 * bytes);
    }
    memset(l->pixels + (rows - 2) * all, 0, 2 * all * bytes);
}

int light_lookup_create(const struct plan *plan, const struct patch *patch,
                        const struct lighting *lighting, struct rect rect, struct light_lookup *out)
{
    const size_t width = (size_t)rect_width(rect), all = width + LIGHT_LOOKUP_BESIDE;
    const size_t area = all * ((size_t)rect_height(rect) + LIGHT_LOOKUP_BESIDE);
    struct light_lookup *l = out;
    *l = (struct light_lookup){.patch = patch, .lighting = lighting, .rect = rect, .width = all};
    const size_t lobes = patch->lens_lobe ? area : 0;
    l->pixels = scratch_take(patch->scratch, area * sizeof *l->pixels + lobes * sizeof *l->lobes +
                                                 3 * width * sizeof(float));
    if (!l->pixels) return ERR_MEMORY;
    lens_quad *const after = (lens_quad *)(void *)(l->pixels + area);
    if (lobes > 0) l->lobes = after;
    float *px = (float *)(void *)(after + lobes), *py = px + width, *pz = py + width;
    surface_view_init(&l->view, plan);
    clear_edges(l);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        surface_points(&l->view, rect.x0, y, (uint32_t)width,
                       patch->depth + patch_pixel(patch, rect.x0, y), px, py, pz);
        place_row(l, y, px, py, pz);
    }
    return 0;
}

/* Pixels around a sample, the upper left one's bit lowest: those plainly on its surface, so that
 * surface_match is 1, which no root needs to tell, and those that face elsewhere. */
struct surface_matches {
    int same, other;
};

static inline struct surface_matches compare(const struct light_lookup_pixel *a,
                                             const struct light_lookup_pixel *b,
                                             const struct lens_relight_row *s, uint32_t i)
{
    __m128 x = a[0].plane, y = a[1].plane, z = b[0].plane, d = b[1].plane;
    _MM_TRANSPOSE4_PS(x, y, z, d);
    const lens_quad off = x * s->point[0][i] + y * s->point[1][i] + z * s->point[2][i] - d;
    const lens_quad cosine = x * s->normal[0][i] + y * s->normal[1][i] + z * s->normal[2][i];
    __m128 px = a[0].point, py = a[1].point, pz = b[0].point, unused = b[1].point;
    _MM_TRANSPOSE4_PS(px, py, pz, unused);
    const lens_quad own = (px - s->point[0][i]) * s->normal[0][i] +
                          (py - s->point[1][i]) * s->normal[1][i] +
                          (pz - s->point[2][i]) * s->normal[2][i];
    const lens_quad none = {0}, allowed = none + s->off[i];
    const __m128 same = (__m128)((off <= allowed) & (-off <= allowed) & (own <= allowed) &
                                 (-own <= allowed) & (cosine >= none + SURFACE_COS_FULL));
    const __m128 other = (__m128)(cosine <= none + SURFACE_COS_NONE);
    return (struct surface_matches){_mm_movemask_ps(same), _mm_movemask_ps(other)};
}

/* Returns how near a pixel's point is to the plane of the sample. It is 1 up to 1.5 pixels plus a
 * small part of the distance between them, and 0 from 1.5 times that. A bent surface is as near one
 * pixel aside. */
static float near_plane(const struct light_lookup *l, const struct shown_surface *sample,
                        const struct shown_surface *pixel)
{
    float off = 0.0f, square = 0.0f;
    for (int c = 0; c < 3; c++) {
        const float d = pixel->point[c] - sample->point[c];
        off += d * sample->normal[c];
        square += d * d;
    }
    const float allowed = SURFACE_PLANE_PX * surface_pixel_size(&l->view, sample->distance) +
                          SURFACE_SLACK * sqrtf(square);
    const float near = (SURFACE_FADE - fabsf(off) / allowed) / (SURFACE_FADE - 1.0f);
    return near > 0.0f ? fminf(near, 1.0f) : 0.0f;
}

static float match(const struct light_lookup *l, const struct shown_surface *sample,
                   const struct light_lookup_pixel *pixel)
{
    const float distance = pixel->light[3];
    struct shown_surface surface = {.distance = distance,
                                    .normal = {pixel->plane[0], pixel->plane[1], pixel->plane[2]}};
    if (!(distance > 0.0f)) return 0.0f;
    for (int c = 0; c < 3; c++) surface.point[c] = pixel->point[c];
    return fminf(surface_match(&l->view, sample, &surface), near_plane(l, sample, &surface));
}

/* Four pixels around a sample, the upper left one first: how much of each it takes, as far as they
 * are on its surface. */
struct weights {
    float of[4], sum;
};

static struct weights weigh(const struct light_lookup *l, const struct lens_relight_row *s,
                            uint32_t i, struct surface_matches like)
{
    const struct shown_surface sample = {
        .point = {s->point[0][i], s->point[1][i], s->point[2][i]},
        .normal = {s->normal[0][i], s->normal[1][i], s->normal[2][i]},
        .distance = s->distance[i],
    };
    const float across = s->across[i], down = s->down[i];
    struct weights w = {.sum = 0.0f};
    for (int32_t k = 0; k < 4; k++) {
        const int32_t x = s->column[i] + (k & 1), y = s->row[i] + (k >> 1);
        if (like.other >> k & 1) continue;
        const float matches = like.same >> k & 1
                                  ? 1.0f
                                  : match(l, &sample, l->pixels + (size_t)y * l->width + (size_t)x);
        const float weight =
            (k & 1 ? across : 1.0f - across) * (k >> 1 ? down : 1.0f - down) * matches;
        w.of[k] = weight > 0.0f ? weight : 0.0f;
        w.sum += w.of[k];
    }
    return w;
}

/* Looks up radiance of lobes from pixels whose lobes are like that of the nearest with one. Other
 * lobes have other directions, and pixels without a lobe have light from all around. If none has a
 * lobe, that is used. */
static void look_up_lobes(const lens_quad *a, const lens_quad *b, const struct weights *w,
                          float gloss[3])
{
    const lens_quad *const of[4] = {a, a + 1, b, b + 1};
    float most = 0.0f, own = 0.0f, weights = 0.0f;
    for (int k = 0; k < 4; k++)
        if ((*of[k])[3] > 0.0f && w->of[k] > most) most = w->of[k], own = (*of[k])[3];
    lens_quad sum = {0};
    for (int k = 0; k < 4; k++) {
        const float alpha = (*of[k])[3];
        if (own > 0.0f && !lens_lobes_alike(alpha, own)) continue;
        sum += w->of[k] * *of[k];
        weights += w->of[k];
    }
    for (int c = 0; c < 3; c++) gloss[c] = sum[c] / weights;
}

static bool look_up_some(const struct light_lookup *l, const struct lens_relight_row *s, uint32_t i,
                         struct surface_matches like, float light[3], float gloss[3])
{
    const struct weights w = weigh(l, s, i, like);
    const size_t at = (size_t)s->row[i] * l->width + (size_t)s->column[i];
    const struct light_lookup_pixel *const a = l->pixels + at, *const b = a + l->width;
    if (!(w.sum > WEIGHT_MIN)) return false;
    const lens_quad sum =
        w.of[0] * a[0].light + w.of[1] * a[1].light + w.of[2] * b[0].light + w.of[3] * b[1].light;
    for (int c = 0; c < 3; c++) light[c] = sum[c] / w.sum;
    if (l->lobes) look_up_lobes(l->lobes + at, l->lobes + at + l->width, &w, gloss);
    return true;
}

bool light_lookup_at(const struct light_lookup *l, const struct lens_relight_row *row, uint32_t i,
                     float light[3], float gloss[3])
{
    const struct light_lookup_pixel *a =
        l->pixels + (size_t)row->row[i] * l->width + (size_t)row->column[i];
    const struct light_lookup_pixel *b = a + l->width;
    const struct surface_matches like = compare(a, b, row, i);
    if (like.other == ALL) return false;
    if (like.same != ALL) return look_up_some(l, row, i, like, light, gloss);
    const float right = row->across[i], left = 1.0f - right, down = row->down[i];
    const lens_quad all = (1.0f - down) * (left * a[0].light + right * a[1].light) +
                          down * (left * b[0].light + right * b[1].light);
    for (int c = 0; c < 3; c++) light[c] = all[c];
    if (!l->lobes) return true;
    const struct weights w = {
        {(1.0f - down) * left, (1.0f - down) * right, down * left, down * right}, 1.0f};
    look_up_lobes(l->lobes + (a - l->pixels), l->lobes + (b - l->pixels), &w, gloss);
    return true;
}
