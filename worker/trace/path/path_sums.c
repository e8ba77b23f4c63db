#include "worker/trace/path/path_sums.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "worker/trace/hit/block_store.h"

void path_sums_init(struct path_sums *s, const struct plan_pass *pass, uint32_t edge_digits,
                    uint64_t planes)
{
    memset(s, 0, sizeof *s);
    s->edge_digits = edge_digits;
    s->first = pass->first << edge_digits;
    s->parts = plan_pass_split(pass);
    s->parts.first <<= edge_digits;
    s->parts.length <<= edge_digits;
    s->splits = (planes & PLANE_BIT(PATH_HALF_DIFFERENCE2)) != 0;
    s->halves = (planes & PLANES_RESIDUAL) != 0;
}

void path_sums_init_lens(struct path_sums *s, uint32_t strata, uint64_t planes)
{
    const struct plan_pass pass = {.count = strata * strata};
    path_sums_init(s, &pass, 0, planes);
    s->lens_strata = strata;
}

static void clear(struct path_rgb *c, size_t slot)
{
    c->r[slot] = c->g[slot] = c->b[slot] = 0.0f;
}

/* Marks lanes whose numbers are not finite. Comparisons are false for NaN. */
static void mark_odd(const struct path_rgb *c, size_t first, uint32_t odd[LANES])
{
    const float *r = c->r + first, *g = c->g + first, *b = c->b + first;
    for (int i = 0; i < LANES; i++)
        odd[i] |= (uint32_t) !((r[i] < INFINITY) & (g[i] < INFINITY) & (b[i] < INFINITY));
}

/* Sets samples that are not finite to black. None is negative, since lights, albedos and weights
 * are not. */
static void reject(struct path_radiance *h, size_t first, struct counters *counters)
{
    struct path_rgb *const all[] = {&h->emission, &h->direct, &h->indirect, &h->diffuse_direct,
                                    &h->diffuse_indirect};
    uint32_t odd[LANES] = {0}, any = 0;
    for (int k = 0; k < 5; k++) mark_odd(all[k], first, odd);
    for (int i = 0; i < LANES; i++) any |= odd[i];
    for (size_t i = 0; any && i < LANES; i++) {
        if (odd[i] == 0) continue;
        for (int k = 0; k < 5; k++) clear(all[k], first + i);
        counters->value[COUNTER_REJECTED_NOT_FINITE]++;
    }
}

static void add(const struct path_rgb *c, size_t first, struct lanes3 *sum)
{
    for (size_t i = 0; i < LANES; i++) {
        sum->x[i] += c->r[first + i];
        sum->y[i] += c->g[first + i];
        sum->z[i] += c->b[first + i];
    }
}

/* Welford's update (1962): no cancellation, whatever the mean. */
static inline void update(float value, float share, float *sum, float *mean, float *spread)
{
    float off = value - *mean;
    *sum += value;
    *mean += off * share;
    *spread += off * (value - *mean);
}

static void add_radiance(const struct path_radiance *h, size_t first, struct path_sums *s)
{
    const struct path_rgb *e = &h->emission, *d = &h->direct, *n = &h->indirect;
    const float share = 1.0f / (float)s->count;
    for (size_t i = 0; i < LANES; i++) {
        size_t k = first + i;
        update(e->r[k] + d->r[k] + n->r[k], share, &s->radiance.x[i], &s->mean.x[i],
               &s->spread.x[i]);
        update(e->g[k] + d->g[k] + n->g[k], share, &s->radiance.y[i], &s->mean.y[i],
               &s->spread.y[i]);
        update(e->b[k] + d->b[k] + n->b[k], share, &s->radiance.z[i], &s->mean.z[i],
               &s->spread.z[i]);
    }
}

/* Finds where in its part the latest sample is. Returns false if it is in none. */
static bool find_part(const struct path_sums *s, uint32_t *at)
{
    const uint32_t sample = s->first + s->count - 1, length = s->parts.length;
    if (sample < s->parts.first || sample >= s->parts.first + length * s->parts.count) return false;
    *at = (sample - s->parts.first) % length;
    return true;
}

static void end_part(struct path_sums *s)
{
    for (int i = 0; i < LANES; i++)
        s->split_squares[i] += s->split.x[i] * s->split.x[i] + s->split.y[i] * s->split.y[i] +
                               s->split.z[i] * s->split.z[i];
    memset(&s->split, 0, sizeof s->split);
}

static void add_split(const struct path_radiance *h, size_t first, struct path_sums *s)
{
    const struct path_rgb *e = &h->emission, *d = &h->direct, *n = &h->indirect;
    uint32_t at;
    if (!find_part(s, &at)) return;
    const float sign = at < s->parts.length / 2 ? 1.0f : -1.0f;
    for (size_t i = 0; i < LANES; i++) {
        size_t k = first + i;
        s->split.x[i] += sign * (e->r[k] + d->r[k] + n->r[k]);
        s->split.y[i] += sign * (e->g[k] + d->g[k] + n->g[k]);
        s->split.z[i] += sign * (e->b[k] + d->b[k] + n->b[k]);
    }
    if (at == s->parts.length - 1) end_part(s);
}

