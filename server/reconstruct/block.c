#include "server/reconstruct/block.h"

#include <time.h>

#include "server/reconstruct/compose.h"
#include "server/reconstruct/paths.h"

/* Small blocks let the picture form bit by bit and many threads work at it. With a filter's halo
 * they repeat work: of the sheared filter's time, blocks of 64 cost 1.25 times and blocks of 256
 * 0.85 times as much as those of 128; of memory, 1.6 times as much for 256. Those are for pictures
 * that are still cut into BLOCKS_ENOUGH. */
#define SIDE_PX                64
#define SIDE_FILTERED_PX       128
#define SIDE_FILTERED_LARGE_PX 256
#define BLOCKS_ENOUGH          64

static bool is_filtered(const struct plan *plan)
{
    return plan->paths.spp == 0 && plan->shadow_filter != SHADOW_FILTER_NONE;
}

int32_t block_side_px(const struct plan *plan)
{
    int64_t large = (int64_t)SIDE_FILTERED_LARGE_PX * SIDE_FILTERED_LARGE_PX;
    if (!is_filtered(plan)) return SIDE_PX;
    return (int64_t)plan->width_px * plan->height_px < BLOCKS_ENOUGH * large
               ? SIDE_FILTERED_PX
               : SIDE_FILTERED_LARGE_PX;
}

/* Pixels beside a block whose lighting the resolve borrows. */
static int32_t ring_px(const struct plan *plan)
{
    return plan->paths.spp == 0 && plan->sub_samples > 0 ? PATCH_RING_PX : 0;
}

/* The light of the ring is filtered as that of the block is. */
int32_t block_halo_px(const struct plan *plan)
{
    return ring_px(plan) + (is_filtered(plan) ? shadow_halo_px(plan->shadow_filter) : 0);
}

static bool contains(struct rect outer, struct rect inner)
{
    return inner.x0 >= outer.x0 && inner.y0 >= outer.y0 && inner.x1 <= outer.x1 &&
           inner.y1 <= outer.y1 && !rect_is_empty(inner);
}

static uint64_t thread_cpu_us(void)
{
    struct timespec t;
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t) != 0) return 0;
    return (uint64_t)t.tv_sec * 1000000u + (uint64_t)t.tv_nsec / 1000u;
}

static int reconstruct_light_field(const struct plan *plan, const struct patch *patch,
                                   struct rect block, struct image *image,
                                   struct block_statistics *statistics)
{
    struct lighting lighting;
    struct resolver resolver;
    struct rect lit = rect_intersect(rect_grow(block, ring_px(plan)), patch->core);
    uint64_t start_us = thread_cpu_us();
    int error = lighting_create(plan, patch, lit, &lighting, &statistics->shadow);
    if (error) return error;
    if (is_filtered(plan)) statistics->shadow_cpu_us = thread_cpu_us() - start_us;
    resolver_init(&resolver, plan, patch, &lighting);
    compose_light_field(&resolver, block, image, statistics);
    lighting_fini(&lighting);
    return 0;
}

int block_reconstruct(const struct plan *plan, const struct patch *patch, struct rect block,
                      struct image *image, struct block_statistics *statistics)
{
    struct rect whole = {0, 0, image->width_px, image->height_px};
    int error = 0;
    *statistics = (struct block_statistics){0};
    if (!contains(patch->core, block) || !contains(whole, block)) return ERR_RANGE;
    if (plan->paths.spp > 0)
        paths_compose(patch, block, image, statistics);
    else
        error = reconstruct_light_field(plan, patch, block, image, statistics);
    if (!error) compose_centre(plan, patch, block, image);
    return error;
}
