#pragma once
/* The estimate of shadow_kernels: sum of I G V over sum of I G at a pixel's strata. */
#include "proto/pattern.h"
#include "proto/plan.h"
#include "server/reconstruct/shadow/shadow_lanes.h"
#include "server/reconstruct/simd/gaussian_lanes.h"
#include "server/reconstruct/simd/lanes_inline.h"

#define ESTIMATE_NEAR_MOST 1e9f /* (size / distance)^2 */

/* Adjacent receivers, as they were given. SHADOW_LANES elements of each array may be read. */
struct estimate_receivers {
    const float *point[3], *normal[3], *jitter[2];
    const uint32_t *bits;
    size_t stride;
};

/* The last receivers, padded with some that have no normal. */
struct estimate_rest {
    _Alignas(64) float numbers[8][SHADOW_LANES];
    uint32_t bits[SHADOW_STRATA_MAX * SHADOW_STRATA_MAX / 32][SHADOW_LANES];
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
    r->stride = SHADOW_LANES;
}

static inline lanes_mask estimate_words(const uint32_t *from)
{
    lanes_mask out;
    memcpy(&out, from, sizeof out);
    return out;
}

/* Returns whether each receiver sees all of the light or none of it. Then out[i] is 1 or 0. */
static inline bool estimate_is_plain(const struct estimate_receivers *r, uint32_t strata,
                                     float out[SHADOW_LANES])
{
    struct lanes_whole mixed;
    for (int v = 0; v < LANES_VECTORS; v++) {
        const size_t at = (size_t)v * LANES_PER_VECTOR;
        lanes_mask some = {0}, missing = {0};
        for (uint32_t k = 0; k < strata; k += 32) {
            const uint32_t left = strata - k, all = left < 32 ? (1u << left) - 1 : 0xffffffffu;
            const lanes_mask word = estimate_words(r->bits + k / 32 * r->stride + at);
            some |= word & (int32_t)all;
            missing |= ~word & (int32_t)all;
        }
        mixed.v[v] = (some != 0) & (missing != 0);
        *(lanes_stored *)(out + at) = lanes_where(some != 0, lanes_all(1.0f).v[v]);
    }
    return !lanes_any(&mixed);
}

/* Adjacent receivers, and sums over their strata. */
struct estimate_chunk {
    struct lanes to[3], normal[3];
    struct lanes seen, all, count;
};

/* A place along an axis of the light, in [-1, 1], and a Gaussian light's profile there. */
struct estimate_place {
    lanes_vector at, profile;
};

/* Adds one stratum of vector i. I G lacks the factors that all strata share. It is in units of the
 * light's size and bounded, so that squares of squares stay finite. */
LANES_INLINE void estimate_add(const struct shadow_rectangle *light, bool gaussian, int i,
                               const struct estimate_place *u, const struct estimate_place *v,
                               lanes_chosen seen, struct estimate_chunk *c)
{
    const float hu = light->half[0], hv = light->half[1], size2 = hu * hu + hv * hv;
    const float *a = light->axis[0], *b = light->axis[1];
    const lanes_vector one = lanes_all(1.0f).v[0], most = lanes_all(ESTIMATE_NEAR_MOST).v[0];
    const lanes_vector along = u->at * hu, aside = v->at * hv;
    lanes_vector to[3];
    for (int k = 0; k < 3; k++)
        to[k] = lanes_fused(aside, lanes_same(b[k]),
                            lanes_fused(along, lanes_same(a[k]), c->to[k].v[i]));
    const lanes_vector normal[3] = {c->normal[0].v[i], c->normal[1].v[i], c->normal[2].v[i]};
    const lanes_vector up = lanes_dot(to, normal), squared = lanes_dot(to, to);
    /* of 0 it is infinite, and counts nothing below */
    const lanes_vector bounded = lanes_least(size2 / squared, most);
    const lanes_vector facing = gaussian ? u->profile * v->profile * up : up;
    const lanes_chosen counts =
        lanes_below(lanes_same(0.0f), up) & lanes_below(lanes_same(0.0f), squared);
    const lanes_vector weight = lanes_only(counts, facing * (bounded * bounded));
    c->all.v[i] += weight;
    c->seen.v[i] = lanes_add_to(c->seen.v[i], seen, weight);
    c->count.v[i] = lanes_add_to(c->count.v[i], seen, one);
}

/* Returns the place of stratum k of l along an axis. */
LANES_INLINE struct estimate_place estimate_stratum(bool gaussian, const float *jitter, uint32_t l,
                                                    uint32_t k)
{
    const lanes_vector most = lanes_same(PATTERN_JITTER_MAX);
    const lanes_vector within = lanes_least(lanes_load_vector(jitter), most); /* as pattern_axis */
    const lanes_vector at =
        lanes_fused((float)k + within, lanes_same(2.0f / (float)l), lanes_same(-1.0f));
    return (struct estimate_place){at, gaussian ? gaussian_exp_minus_lanes(2.0f * at * at) : at};
}

/* Sums the strata of vector i. */
LANES_INLINE void estimate_sum(const struct shadow_rectangle *light, bool gaussian, uint32_t l,
                               const struct estimate_receivers *r, int i, struct estimate_chunk *c)
{
    const size_t from = (size_t)i * LANES_PER_VECTOR;
    struct estimate_place u[SHADOW_STRATA_MAX];
    for (int k = 0; k < 3; k++) {
        c->to[k].v[i] = light->centre[k] - lanes_load_vector(r->point[k] + from);
        c->normal[k].v[i] = lanes_load_vector(r->normal[k] + from);
    }
    c->seen.v[i] = c->all.v[i] = c->count.v[i] = lanes_same(0.0f);
    for (uint32_t a = 0; a < l; a++) u[a] = estimate_stratum(gaussian, r->jitter[0] + from, l, a);
    for (uint32_t k = 0, b = 0; b < l; b++) {
        const struct estimate_place v = estimate_stratum(gaussian, r->jitter[1] + from, l, b);
        for (uint32_t a = 0; a < l; a++, k++) {
            const lanes_mask words = estimate_words(r->bits + k / 32 * r->stride + from);
            estimate_add(light, gaussian, i, &u[a], &v, lanes_with(words, (int32_t)(1u << k % 32)),
                         c);
        }
    }
}

/* Computes the seen share, by number where no stratum has weight. */
static inline void estimate_share(const struct estimate_chunk *c, float strata,
                                  float out[SHADOW_LANES])
{
    for (int i = 0; i < LANES_VECTORS; i++) {
        const lanes_mask any = c->all.v[i] > 0.0f;
        const lanes_vector all = lanes_select(any, c->all.v[i], lanes_all(strata).v[0]);
        *(lanes_stored *)(out + (size_t)i * LANES_PER_VECTOR) =
            lanes_select(any, c->seen.v[i], c->count.v[i]) / all;
    }
}

/* Sums all strata. Loops over nine strata are unrolled, so that their steps overlap. */
LANES_INLINE void estimate_profile(const struct shadow_rectangle *light, bool gaussian, uint32_t l,
                                   const struct estimate_receivers *r, struct estimate_chunk *c)
{
    for (int i = 0; i < LANES_VECTORS; i++) {
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
    for (size_t first = 0; first < count; first += SHADOW_LANES) {
        const size_t left = count - first, n = left < SHADOW_LANES ? left : SHADOW_LANES;
        struct estimate_receivers r = estimate_receivers_at(&all, first);
        _Alignas(64) float answer[SHADOW_LANES];
        if (n < SHADOW_LANES) estimate_fill(&r, n, l * l, &rest);
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
