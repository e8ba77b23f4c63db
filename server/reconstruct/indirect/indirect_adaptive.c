#include "server/reconstruct/indirect/indirect_adaptive.h"

#include <math.h>

#include "server/reconstruct/indirect/indirect_field.h"

#define LN_2        0.69314718055994531
#define HALF_PI     1.57079632679489662
#define RAYS_BEYOND 1e9f /* more than any pixel gets */
#define WIDTH_MAX   1e30f
#define FIT_END     50.0f /* exponent */

#define ALPHA_SQUARED_MIN 1e-8f

struct indirect_bandlimit indirect_bandlimit_lambert(void)
{
    return (struct indirect_bandlimit){INDIRECT_OMEGA_LAMBERT, INDIRECT_GAMMA_LAMBERT};
}

/* e^x - 1, x in [0, 1]. */
static double grown(double x)
{
    double term = x, sum = x;
    for (int k = 2; k < 24; k++) sum += term *= x / k;
    return sum;
}

/* x in [0, 1]: halved three times, where a few powers suffice. */
static double arc_tangent(double x)
{
    double power, sum;
    for (int i = 0; i < 3; i++) x = x / (1.0 + sqrt(1.0 + x * x));
    power = sum = x;
    for (int k = 3; k < 24; k += 2) {
        power *= -x * x;
        sum += power / k;
    }
    return 8.0 * sum;
}

/* The cosine of what holds 80 % of a lobe's energy is c^(1/m) with c = cos(45 degrees), so its
 * tangent is sqrt(2^(1/m) - 1), at most 1. It does without the C library's powers, whose bits
 * depend on the CPU. */
static float gamma_of(float exponent)
{
    const double m = exponent > 1.0f ? (double)exponent : 1.0;
    return (float)(arc_tangent(sqrt(grown(LN_2 / m))) / HALF_PI);
}

struct indirect_bandlimit indirect_bandlimit_blinn_phong(float exponent)
{
    return (struct indirect_bandlimit){3.6f + 0.084f * exponent, gamma_of(exponent)};
}

struct indirect_bandlimit indirect_bandlimit_facets(float alpha)
{
    const float m = 2.0f / fmaxf(alpha * alpha, ALPHA_SQUARED_MIN) - 2.0f;
    struct indirect_bandlimit band = indirect_bandlimit_blinn_phong(fminf(fmaxf(m, 0.0f), FIT_END));
    if (!(m > FIT_END)) return band;
    return (struct indirect_bandlimit){band.omega * sqrtf(m / FIT_END), gamma_of(m)};
}

float indirect_adaptive_width(const struct indirect_bandlimit *band, float mu,
                              const struct indirect_span *span)
{
    const float free = 2.0f * span->near / (mu * band->omega);
    const float least = 2.0f * span->pixel / (mu * INDIRECT_ADAPTIVE_WIDTH_ALPHA);
    return fminf(fmaxf(free, least), WIDTH_MAX);
}

float indirect_adaptive_rays(const struct indirect_bandlimit *band, float mu,
                             const struct indirect_span *span)
{
    const float x = mu * band->omega * (span->pixel / span->near) + INDIRECT_ADAPTIVE_ALPHA;
    const float v = band->omega * (1.0f + mu * (span->far / span->near));
    return fminf(band->gamma * (x * x) * (v * v), RAYS_BEYOND);
}

float indirect_adaptive_width_mu(float mu)
{
    return mu > 1.0f ? mu : 1.0f;
}

/* Returns the least rays of a pixel that has `first`. */
static float least_rays(float mu, uint32_t first)
{
    const float by = indirect_adaptive_width_mu(mu);
    return (float)first * (by * by * by);
}

uint32_t indirect_adaptive_strata(float rays, uint32_t first, uint32_t most)
{
    if (!(rays > (float)first) || most <= first) return 0;
    const float asked = fminf(rays, (float)most) - (float)first;
    uint32_t l = (uint32_t)(sqrtf(asked) + 0.5f);
    while (l > PLAN_STRATA_MAX || l * l > most - first) l--;
    return l;
}

/* One call. Spares: z_far, both pooled. */
struct adaptive {
    const struct plan *plan;
    struct rect inner;
    const struct patch *patch;
    struct indirect_neighbourhood *around;
    const float *alpha; /* of lobes, in the patch; NULL: of Lambert receivers */
    float near_px;
};

/* Nearest distances are pooled as for widths, by their inverses; farthest ones as they are: a pixel
 * in a crack, whose rays all end at once, must not make others look as if all were near. */