/* Returns whether the latest sample is of half a. */
static bool is_of_half(const struct path_sums *s)
{
    const uint32_t l = s->lens_strata, sample = s->first + s->count - 1;
    uint32_t at;
    if (l > 0) return plan_lens_half(l, sample);
    return find_part(s, &at) && at < s->parts.length / 2;
}

/* Adds what the residual filter reads: features of the first surface, and sums over half the
 * samples. */
static void add_halves(const struct path_radiance *h, size_t first, struct path_sums *s)
{
    add(&h->normal, first, &s->normal);
    add(&h->tint, first, &s->tint);
    for (size_t i = 0; i < LANES; i++) s->distance[i] += h->distance[first + i];
    for (size_t i = 0; i < LANES; i++) s->alpha[i] += h->alpha[first + i];
    if (!is_of_half(s)) return;
    add(&h->direct, first, &s->half_scattered);
    add(&h->indirect, first, &s->half_scattered);
    add(&h->diffuse_direct, first, &s->half_direct);
    add(&h->diffuse_indirect, first, &s->half_indirect);
}

/* Features of samples that strayed count where there are no others, and hardly beside them. */
#define STRAYED_WEIGHT 0x1p-12f

static void scale_slot(struct path_rgb *c, size_t slot, float by)
{
    c->r[slot] *= by;
    c->g[slot] *= by;
    c->b[slot] *= by;
}

static void weigh_features(struct path_radiance *h, size_t first, struct path_sums *s)
{
    for (size_t i = 0; i < LANES; i++) {
        const size_t slot = first + i;
        s->weight[i] += h->coverage[slot] * (h->strayed[slot] ? STRAYED_WEIGHT : 1.0f);
        if (!h->strayed[slot]) continue;
        scale_slot(&h->albedo, slot, STRAYED_WEIGHT);
        scale_slot(&h->normal, slot, STRAYED_WEIGHT);
        scale_slot(&h->tint, slot, STRAYED_WEIGHT);
        h->distance[slot] *= STRAYED_WEIGHT;
        h->alpha[slot] *= STRAYED_WEIGHT;
    }
}

/* Adds the diffuse part of what came after the first scattering, without albedo: direct light that
 * was found by scattering, and all indirect light. */
static void add_demodulated(const struct path_radiance *h, size_t first, struct path_sums *s)
{
    add(&h->diffuse_direct, first, &s->diffuse_direct);
    add(&h->diffuse_indirect, first, &s->diffuse_indirect);
}

void path_sums_add(struct path_sums *s, struct path_radiance *h, uint32_t count, bool demodulate,
                   struct counters *counters)
{
    for (uint32_t k = 0; k < count; k++) {
        size_t first = (size_t)k * LANES;
        reject(h, first, counters);
        s->count++;
        add_radiance(h, first, s);
        if (s->splits) add_split(h, first, s);
        if (s->halves) weigh_features(h, first, s);
        if (s->halves) add_halves(h, first, s);
        add(&h->emission, first, &s->emission);
        add(&h->direct, first, &s->direct);
        add(&h->indirect, first, &s->indirect);
        add(&h->albedo, first, &s->albedo);
        if (demodulate) add_demodulated(h, first, s);
        for (size_t i = 0; i < LANES; i++) {
            s->coverage[i] += h->coverage[first + i];
            s->occlusion[i] += h->occlusion[first + i];
        }
    }
}

static void store(const struct lanes3 *v, const struct block *b, struct samples *samples,
                  enum plane_id plane)
{
    block_store_f32(b, v->x, samples_f32(samples, plane, 0));
    block_store_f32(b, v->y, samples_f32(samples, plane, 1));
    block_store_f32(b, v->z, samples_f32(samples, plane, 2));
}

static void store_split(const struct path_sums *s, const struct block *b, struct samples *samples)
{
    _Alignas(LANES_ALIGN) float squares[LANES];
    for (int i = 0; i < LANES; i++) squares[i] = fminf(s->split_squares[i], FLT_MAX);
    block_store_f32(b, squares, samples_f32(samples, PLANE_PATH_HALF_DIFFERENCE2, 0));
}

static void scale(struct lanes3 *v, float by)
{
    for (int i = 0; i < LANES; i++) v->x[i] *= by, v->y[i] *= by, v->z[i] *= by;
}

static void scale_lane(struct lanes3 *v, int i, float by)
{
    v->x[i] *= by;
    v->y[i] *= by;
    v->z[i] *= by;
}

/* Sums of what is scattered, and of features of what scatters. */
enum { SCATTERED = 10 };

static void list_scattered(struct path_sums *s, struct lanes3 *out[SCATTERED])
{
    out[0] = &s->direct, out[1] = &s->indirect;
    out[2] = &s->diffuse_direct, out[3] = &s->diffuse_indirect;
    out[4] = &s->half_scattered, out[5] = &s->half_direct, out[6] = &s->half_indirect;
    out[7] = &s->albedo, out[8] = &s->normal, out[9] = &s->tint;
}

