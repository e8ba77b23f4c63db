#include "worker/trace/hit/primary.h"

#include "worker/trace/hit/hit_kernels.h"

static void trace(struct queries *q, const struct plan *plan, struct lanes_mask valid,
                  const float px[LANES], const float py[LANES], struct RTCRayHit16 *rays,
                  struct surface *out)
{
    q->kernels->camera_rays(plan, px, py, &rays->ray);
    queries_sanitise(q, &valid, &rays->ray);
    queries_closest(q, QUERY_CAMERA, &valid, rays);
    hit_resolve(q, &valid, rays, out);
}

void primary_trace(struct queries *q, const struct plan *plan, const struct block *b,
                   struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float px[LANES], py[LANES];
    for (int i = 0; i < LANES; i++) {
        px[i] = (float)b->x_px[i] + 0.5f;
        py[i] = (float)b->y_px[i] + 0.5f;
    }
    trace(q, plan, b->inside, px, py, rays, out);
}

void primary_trace_row(struct queries *q, const struct plan *plan, int32_t x, int32_t y,
                       uint32_t count, struct primary_packet *row)
{
    q->rejected += q->kernels->camera_row(plan, x, y, count, row);
    for (uint32_t k = 0; k < count; k++)
        queries_closest(q, QUERY_CAMERA, &row[k].valid, &row[k].rays);
}

void primary_trace_sub(struct queries *q, const struct plan *plan, const struct block *b,
                       uint32_t k, uint32_t count, struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float px[LANES], py[LANES];
    struct pattern_pixels pattern;
    pattern_pixels_init(&plan->pattern, count, &pattern);
    q->kernels->place_subs(&pattern, b, k, px, py);
    trace(q, plan, b->inside, px, py, rays, out);
}

void primary_trace_pixel(struct queries *q, const struct plan *plan, int32_t x, int32_t y,
                         uint32_t first, uint32_t count, struct RTCRayHit16 *rays, float px[LANES],
                         float py[LANES], struct surface *out)
{
    struct lanes_mask all;
    float jitter[2];
    pattern_jitter(&plan->pattern, x, y, PATTERN_PIXEL, jitter);
    for (uint32_t i = 0; i < LANES; i++) {
        px[i] = (float)x + pattern_golden_at(jitter, first + i, count, 0);
        py[i] = (float)y + pattern_golden_at(jitter, first + i, count, 1);
        all.on[i] = -1;
    }
    trace(q, plan, all, px, py, rays, out);
}