static void load_far(const struct adaptive *a)
{
    const struct rect all = a->around->rect;
    const struct patch *patch = a->patch;
    for (int32_t y = all.y0; y < all.y1; y++) {
        const size_t to = indirect_neighbourhood_index(a->around, all.x0, y);
        const float *far = patch->bounce_distance_max + patch_pixel(patch, all.x0, y);
        const float *near = a->around->nearness + to;
        float *out = indirect_neighbourhood_spare(a->around, 0) + to;
        for (size_t i = 0; i < (size_t)rect_width(all); i++)
            out[i] = near[i] > 0.0f ? far[i] : 0.0f;
    }
}

static uint32_t strata_of(const struct adaptive *a, const struct indirect_bandlimit *band,
                          float near, float far, float pixel)
{
    const uint32_t l = a->plan->indirect_strata_per_axis;
    if (!(pixel > 0.0f && near > 0.0f && far > 0.0f)) return 0;
    const float least = a->near_px * pixel;
    const struct indirect_span span = {fmaxf(1.0f / near, least), fmaxf(far, least), pixel};
    const float mu = a->plan->adaptive.mu, rays = indirect_adaptive_rays(band, mu, &span);
    return indirect_adaptive_strata(fmaxf(rays, least_rays(mu, l * l)), l * l,
                                    a->plan->adaptive.rays_max);
}

static void find_row(const struct adaptive *a, const struct indirect_kernels *kernels, int32_t y,
                     uint8_t *strata_map)
{
    const struct indirect_run run =
        indirect_neighbourhood_run(a->around, a->inner, y, false, INDIRECT_NEAR_PX);
    float *near = indirect_neighbourhood_spare(a->around, 1),
          *far = indirect_neighbourhood_spare(a->around, 2);
    kernels->nearness(&a->around->field, &run, a->around->nearness, near);
    kernels->nearness(&a->around->field, &run, indirect_neighbourhood_spare(a->around, 0), far);
    const size_t from = patch_pixel(a->patch, a->inner.x0, y);
    struct indirect_bandlimit band = indirect_bandlimit_lambert();
    float of = -1.0f; /* whose band it is; runs of equal alphas are common */
    for (size_t i = 0; i < (size_t)rect_width(a->inner); i++) {
        if (a->alpha && a->alpha[from + i] != of)
            band = indirect_bandlimit_facets(of = a->alpha[from + i]);
        strata_map[i] = (uint8_t)strata_of(a, &band, near[run.first + i], far[run.first + i],
                                           a->around->pixel[run.first + i]);
    }
}

static int find(const struct plan *plan, const struct patch *patch, const float *alpha,
                struct rect inner, uint8_t *strata_map)
{
    struct indirect_neighbourhood around;
    const struct rect common = rect_intersect(inner, patch->rect);
    const bool has = patch->depth && patch->normal[0] && patch->id && patch->bounce_distance_min &&
                     patch->bounce_distance_max;
    if (!has || rect_is_empty(inner) || rect_area(common) != rect_area(inner)) return ERR_RANGE;
    const struct rect seen = rect_intersect(rect_grow(inner, INDIRECT_NEAR_PX), patch->rect);
    const int error =
        indirect_neighbourhood_create(plan, patch, seen, INDIRECT_NEAR_PX, 3, &around);
    if (error) return error;
    const float lines = (float)plan->height_px / INDIRECT_ADAPTIVE_LINES;
    const struct adaptive a = {.plan = plan,
                               .inner = inner,
                               .patch = patch,
                               .around = &around,
                               .alpha = alpha,
                               .near_px = INDIRECT_ADAPTIVE_NEAR_PX * lines};
    load_far(&a);
    for (int32_t y = inner.y0; y < inner.y1; y++, strata_map += rect_width(inner))
        find_row(&a, KERNELS_BEST(indirect_kernels), y, strata_map);
    indirect_neighbourhood_fini(&around);
    return 0;
}

int indirect_adaptive_find(const struct plan *plan, const struct patch *patch, struct rect inner,
                           uint8_t *strata_map)
{
    return find(plan, patch, NULL, inner, strata_map);
}

int indirect_adaptive_find_lobes(const struct plan *plan, const struct patch *patch,
                                 struct rect inner, uint8_t *strata_map)
{
    struct patch lobes = *patch;
    if (!patch->glossy_alpha) return ERR_RANGE;
    lobes.bounce_distance_min = patch->glossy_near;
    lobes.bounce_distance_max = patch->glossy_far;
    return find(plan, &lobes, patch->glossy_alpha, inner, strata_map);
}