static void cover_lane(struct path_sums *s, int i, float by)
{
    struct lanes3 *sums[SCATTERED];
    list_scattered(s, sums);
    for (int k = 0; k < SCATTERED; k++) scale_lane(sums[k], i, by);
    s->coverage[i] *= by;
    s->weight[i] *= by;
    s->distance[i] *= by;
    s->alpha[i] *= by;
}

void path_sums_see(struct path_sums *s, const struct lanes_mask *on, const struct lanes3 *emission,
                   const float coverage[LANES], uint32_t count)
{
    const float part = (float)s->count / (float)(s->count + count);
    for (int i = 0; i < LANES; i++) {
        const float e[3] = {(s->emission.x[i] + emission->x[i]) * part,
                            (s->emission.y[i] + emission->y[i]) * part,
                            (s->emission.z[i] + emission->z[i]) * part};
        if (!on->on[i] || !(e[0] < INFINITY && e[1] < INFINITY && e[2] < INFINITY)) continue;
        if (s->coverage[i] == 0.0f && coverage[i] > 0.0f) continue;
        if (s->coverage[i] > 0.0f)
            cover_lane(s, i, (s->coverage[i] + coverage[i]) * part / s->coverage[i]);
        s->emission.x[i] = e[0];
        s->emission.y[i] = e[1];
        s->emission.z[i] = e[2];
        s->radiance.x[i] = e[0] + (s->direct.x[i] + s->indirect.x[i]);
        s->radiance.y[i] = e[1] + (s->direct.y[i] + s->indirect.y[i]);
        s->radiance.z[i] = e[2] + (s->direct.z[i] + s->indirect.z[i]);
    }
}

/* Makes sums of so many samples of those of more. The spread is such that a mean of so many is as
 * uncertain as it is of more. */
static void count_as_fewer(struct path_sums *s)
{
    struct lanes3 *sums[SCATTERED];
    const float by = 1.0f / (float)(1u << s->edge_digits), all = (float)s->count, few = all * by;
    list_scattered(s, sums);
    for (int k = 0; k < SCATTERED; k++) scale(sums[k], by);
    scale(&s->radiance, by);
    scale(&s->emission, by);
    scale(&s->spread, few > 1.0f ? by * (few - 1.0f) / (all - 1.0f) : 0.0f);
    for (int i = 0; i < LANES; i++) {
        s->coverage[i] *= by;
        s->occlusion[i] *= by;
        s->distance[i] *= by;
        s->alpha[i] *= by;
        s->split_squares[i] *= by * by;
    }
}

/* Makes sums over all samples that show something of weighted ones. */
static void spread_features(struct path_sums *s)
{
    for (int i = 0; i < LANES; i++) {
        if (s->weight[i] == s->coverage[i] || !(s->weight[i] > 0.0f)) continue;
        const float by = s->coverage[i] / s->weight[i];
        struct lanes3 *const features[] = {&s->albedo, &s->normal, &s->tint};
        for (int k = 0; k < 3; k++)
            features[k]->x[i] *= by, features[k]->y[i] *= by, features[k]->z[i] *= by;
        s->distance[i] *= by;
        s->alpha[i] *= by;
    }
}

void path_sums_store(struct path_sums *s, const struct block *b, struct samples *samples)
{
    if (s->halves) spread_features(s);
    if (s->edge_digits > 0) count_as_fewer(s);
    store(&s->radiance, b, samples, PLANE_PATH_RADIANCE);
    store(&s->spread, b, samples, PLANE_PATH_M2);
    store_split(s, b, samples);
    store(&s->emission, b, samples, PLANE_PATH_EMISSION);
    store(&s->direct, b, samples, PLANE_PATH_DIRECT);
    store(&s->indirect, b, samples, PLANE_PATH_INDIRECT);
    store(&s->diffuse_direct, b, samples, PLANE_PATH_DIFFUSE_DIRECT);
    store(&s->diffuse_indirect, b, samples, PLANE_PATH_DIFFUSE_INDIRECT);
    store(&s->albedo, b, samples, PLANE_PATH_ALBEDO);
    store(&s->half_scattered, b, samples, PLANE_PATH_HALF_SCATTERED);
    store(&s->half_direct, b, samples, PLANE_PATH_HALF_DIRECT);
    store(&s->half_indirect, b, samples, PLANE_PATH_HALF_INDIRECT);
    store(&s->normal, b, samples, PLANE_PATH_NORMAL);
    store(&s->tint, b, samples, PLANE_PATH_TINT);
    block_store_f32(b, s->alpha, samples_f32(samples, PLANE_PATH_TINT, 3));
    block_store_f32(b, s->distance, samples_f32(samples, PLANE_PATH_DISTANCE, 0));
    block_store_f32(b, s->coverage, samples_f32(samples, PLANE_PATH_COVERAGE, 0));
    block_store_f32(b, s->occlusion, samples_f32(samples, PLANE_PATH_VISIBILITY, 0));
}
