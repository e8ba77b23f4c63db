#include "server/reconstruct/block.h"

#include "server/reconstruct/compose.h"
#include "server/reconstruct/paths.h"

int32_t block_halo_px(const struct plan *plan)
{
    if (plan->paths.spp > 0) return 0;    /* a plain mean */
    return plan->sub_samples > 0 ? 1 : 0; /* the resolve's 3 x 3 pixels */
}

static bool contains(struct rect outer, struct rect inner)
{
    return inner.x0 >= outer.x0 && inner.y0 >= outer.y0 && inner.x1 <= outer.x1 &&
           inner.y1 <= outer.y1 && !rect_is_empty(inner);
}

static int reconstruct_light_field(const struct plan *plan, const struct patch *patch,
                                   struct rect block, struct image *image,
                                   struct block_statistics *statistics)
{
    struct lighting lighting;
    struct resolver resolver;
    int error = lighting_create(plan, patch, &lighting);
    if (error) return error;
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
    if (!contains(patch->rect, block) || !contains(whole, block)) return ERR_RANGE;
    if (plan->paths.spp > 0)
        paths_compose(patch, block, image, statistics);
    else
        error = reconstruct_light_field(plan, patch, block, image, statistics);
    if (!error) compose_centre(plan, patch, block, image);
    return error;
}
