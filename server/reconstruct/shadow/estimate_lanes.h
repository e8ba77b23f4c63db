#pragma once
/* The estimate of shadow_kernels: sum of I G V over sum of I G at a pixel's strata. */
#include "proto/pattern.h"
#include "proto/plan.h"
#include "server/reconstruct/shadow/shadow_lanes.h"
#include "server/reconstruct/simd/gaussian_lanes.h"
#include "server/reconstruct/simd/inline.h"

#define ESTIMATE_NEAR_MAX 1e9f /* (size / distance)^2 */

/* Adjacent receivers, as they were given. SIMD_LANES elements of each array may be read. */
struct estimate_receivers {
    const float *point[3], *normal[3], *jitter[2];
    const uint32_t *bits;
    size_t stride;
};

/* The last receivers, padded with some that have no normal. */
struct estimate_rest {
    _Alignas(64) float numbers[8][SIMD_LANES];
    uint32_t bits[SHADOW_STRATA_MAX * SHADOW_STRATA_MAX / 32][SIMD_LANES];
};

static inline struct estimate_receivers estimate_receivers_at(const struct estimate_receivers *all,
                                                              size_t first)
{
    struct estimate_receivers r = {.bits = all->bits + first, .stride = all->stride};
    for (int k = 0; k < 3; k++) {
        r.point[k] = all->point[k] + first;
        r.normal[k] = all->normal[k] + first;
    }
    for (int k = 0; k < 2; k++) r.jitter[k] = all->jitter[k] + first;
    return r;
}

/* Copies `count` receivers to where there is room for all lanes. */
static inline void estimate_fill(struct estimate_receivers *r, size_t count, uint32_t strata,
                                 struct estimate_rest *rest)
{
    const float **numbers[] = {&r->point[0],  &r->point[1],  &r->point[2],  &r->normal[0],
                               &r->normal[1], &r->normal[2], &r->jitter[0], &r->jitter[1]};
    *rest = (struct estimate_rest){0};
    for (size_t k = 0; k < 8; k++) {
        memcpy(rest->numbers[k], *numbers[k], count * sizeof(float));
        *numbers[k] = rest->numbers[k];
    }
    for (size_t k = 0; k < (strata + 31) / 32; k++)
        memcpy(rest->bits[k], r->bits + k * r->stride, count * sizeof(uint32_t));
    r->bits = rest->bits[0];
    r->stride = SIMD_LANES;
}

static inline simd_mask estimate_words(const uint32_t *from)
{
    simd_mask out;
    memcpy(&out, from, sizeof out);
    return out;
}

/* Returns whether each receiver sees all of the light or none of it. Then out[i] is 1 or 0. */
static inline bool estimate_is_plain(const struct estimate_receivers *r, uint32_t strata,
                                     float out[SIMD_LANES])
{
    struct simd_whole mixed;
    for (int v = 0; v < SIMD_VECTORS; v++) {
        const size_t at = (size_t)v * SIMD_PER_VECTOR;
        simd_mask some = {0}, missing = {0};
        for (uint32_t k = 0; k < strata; k += 32) {
            const uint32_t left = strata - k, all = left < 32 ? (1u << left) - 1 : 0xffffffffu;
            const simd_mask word = estimate_words(r->bits + k / 32 * r->stride + at);
            some |= word & (int32_t)all;
            missing |= ~word & (int32_t)all;
        }
        mixed.v[v] = (some != 0) & (missing != 0);
        *(simd_stored *)(out + at) = simd_where(some != 0, simd_all(1.0f).v[v]);
    }
    return !simd_any(&mixed);
}

/* Adjacent receivers, and sums over their strata. */
struct estimate_chunk {
    struct simd to[3], normal[3];
    struct simd seen, all, count;
};

/* A place along an axis of the light, in [-1, 1], and a Gaussian light's profile there. */
struct estimate_place {
    simd_vector at, profile;
};

/* Adds one stratum of vector i. I G lacks the factors that all strata share. It is in units of the
 * light's size and bounded, so that squares of squares stay finite. */
SIMD_INLINE void estimate_add(const struct shadow_rectangle *light, bool gaussian, int i,
                              const struct estimate_place *u, const struct estimate_place *v,
                              simd_chosen seen, struct estimate_chunk *c)
{
    const float hu = light->half[0], hv = light->half[1], size2 = hu * hu + hv * hv;
    const float *a = light->axis[0], *b = light->axis[1];
    const simd_vector one = simd_all(1.0f).v[0], most = simd_all(ESTIMATE_NEAR_MAX).v[0];
    const simd_vector along = u->at * hu, aside = v->at * hv;
    simd_vector to[3];
    for (int k = 0; k < 3; k++)
        to[k] =
            simd_fused(aside, simd_same(b[k]), simd_fused(along, simd_same(a[k]), c->to[k].v[i]));
    const simd_vector normal[3] = {c->normal[0].v[i], c->normal[1].v[i], c->normal[2].v[i]};
    const simd_vector up = simd_dot(to, normal), squared = simd_dot(to, to);
    /* of 0 it is infinite, and counts nothing below */
    const simd_vector bounded = simd_min(size2 / squared, most);
    const simd_vector facing = gaussian ? u->profile * v->profile * up : up;
    const simd_chosen counts =
        simd_below(simd_same(0.0f), up) & simd_below(simd_same(0.0f), squared);
    const simd_vector weight = simd_only(counts, facing * (bounded * bounded));
    c->all.v[i] += weight;
    c->seen.v[i] = simd_add_to(c->seen.v[i], seen, weight);
    c->count.v[i] = simd_add_to(c->count.v[i], seen, one);
}

