#include "worker/trace/field/edge_pixels.h"

#include <stdlib.h>

#include "worker/trace/hit/geometry.h"
#include "worker/trace/hit/primary.h"

/* What centres are traced with. */
struct centre_view {
    struct RTCRayHit16 rays;
    struct surface surface;
    struct block block;
};

static void see_centres(const struct path_context *c, struct rect tile, struct centre_view *v,
                        struct samples *samples)
{
    struct geometry_planes planes;
    geometry_planes_init(&planes, samples);
    queries_init_rays(&v->rays);
    for (int32_t y = tile.y0 & -LANES_ACROSS; y < tile.y1; y += LANES_ACROSS)
        for (int32_t x = tile.x0 & -LANES_ACROSS; x < tile.x1; x += LANES_ACROSS) {
            block_init(&v->block, x, y, c->plan->width_px, c->plan->height_px, tile);
            primary_trace(c->queries, c->plan, &v->block, &v->rays, &v->surface);
            geometry_store(c->queries, &v->block, &v->surface, &planes);
            c->counters->value[COUNTER_RAYS_PRIMARY] += lanes_count(&v->block.kept);
        }
}

static int create_centres(const struct path_context *c, struct rect tile, struct samples **out)
{
    static const uint8_t no_lights[LIMIT_LIGHTS] = {0};
    struct samples_layout layout;
    const int error = samples_layout_subset(&layout, c->plan, 0, rect_width(tile),
                                            rect_height(tile), PLANES_CENTRE, no_lights);
    return error ? error : samples_create(&layout, out);
}

int edge_pixels_find(const struct path_context *c, struct rect tile, struct lone_finder *lone,
                     struct mixed_finder *finder)
{
    struct samples *centres = NULL;
    struct centre_view *view = aligned_alloc(LANES_ALIGN, sizeof *view);
    int error = view ? create_centres(c, tile, &centres) : ERR_MEMORY;
    if (!error) {
        see_centres(c, tile, view, centres);
        lone_finder_init(lone, c, tile, centres);
        error = mixed_finder_look_around(finder, c, lone, centres);
    }
    samples_destroy(&centres);
    free(view);
    return error;
}
