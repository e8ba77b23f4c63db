#include "worker/trace/field/lens_surface.h"

#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "proto/shared_exponent.h"
#include "worker/trace/hit/block_store.h"
#include "worker/trace/hit/hit_kernels.h"

/* Apart from those of the albedo. */
#define LOBE_BITS 0x5bd1e995u

/* Finds the light that fields bring, as the sample's own path has found it, with albedo taken
 * out. */
static void find_light(const struct path_context *c, const struct path_radiance *h, size_t slot,
                       float out[3])
{
    const struct path_rgb *direct = &h->diffuse_direct, *indirect = &h->diffuse_indirect;
    const bool all = c->plan->lens_relight != LENS_RELIGHT_INDIRECT;
    const float light[3] = {indirect->r[slot] + (all ? direct->r[slot] : 0.0f),
                            indirect->g[slot] + (all ? direct->g[slot] : 0.0f),
                            indirect->b[slot] + (all ? direct->b[slot] : 0.0f)};
    for (int k = 0; k < 3; k++) out[k] = light[k] < INFINITY ? light[k] : 0.0f;
}

/* Leaves nothing of pure Lambert surfaces, and the radiance of the other lobes on others. Values
 * that are not finite stay so, and are counted later. The exact albedo is used although the plane's
 * is rounded: the rounding is random, so its mean is right, and no remainder is clamped at 0. */
void lens_surface_take_out(const struct path_context *c, size_t slot, struct path_radiance *h)
{
    struct path_rgb *left = &h->indirect;
    const struct path_rgb *albedo = &h->albedo, *brought = &h->diffuse_indirect;
    if (c->plan->lens_relight == LENS_RELIGHT_DIFFUSE) {
        struct path_rgb *direct = &h->direct;
        const bool good = direct->r[slot] + direct->g[slot] + direct->b[slot] < INFINITY;
        if (good) direct->r[slot] = direct->g[slot] = direct->b[slot] = 0.0f;
        const bool finite = left->r[slot] + left->g[slot] + left->b[slot] < INFINITY;
        if (finite) left->r[slot] = left->g[slot] = left->b[slot] = 0.0f;
        return;
    }
    if (c->plan->lens_relight == LENS_RELIGHT_SKY) {
        struct path_rgb *direct = &h->direct;
        const struct path_rgb *soft = &h->diffuse_direct;
        direct->r[slot] = fmaxf(direct->r[slot] - albedo->r[slot] * soft->r[slot], 0.0f);
        direct->g[slot] = fmaxf(direct->g[slot] - albedo->g[slot] * soft->g[slot], 0.0f);
        direct->b[slot] = fmaxf(direct->b[slot] - albedo->b[slot] * soft->b[slot], 0.0f);
    }
    left->r[slot] = fmaxf(left->r[slot] - albedo->r[slot] * brought->r[slot], 0.0f);
    left->g[slot] = fmaxf(left->g[slot] - albedo->g[slot] * brought->g[slot], 0.0f);
    left->b[slot] = fmaxf(left->b[slot] - albedo->b[slot] * brought->b[slot], 0.0f);
}

/* Bits by which a sample's albedo is rounded: of the pixel and the sample alone, so that neither
 * tiles nor all samples of a surface have them in common. */
static uint32_t rounding_of(const struct path_context *c, const struct block *b, size_t lane,
                            uint32_t sample)
{
    const struct pattern *p = &c->plan->pattern;
    const uint32_t key = path_key(p->seed, p->frame, b->x_px[lane], b->y_px[lane]);
    return path_mix(key + 0x9e3779b9u * (sample + 1));
}

static void lanes_of(const struct path_rgb *in, size_t first, struct lanes3 *out)
{
    memcpy(out->x, in->r + first, sizeof out->x);
    memcpy(out->y, in->g + first, sizeof out->y);
    memcpy(out->z, in->b + first, sizeof out->z);
}

void lens_surface_store(const struct path_context *c, const struct block *b, size_t first,
                        uint32_t sample, struct path_radiance *h, struct samples *samples)
{
    _Alignas(LANES_ALIGN) float depth[LANES];
    _Alignas(LANES_ALIGN) uint32_t packed[LANES];
    struct lanes3 normal;
    uint16_t normals[LANES];
    uint32_t albedos[LANES], lights[LANES], lobes[LANES];
    if (c->plan->lens_relight == LENS_RELIGHT_OWN) return;
    lanes_of(&h->normal, first, &normal);
    c->queries->kernels->pack_normals(&normal, 8, packed);
    for (size_t i = 0; i < LANES; i++) {
        const size_t k = first + i;
        const bool met = h->ahead[k] > 0.0f && h->ahead[k] < INFINITY;
        const float albedo[3] = {h->albedo.r[k], h->albedo.g[k], h->albedo.b[k]};
        const float lobe[3] = {h->lobe.r[k], h->lobe.g[k], h->lobe.b[k]};
        const uint32_t bits = rounding_of(c, b, i, sample);
        float light[3];
        find_light(c, h, k, light);
        for (int n = 0; n < 3; n++) light[n] *= c->plan->radiance_scale;
        depth[i] = met ? h->ahead[k] : 0.0f;
        normals[i] = met ? (uint16_t)packed[i] : 0;
        albedos[i] = shared_exponent_pack_random(albedo, SHARED_EXPONENT_9, bits);
        lights[i] = shared_exponent_pack(light, SHARED_EXPONENT_8);
        lobes[i] = shared_exponent_pack_random(lobe, SHARED_EXPONENT_9, bits ^ LOBE_BITS);
        lens_surface_take_out(c, k, h);
    }
    block_store_positive_half(b, depth, 1.0f / c->plan->length_unit,
                              samples_u16(samples, PLANE_LENS_DEPTH, sample));
    block_store_u16(b, normals, samples_u16(samples, PLANE_LENS_NORMAL, sample));
    block_store_u32(b, albedos, samples_u32(samples, PLANE_LENS_ALBEDO, sample));
    block_store_u32(b, lights, samples_u32(samples, PLANE_LENS_OWN_LIGHT, sample));
    if (c->skip & SKIP_GLOSSY_OF_LENS)
        block_store_u32(b, lobes, samples_u32(samples, PLANE_LENS_LOBE, sample));
}
