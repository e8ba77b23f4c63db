#include "worker/trace/field/half_field.h"

#include <math.h>

static bool is_node(const struct block *b, int i)
{
    return half_field_is_node(b->x_px[i], b->y_px[i]);
}

/* Returns the nodes of the block that stand for lane i: 0 unless all beside it, also around the
 * block, show its surface. */
static uint16_t find_nodes(const struct block *b, const struct lanes_mask *lit,
                           const struct half_field *half, int i)
{
    const int32_t x = b->x_px[i], y = b->y_px[i];
    uint32_t nodes = 0;
    for (int k = 0; k < LANES; k++) {
        if (!is_node(b, k) || !half_field_is_beside(x, y, b->x_px[k], b->y_px[k])) continue;
        if (!lit->on[k] ||
            surface_match(&half->ring.view, &half->shown[i], &half->shown[k]) < HALF_FIELD_MATCH)
            return 0;
        nodes |= 1u << k;
    }
    return half_field_ring_shows(&half->ring, b->x_px[0], b->y_px[0], x, y, &half->shown[i])
               ? (uint16_t)nodes
               : 0;
}

void half_field_init(const struct block *block, const struct surface *surface,
                     const struct lanes_mask *lit, struct half_field *half)
{
    for (int i = 0; i < LANES; i++)
        if (lit->on[i])
            half_field_show(&half->ring.view, surface, i, block->x_px[i], block->y_px[i],
                            &half->shown[i]);
    for (int i = 0; i < LANES; i++) {
        const bool node = is_node(block, i);
        half->nodes[i] = lit->on[i] && !node ? find_nodes(block, lit, half, i) : 0;
        half->waiting.on[i] = node ? 0 : lit->on[i] & block->kept.on[i];
        half->traced.on[i] = node ? lit->on[i] & block->inside.on[i] : 0;
    }
}

/* Whoever waits traces if *more says so, or if no nodes stand for it. */
static void settle(uint64_t rays, struct half_field *half, struct lanes_mask *more,
                   struct counters *counters)
{
    uint64_t anew = 0, taken = 0;
    for (int i = 0; i < LANES; i++) {
        more->on[i] = half->waiting.on[i] & (more->on[i] | -(half->nodes[i] == 0));
        anew += (uint64_t)(more->on[i] & 1);
        taken += (uint64_t)(half->waiting.on[i] & ~more->on[i] & 1);
        half->traced.on[i] |= more->on[i];
    }
    counters->value[COUNTER_RAYS_ANEW] += anew * rays;
    counters->value[COUNTER_SKIPPED_HALF_FIELD] += taken * rays;
}

void half_field_refine(const float *nearest, uint32_t strata, struct half_field *half,
                       struct lanes_mask *more, struct counters *counters)
{
    const float near_px = half_field_near_px(strata);
    for (int i = 0; i < LANES; i++) {
        float least = INFINITY;
        for (int k = 0; k < LANES; k++)
            if (half->nodes[i] >> k & 1) least = fminf(least, nearest[k]);
        const float seen = half->nodes[i] ? half->shown[i].distance : 0.0f;
        const float size = surface_pixel_size(&half->ring.view, seen);
        more->on[i] = -(least < near_px * size);
    }
    settle((uint64_t)strata * strata, half, more, counters);
}

static struct half_field_lobe lobe_of(const struct half_field *half,
                                      const struct glossy_lobes *lobes, const float *nearness,
                                      int i)
{
    return (struct half_field_lobe){.surface = half->shown[i],
                                    .alpha = lobes->alpha[i],
                                    .stretch = lobes->stretch[i],
                                    .nearness = nearness[i]};
}

/* Returns whether a node of lane i sees what it would see. */
static bool is_seen(const struct half_field *half, const struct glossy_lobes *lobes,
                    const float *nearness, float most, int i)
{
    const struct half_field_lobe own = lobe_of(half, lobes, nearness, i);
    for (int k = 0; k < LANES; k++) {
        if (!(half->nodes[i] >> k & 1)) continue;
        const struct half_field_lobe node = lobe_of(half, lobes, nearness, k);
        if (half_field_apart2(&half->ring.view, &own, &node) <= most) return true;
    }
    return false;
}

void half_field_refine_lobes(const struct glossy_lobes *lobes, const float *nearness,
                             uint32_t strata, struct half_field *half, struct lanes_mask *more,
                             struct counters *counters)
{
    const float most = half_field_apart2_most(strata);
    for (int i = 0; i < LANES; i++)
        more->on[i] = -(half->nodes[i] != 0 && !is_seen(half, lobes, nearness, most, i));
    settle((uint64_t)strata * strata, half, more, counters);
}