/* Returns the place of stratum k of l along an axis. */
SIMD_INLINE struct estimate_place estimate_stratum(bool gaussian, const float *jitter, uint32_t l,
                                                   uint32_t k)
{
    const simd_vector most = simd_same(PATTERN_JITTER_MAX);
    const simd_vector within = simd_min(simd_load_vector(jitter), most); /* as pattern_axis */
    const simd_vector at =
        simd_fused((float)k + within, simd_same(2.0f / (float)l), simd_same(-1.0f));
    return (struct estimate_place){at, gaussian ? gaussian_exp_minus_lanes(2.0f * at * at) : at};
}

/* Sums the strata of vector i. */
SIMD_INLINE void estimate_sum(const struct shadow_rectangle *light, bool gaussian, uint32_t l,
                              const struct estimate_receivers *r, int i, struct estimate_chunk *c)
{
    const size_t from = (size_t)i * SIMD_PER_VECTOR;
    struct estimate_place u[SHADOW_STRATA_MAX];
    for (int k = 0; k < 3; k++) {
        c->to[k].v[i] = light->centre[k] - simd_load_vector(r->point[k] + from);
        c->normal[k].v[i] = simd_load_vector(r->normal[k] + from);
    }
    c->seen.v[i] = c->all.v[i] = c->count.v[i] = simd_same(0.0f);
    for (uint32_t a = 0; a < l; a++) u[a] = estimate_stratum(gaussian, r->jitter[0] + from, l, a);
    for (uint32_t k = 0, b = 0; b < l; b++) {
        const struct estimate_place v = estimate_stratum(gaussian, r->jitter[1] + from, l, b);
        for (uint32_t a = 0; a < l; a++, k++) {
            const simd_mask words = estimate_words(r->bits + k / 32 * r->stride + from);
            estimate_add(light, gaussian, i, &u[a], &v, simd_with(words, (int32_t)(1u << k % 32)),
                         c);
        }
    }
}

/* Computes the seen share, by number where no stratum has weight. */
static inline void estimate_share(const struct estimate_chunk *c, float strata,
                                  float out[SIMD_LANES])
{
    for (int i = 0; i < SIMD_VECTORS; i++) {
        const simd_mask any = c->all.v[i] > 0.0f;
        const simd_vector all = simd_select(any, c->all.v[i], simd_all(strata).v[0]);
        *(simd_stored *)(out + (size_t)i * SIMD_PER_VECTOR) =
            simd_select(any, c->seen.v[i], c->count.v[i]) / all;
    }
}

/* Sums all strata. Loops over nine strata are unrolled, so that their steps overlap. */
SIMD_INLINE void estimate_profile(const struct shadow_rectangle *light, bool gaussian, uint32_t l,
                                  const struct estimate_receivers *r, struct estimate_chunk *c)
{
    for (int i = 0; i < SIMD_VECTORS; i++) {
        if (l == 3)
            estimate_sum(light, gaussian, 3, r, i, c);
        else
            estimate_sum(light, gaussian, l, r, i, c);
    }
}

static void kernel_estimate(const struct shadow_rectangle *light, uint32_t l, uint32_t count,
                            const float *const point[3], const float *const normal[3],
                            const float *const jitter[2], const uint32_t *bits, size_t stride,
                            float *out)
{
    const struct estimate_receivers all = {{point[0], point[1], point[2]},
                                           {normal[0], normal[1], normal[2]},
                                           {jitter[0], jitter[1]},
                                           bits,
                                           stride};
    struct estimate_rest rest;
    struct estimate_chunk c;
    for (size_t first = 0; first < count; first += SIMD_LANES) {
        const size_t left = count - first, n = left < SIMD_LANES ? left : SIMD_LANES;
        struct estimate_receivers r = estimate_receivers_at(&all, first);
        _Alignas(64) float answer[SIMD_LANES];
        if (n < SIMD_LANES) estimate_fill(&r, n, l * l, &rest);
        if (!estimate_is_plain(&r, l * l, answer)) {
            if (light->profile == PROFILE_GAUSSIAN)
                estimate_profile(light, true, l, &r, &c);
            else
                estimate_profile(light, false, l, &r, &c);
            estimate_share(&c, (float)(l * l), answer);
        }
        memcpy(out + first, answer, n * sizeof *out);
    }
}
