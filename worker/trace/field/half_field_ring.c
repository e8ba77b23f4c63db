#include "worker/trace/field/half_field_ring.h"

/* Where the nodes lie beside the block's first pixel. */
static const int8_t places[HALF_FIELD_RING][2] = {{-1, -1}, {1, -1}, {3, -1}, {-1, 1}, {-1, 3}};

void half_field_show(const struct surface_view *view, const struct surface *s, int i, int32_t x,
                     int32_t y, struct shown_surface *out)
{
    const float normal[3] = {s->normal.x[i], s->normal.y[i], s->normal.z[i]};
    shown_surface_init(view, (float)x + 0.5f, (float)y + 0.5f, surface_distance(s->distance[i]),
                       normal, surface_sub_id(s->id[i]), out);
}

void half_field_ring_see(struct queries *q, const struct plan *plan, const struct block *block,
                         struct RTCRayHit16 *rays, struct half_field_ring *ring,
                         struct counters *counters)
{
    struct block around = *block;
    for (int i = 0; i < LANES; i++) {
        const int k = i < HALF_FIELD_RING ? i : 0;
        const int32_t x = block->x_px[0] + places[k][0], y = block->y_px[0] + places[k][1];
        const bool inside = x >= 0 && y >= 0 && x < plan->width_px && y < plan->height_px;
        around.x_px[i] = x;
        around.y_px[i] = y;
        around.inside.on[i] = i == k && inside ? -1 : 0;
    }
    surface_view_init(&ring->view, plan);
    primary_trace(q, plan, &around, rays, &ring->surface);
    for (int k = 0; k < HALF_FIELD_RING; k++) {
        ring->is_there[k] = around.inside.on[k] && ring->surface.hit.on[k];
        if (ring->is_there[k])
            half_field_show(&ring->view, &ring->surface, k, around.x_px[k], around.y_px[k],
                            &ring->shown[k]);
    }
    counters->value[COUNTER_RAYS_PRIMARY] += lanes_count(&around.inside);
}

bool half_field_ring_shows(const struct half_field_ring *ring, int32_t x0, int32_t y0, int32_t x,
                           int32_t y, const struct shown_surface *pixel)
{
    for (int k = 0; k < HALF_FIELD_RING; k++) {
        if (!half_field_is_beside(x - x0, y - y0, places[k][0], places[k][1])) continue;
        if (!ring->is_there[k] ||
            surface_match(&ring->view, pixel, &ring->shown[k]) < HALF_FIELD_MATCH)
            return false;
    }
    return true;
}
