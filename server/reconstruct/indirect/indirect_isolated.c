#include "server/reconstruct/indirect/indirect_isolated.h"

#include <math.h>

#define ALIKE_MIN    2    /* of four neighbours, for a surface that filters follow */
#define COSINE_ABOUT 0.5f /* others face within 60 degrees */
#define OFF_ABOUT_PX 8.0f /* and are off the plane by less */

struct window {
    const struct patch *patch;
    const struct indirect_neighbourhood *around;
    const float *const *in;
    int32_t reach;
    float rays; /* of a pixel */
};

/* How another pixel lies to pixel p. */
struct relation {
    float cosine, off;
};

static struct relation relate(const struct indirect_neighbourhood *f, size_t p, size_t q)
{
    struct relation r = {0};
    for (int k = 0; k < 3; k++) {
        const float n = f->normal[k][p];
        r.cosine += n * f->normal[k][q];
        r.off += n * (f->point[k][q] - f->point[k][p]);
    }
    r.off = fabsf(r.off);
    return r;
}

static bool is_alike(const struct indirect_neighbourhood *f, size_t p, struct relation r)
{
    return r.cosine >= INDIRECT_COS && r.off <= f->field.off[p];
}

static bool is_isolated(const struct indirect_neighbourhood *f, size_t p, bool left, bool right,
                        bool above, bool below)
{
    const size_t at[4] = {p - 1, p + 1, p - (size_t)f->field.stride, p + (size_t)f->field.stride};
    const bool there[4] = {left, right, above, below};
    int alike = 0;
    for (int k = 0; k < 4 && alike < ALIKE_MIN; k++)
        if (there[k] && f->pixel[at[k]] > 0.0f) alike += is_alike(f, p, relate(f, p, at[k]));
    return alike < ALIKE_MIN;
}

/* Sums of the window: [0] over the pixel's surface, [1] over others, by how alike they are. */
struct sums {
    float light[2][3], rays[2];
};

static void add(const struct window *w, size_t p, size_t q, size_t from, float weight,
                struct sums *sums)
{
    const struct indirect_neighbourhood *f = w->around;
    const struct relation r = relate(f, p, q);
    const int other = !is_alike(f, p, r);
    if (other) {
        const float turn = (r.cosine - COSINE_ABOUT) / (1.0f - COSINE_ABOUT);
        const float near = 1.0f - r.off / (OFF_ABOUT_PX * f->pixel[p]); /* measured: above 0 */
        if (!(turn > 0.0f) || !(near > 0.0f)) return;
        weight *= turn * turn * near;
    }
    for (int c = 0; c < 3; c++) sums->light[other][c] += weight * w->in[c][from];
    sums->rays[other] += weight * w->rays;
}

static void fill(const struct window *w, int32_t x, int32_t y, float *const *out)
{
    const struct indirect_neighbourhood *f = w->around;
    const struct rect window =
        rect_intersect(rect_grow((struct rect){x, y, x + 1, y + 1}, w->reach), f->rect);
    const size_t p = indirect_neighbourhood_index(f, x, y);
    const float square = (float)((w->reach + 1) * (w->reach + 1));
    struct sums s = {.rays = {0}};
    for (int32_t v = window.y0; v < window.y1; v++)
        for (int32_t u = window.x0; u < window.x1; u++) {
            const size_t q = indirect_neighbourhood_index(f, u, v);
            const float weight = 1.0f - (float)((u - x) * (u - x) + (v - y) * (v - y)) / square;
            if (weight > 0.0f && f->pixel[q] > 0.0f)
                add(w, p, q, patch_pixel(w->patch, u, v), weight, &s);
        }
    const float lacks = fmaxf(INDIRECT_ISOLATED_RAYS - s.rays[0], 0.0f);
    const float take = s.rays[1] > lacks ? lacks / s.rays[1] : 1.0f;
    const float all = (s.rays[0] + take * s.rays[1]) / w->rays; /* the pixel itself counts 1 */
    if (!(all > 0.0f)) return;                                  /* without a normal: nor is it */
    for (int c = 0; c < 3; c++) out[c][p] = (s.light[0][c] + take * s.light[1][c]) / all;
}

uint64_t indirect_isolated_fill(const struct plan *plan, const struct patch *patch,
                                const struct indirect_neighbourhood *around, struct rect inner,
                                int32_t reach, const float *const *in, float *const *out)
{
    const uint32_t l = plan->indirect_strata_per_axis;
    const struct window w = {patch, around, in, reach, (float)(l * l)};
    const struct rect r = around->rect;
    uint64_t isolated = 0;
    for (int32_t y = inner.y0; y < inner.y1; y++)
        for (int32_t x = inner.x0; x < inner.x1; x++) {
            const size_t p = indirect_neighbourhood_index(around, x, y);
            if (!(around->pixel[p] > 0.0f) ||
                !is_isolated(around, p, x > r.x0, x + 1 < r.x1, y > r.y0, y + 1 < r.y1))
                continue;
            fill(&w, x, y, out);
            isolated++;
        }
    return isolated;
}
